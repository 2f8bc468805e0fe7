#!/usr/bin/env python3
"""Writes coherence.json: spectra, coherence and phase of three records as SciPy 1.17 has them.

Records: integers of a linear congruential generator, the same in tests/analysis/peers.rs. Averages over
Slepian tapers are made of SciPy's `dpss` and NumPy's `rfft`, with equal weights.
"""

import json
import pathlib

import numpy as np
from scipy import signal

COUNT, SHORT, DT, SEGMENT = 1000, 200, 0.25, 128


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


a, b = noise(1, COUNT + 3), noise(2, COUNT)
records = [a[3:], a[:-3] + 0.5 * b, b]


def welch(overlap):
    how = {"fs": 1 / DT, "window": "hann", "nperseg": SEGMENT, "noverlap": overlap, "detrend": "constant"}
    return {
        "spectrum": [signal.welch(record, **how)[1].tolist() for record in records],
        "coherence": [signal.coherence(records[0], record, **how)[1].tolist() for record in records],
        "phase": [np.angle(signal.csd(records[0], record, **how)[1]).tolist() for record in records],
    }


def multitaper(nw, count):
    """Of the first samples alone."""
    tapers = signal.windows.dpss(SHORT, nw, count)
    tapers /= np.sqrt((tapers**2).sum(axis=1))[:, None]
    short = [record[:SHORT] for record in records]
    transforms = [np.fft.rfft(tapers * (record - record.mean()), axis=1) for record in short]
    mean = lambda i, j: (transforms[i].conj() * transforms[j]).mean(axis=0)
    folds = np.where(np.isin(np.arange(SHORT // 2 + 1), [0, SHORT // 2]), 1, 2)
    return {
        "spectrum": [(mean(j, j).real * DT * folds).tolist() for j in range(3)],
        "coherence": [(abs(mean(0, j)) ** 2 / (mean(0, 0).real * mean(j, j).real)).tolist() for j in range(3)],
        "phase": [np.angle(mean(0, j)).tolist() for j in range(3)],
    }


found = {"welch": welch(SEGMENT // 2), "welch_96": welch(96), "multitaper": multitaper(4, 7)}
path = pathlib.Path(__file__).with_name("coherence.json")
path.write_text(json.dumps(found) + "\n")
