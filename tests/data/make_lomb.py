#!/usr/bin/env python3
"""Writes lomb.json: Lomb-Scargle periodograms of uneven records as astropy 8 has them.

Times n + 0.4 noise, a sixth of them left out, and a sine in noise from a linear congruential generator; the same
in tests/analysis/lomb.rs. `fit_mean`, normalisations standard and psd, levels by Baluev's bound.
"""

import json
import pathlib

import astropy
import numpy as np
from astropy.timeseries import LombScargle

COUNT, DT = 180, 0.5


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


n = np.arange(COUNT)
t = 100 + DT * (n + 0.4 * noise(3, COUNT))
v = 7 + noise(4, COUNT) + 0.5 * np.cos(2 * np.pi * 0.313 * t + 1)
there = n % 6 != 4
length = t[-1] - t[0]
frequency = np.arange(1, 449) / (5 * length)
ls = LombScargle(t[there], v[there])
power = ls.power(frequency, method="slow")
psd = LombScargle(t[there], v[there], normalization="psd").power(frequency, method="slow")
highest = 0.5 / (length / (COUNT - 1))
level = ls.false_alarm_level(0.05, method="baluev", maximum_frequency=highest)
alarm = ls.false_alarm_probability(power.max(), method="baluev", maximum_frequency=highest)
print(astropy.__version__, power.max(), level, alarm)
result = {"power": power.tolist(), "psd": psd.tolist(), "level": float(level), "false_alarm": float(alarm)}
pathlib.Path(__file__).with_name("lomb.json").write_text(json.dumps(result) + "\n")
