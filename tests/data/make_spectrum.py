#!/usr/bin/env python3
"""Writes spectrum.json: spectra with adaptive weights, their jackknife and the F-test, of three records.

Records: integers of a linear congruential generator, the same in tests/analysis/peers.rs. References: nitime
0.12 (`adaptive_weights`, `jackknifed_sdf_variance`), multitaper 1.2 (`ftest`), SciPy 1.17 (`welch`, `chi2`,
`dpss`). nitime ends its iteration early, where the error depends on the scale of the samples; here it is made
to go on. It does not iterate where the first two tapers are 150 dB below the peak by its count: null. Its jackknife estimates the variance of the samples anew without each taper, which moves it by up to a
percent; the same without that, in NumPy, is written beside it.
"""

import json
import pathlib
import warnings
from unittest import mock

import numpy as np
from multitaper.utils import ftest
from nitime import utils
from scipy import signal, stats

COUNT, DT, NW, K = 400, 0.25, 4, 7


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


white = noise(1, COUNT)
# A steep spectrum, over ten decades: tapers leak.
steep = signal.lfilter([1], [1, -2.7607, 3.8106, -2.6535, 0.9238], noise(2, COUNT + 200))[200:]
times = np.arange(COUNT)
line = noise(3, COUNT) + 0.7 * np.cos(2 * np.pi * 0.1225 * times + 0.3)
records = [white, steep, line]

tapers, concentration = signal.windows.dpss(COUNT, NW, K, return_ratios=True)
fold = np.where(np.isin(np.arange(COUNT // 2 + 1), [0, COUNT // 2]), 1, 2)
bins = COUNT // 2 + 1


def fixed_point(eigen, ratios, variance):
    """Over frequencies, with the weights: Percival and Walden (1993), eq. 368a and 370a."""
    found = eigen.mean(axis=0)
    for _ in range(5000):
        weights = ratios[:, None] / (ratios[:, None] * found + (1 - ratios[:, None]) * variance) ** 2
        new = (weights * eigen).sum(axis=0) / weights.sum(axis=0)
        if np.all(abs(new - found) <= 1e-15 * new):
            break
        found = new
    return found, weights


def multitaper(record):
    transforms = np.fft.fft(tapers * (record - record.mean()), axis=1)
    eigen = abs(transforms) ** 2
    variance = (concentration[:, None] ** 2 * eigen).sum() / (concentration**2).sum() / COUNT
    found, weights = fixed_point(eigen, concentration, variance)
    degrees = 2 * weights.sum(axis=0) ** 2 / (weights**2).sum(axis=0)
    without = []
    for k in range(K):
        others = [i for i in range(K) if i != k]
        without.append(np.log(fixed_point(eigen[others], concentration[others], variance)[0]))
    without = np.array(without)
    deviation = np.sqrt((K - 1) / K * ((without - without.mean(axis=0)) ** 2).sum(axis=0))
    with warnings.catch_warnings(), mock.patch("numpy.percentile", lambda *_: 1.0):
        warnings.simplefilter("ignore")
        theirs, _ = utils.adaptive_weights(transforms, concentration, sides="twosided", max_iter=2000)
        variance_of_log = utils.jackknifed_sdf_variance(transforms, concentration, sides="twosided")
    weighted = (theirs**2 * eigen).sum(axis=0) / (theirs**2).sum(axis=0)
    first = (concentration[:2, None] ** 2 * eigen[:2]).sum(axis=0)
    weighted[first < 10 ** (-150 / 20) * first.max()] = np.nan
    statistic, _ = ftest(tapers.T, transforms.T)
    halves = np.where(fold == 1, 2, 1)
    degrees = degrees[:bins] / halves
    return {
        "spectrum": (found[:bins] * DT * fold).tolist(),
        "nitime": [None if np.isnan(s) else s for s in (weighted[:bins] * DT * fold).tolist()],
        "degrees": degrees.tolist(),
        "low": (found[:bins] * DT * fold * degrees / stats.chi2.ppf(0.975, degrees)).tolist(),
        "high": (found[:bins] * DT * fold * degrees / stats.chi2.ppf(0.025, degrees)).tolist(),
        "jackknife": (deviation[:bins] * stats.t.ppf(0.975, K - 1)).tolist(),
        # By the factor of Thomson and Chave (1991), without the later (K - 1) / (K - 1/2).
        "nitime_jackknife": (
            np.sqrt(variance_of_log[:bins] * (K - 0.5) / (K - 1)) * stats.t.ppf(0.975, K - 1)
        ).tolist(),
        "f": statistic[:bins, 0].tolist(),
    }


def welch(record, length, overlap):
    _, found = signal.welch(record, 1 / DT, "hann", length, overlap, detrend="constant")
    return found.tolist()


found = {
    "multitaper": [multitaper(record) for record in records],
    "welch": [welch(record, 64, 32) for record in records],
    "periodogram": [signal.periodogram(record, 1 / DT, detrend="constant")[1].tolist() for record in records],
}
path = pathlib.Path(__file__).with_name("spectrum.json")
path.write_text(json.dumps(found) + "\n")
