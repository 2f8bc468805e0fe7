"""Writes spacetime.json: space-time spectra by NumPy's transforms and SciPy's windows.

Needs numpy and scipy. The fields are those of `tests/analysis/peers.rs`: numbers of a linear congruential
generator, row by row.
"""

import json
from pathlib import Path

import numpy as np
from scipy.signal import detrend
from scipy.signal.windows import dpss, get_window

DT, DX = 0.25, 0.5


def field(times, sites):
    values, state = [], 5
    for _ in range(times * sites):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.reshape(values, (times, sites))


def spectrum(values, segment, hop, time_tapers, space_tapers, kind):
    times, sites = values.shape
    total, count = 0.0, 0
    for start in range(0, times - segment + 1, hop):
        part = values[start : start + segment]
        if kind:
            part = detrend(part, axis=0, type=kind)
        for w in time_tapers:
            for u in space_tapers:
                w, u = w / np.sqrt(sum(w**2)), u / np.sqrt(sum(u**2))
                x = np.fft.fft(part * w[:, None] * u, axis=0)[: segment // 2 + 1]
                x = np.fft.fftshift(np.fft.ifft(x, axis=1) * sites, axes=1)
                total = total + abs(x) ** 2
                count += 1
    fold = np.full(segment // 2 + 1, 2.0)
    fold[0] = 1
    if segment % 2 == 0:
        fold[-1] = 1
    return (fold[:, None] * total / count * DT * DX / (2 * np.pi)).ravel().tolist()


def adaptive(values, nw, time_count, space_nw, space_count):
    """Thomson's weights over pairs of tapers: w = l / (l S + (1 - l) v)^2, by iteration until nothing moves."""
    times, sites = values.shape
    w, along_time = dpss(times, nw, time_count, return_ratios=True)
    u, along_space = dpss(sites, space_nw, space_count, return_ratios=True)
    energies, shares = [], []
    for a, la in zip(w, along_time):
        for b, lb in zip(u, along_space):
            x = np.fft.fft(values * a[:, None] * b, axis=0)[: times // 2 + 1]
            energies.append(abs(np.fft.fftshift(np.fft.ifft(x, axis=1) * sites, axes=1)) ** 2)
            shares.append(la * lb)
    energies, shares = np.array(energies), np.array(shares)
    fold = np.full(times // 2 + 1, 2.0)
    fold[0] = 1
    if times % 2 == 0:
        fold[-1] = 1
    power = (fold[:, None] * energies).sum(axis=(1, 2)) / (times * sites)
    variance = (shares**2 * power).sum() / (shares**2).sum()
    mean, l = energies.mean(axis=0), shares[:, None, None]
    for _ in range(1000):
        weights = l / (l * mean / variance + 1 - l) ** 2
        mean = (weights * energies).sum(axis=0) / weights.sum(axis=0)
    degrees = 2 * weights.sum(axis=0) ** 2 / (weights**2).sum(axis=0)
    # Transforms at f = 0, k = 0 are real; odd lengths have no Nyquist frequency.
    degrees[0, sites // 2] /= 2
    density = fold[:, None] * mean * DT * DX / (2 * np.pi)
    return [density.ravel().tolist(), degrees.ravel().tolist()]


def steep(times, sites):
    n, j = np.arange(times)[:, None], np.arange(sites)
    return 1e3 * np.cos(0.9 * n - 1.1 * j) + field(times, sites)


found = {
    "welch": spectrum(
        field(52, 10), 16, 8, [get_window("hann", 16)], [get_window("hann", 10)], "constant"
    ),
    "tapers": spectrum(
        field(45, 9), 45, 45, dpss(45, 2, 3), dpss(9, 2, 2), None
    ),
    "steep": adaptive(steep(45, 9), 2.5, 4, 2, 3),
}
Path(__file__).with_name("spacetime.json").write_text(json.dumps(found))
