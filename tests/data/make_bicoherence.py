#!/usr/bin/env python3
"""Writes bicoherence.json: bicoherence and biphase of two records.

pybispectra 1.3.2 gives <X1 X2 X3*> of sums of frequencies; its normalisation (threenorm) is another, so the
moments below are NumPy's direct sums, as is <X1 X2 X3*> of differences. stingray 2.3.2 has no bicoherence.

Records: integers of a linear congruential generator, the same in tests/analysis/peers.rs.
"""

import json
import pathlib

import numpy as np
import pybispectra

COUNT, SEGMENT, OVERLAP = 1000, 32, 16


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


a, b = noise(1, COUNT), noise(2, COUNT)
records = [a + 0.5 * a**2, np.roll(a, 1) ** 2 + 0.3 * b]
window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(SEGMENT) / SEGMENT)
starts = range(0, COUNT - SEGMENT + 1, SEGMENT - OVERLAP)
segments = np.array([[record[s : s + SEGMENT] for record in records] for s in starts])
segments -= segments.mean(axis=2, keepdims=True)
spectra = np.fft.rfft(segments * window, axis=2)
LAST = (SEGMENT - 1) // 2
LEAST = 2  # bins that a Hann window does not mix


def of_pybispectra(site, output):
    frequencies = np.arange(spectra.shape[2], dtype=float)
    indices = ((site,), (site,), (output,))
    bispectrum = pybispectra.Bispectrum(spectra, frequencies, SEGMENT, verbose=False)
    bispectrum.compute(indices=indices)
    return bispectrum.results.get_results(copy=False)[0]


def of(site, output, differences):
    peer = of_pybispectra(site, output)
    seconds = [s for s in range(1 - LAST if differences else 1, LAST // 2 + 1) if abs(s) >= LEAST]
    found = {"bins": [], "bicoherence": [], "biphase": []}
    for second in seconds:
        for first in range(1, LAST + 1):
            if first < (second if second > 0 else 1 - second) or first + second > LAST:
                continue
            if second < 0 and abs(first + 2 * second) < LEAST:
                continue
            x1, x2 = spectra[:, site, first], spectra[:, site, abs(second)]
            x2 = x2 if second > 0 else x2.conj()
            x3 = spectra[:, output, first + second]
            mean = (x1 * x2 * x3.conj()).mean()
            if second > 0:
                assert abs(mean - peer[second, first]) < 1e-13 * np.nanmax(abs(peer)), (first, second)
                mean = peer[second, first]
            bound = (abs(x1 * x2) ** 2).mean() * (abs(x3) ** 2).mean()
            found["bins"].append([first, second, first + second])
            found["bicoherence"].append(abs(mean) ** 2 / bound)
            found["biphase"].append(np.angle(mean))
    return found


found = {"own": of(0, 0, False), "cross": of(0, 1, True)}
path = pathlib.Path(__file__).with_name("bicoherence.json")
path.write_text(json.dumps(found) + "\n")
