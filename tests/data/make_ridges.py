#!/usr/bin/env python3
"""Writes ridges.json: wavenumbers of a shot record by DASCore 0.1's phase-shift transform.

The record: a band of waves of frequencies from 2 to 25 Hz, 1/8 apart, amplitude one, whose phase velocity is
c(f) = 2 + 3 / (1 + (f / 12)^2), with noise from a linear congruential generator; the same in
tests/analysis/ridges.rs. The phase-shift transform (C. B. Park, R. D. Miller, J. Xia, SEG Technical Program
1998, 1377) sums phases over sites for each frequency and phase velocity; its maximum at each frequency is the
phase velocity. The samples of the transform are as fine as 0.002 m/s.
"""

import json
import pathlib

import dascore as dc
import numpy as np
from dascore.transform.dispersion import dispersion_phase_shift

NT, NX, DT, DX = 512, 48, 1 / 64, 0.05
speed = lambda f: 2 + 3 / (1 + (f / 12) ** 2)


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


t, x = np.arange(NT) * DT, np.arange(NX) * DX
field = noise(5, NT * NX).reshape(NT, NX)
phases = 2 * np.pi * noise(9, 200)
frequencies = np.arange(2, 25, 0.125)
for f, phase in zip(frequencies, phases):
    field += np.cos(2 * np.pi * f * (t[:, None] - x / speed(f)) + phase)

patch = dc.Patch(
    data=field.T,
    coords={"distance": x, "time": np.datetime64(0, "ns") + (t * 1e9).astype("timedelta64[ns]")},
    dims=("distance", "time"),
)
velocities = np.arange(1.5, 6, 0.002)
found = dispersion_phase_shift(patch, velocities, approx_resolution=0.125, approx_freq=[1, 28])
axis = np.asarray(found.get_coord("frequency").values)
data = np.asarray(found.data)
if found.dims[0] != "velocity":
    data = data.T
inside = (axis > 3) & (axis < 23)
best = velocities[np.argmax(data[:, inside], axis=0)]
# Bin m of its transform is of m / 8 Hz, where its axis has m 64 / 511; its phases are those of the axis.
bins = np.round(axis[inside] * (NT - 1) * DT)
k = 2 * np.pi * axis[inside] / best
print(dc.__version__, len(k), np.abs(k / (2 * np.pi * bins / 8 / speed(bins / 8)) - 1).max())
result = {"frequency": (bins / 8).tolist(), "wavenumber": k.tolist()}
pathlib.Path(__file__).with_name("ridges.json").write_text(json.dumps(result) + "\n")
