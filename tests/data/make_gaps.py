#!/usr/bin/env python3
"""Writes gaps.json: spectra and coherence of records with gaps, of segments picked by hand, with SciPy 1.17.

Records: integers of a linear congruential generator, the same in tests/analysis/peers.rs, with missing samples at
the places below. A segment counts if none of its samples is missing; spectra and cross-spectra of single segments
are SciPy's, their mean, the effective number (Welch 1967, eq. 12, over all pairs) and the jackknife NumPy's.
"""

import json
import pathlib

import numpy as np
from scipy import signal, stats

COUNT, DT, SEGMENT, OVERLAP, ALPHA = 600, 0.25, 64, 32, 0.05
MISSING = [[], [5, 130, 131, 407], list(range(250, 420)), list(range(0, COUNT, 40))]


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


common = noise(7, COUNT)
records = [noise(seed, COUNT) + common for seed in (1, 2, 3, 4)]
for record, missing in zip(records, MISSING):
    record[missing] = np.nan
HOP = SEGMENT - OVERLAP
starts = np.arange(0, COUNT - SEGMENT + 1, HOP)
window = signal.get_window("hann", SEGMENT)
DPSS = signal.windows.dpss(SEGMENT, 2, 3)


def kept(*sites):
    whole = lambda s: all(np.isfinite(records[j][s : s + SEGMENT]).all() for j in sites)
    return [s for s in starts if whole(s)]


def effective(starts, tapers):
    placed = []
    for start in starts:
        for taper in tapers:
            row = np.zeros(COUNT)
            row[start : start + SEGMENT] = taper / np.sqrt((taper**2).sum())
            placed.append(row)
    placed = np.array(placed)
    return len(placed) ** 2 / ((placed @ placed.T) ** 2).sum()


def welch(j):
    found = kept(j)
    if not found:
        return {"segments": 0, "effective": 0, "spectrum": None, "low": None, "high": None, "jackknife": None}
    how = {"fs": 1 / DT, "window": window, "detrend": "constant"}
    each = np.array([signal.periodogram(records[j][s : s + SEGMENT], **how)[1] for s in found])
    mean, count, k = each.mean(axis=0), len(found), effective(found, [window])
    nu = 2 * k * np.ones(len(mean))
    nu[[0, -1]] /= 2
    without = np.log((each.sum(axis=0) - each) / (count - 1))
    variance = ((without - without.mean(axis=0)) ** 2).sum(axis=0) * (count - 1) / count
    half = stats.t.ppf(1 - ALPHA / 2, k - 1) * np.sqrt(variance * count / k)
    return {
        "segments": count,
        "effective": k,
        "spectrum": mean.tolist(),
        "low": (mean * nu / stats.chi2.ppf(1 - ALPHA / 2, nu)).tolist(),
        "high": (mean * nu / stats.chi2.ppf(ALPHA / 2, nu)).tolist(),
        "jackknife": half.tolist(),
    }


def tapered(j):
    """Slepian tapers with equal weights."""
    tapers = DPSS / np.sqrt((DPSS**2).sum(axis=1))[:, None]
    segments = [records[j][s : s + SEGMENT] for s in kept(j)]
    if not segments:
        return None
    each = [abs(np.fft.rfft(tapers * (v - v.mean()), axis=1)) ** 2 for v in segments]
    folds = np.where(np.isin(np.arange(SEGMENT // 2 + 1), [0, SEGMENT // 2]), 1, 2)
    return (np.concatenate(each).mean(axis=0) * DT * folds).tolist()


def coherence(j):
    """With site 1."""
    found = kept(1, j)
    if not found:
        return None
    how = {"fs": 1 / DT, "window": window, "nperseg": SEGMENT, "noverlap": 0, "detrend": "constant"}
    mean = lambda a, b: np.mean([signal.csd(a[s : s + SEGMENT], b[s : s + SEGMENT], **how)[1] for s in found], axis=0)
    a, b = records[1], records[j]
    value = abs(mean(a, b)) ** 2 / (mean(a, a).real * mean(b, b).real)
    level = 1 - ALPHA ** (1 / (effective(found, [window]) - 1))
    return {"segments": len(found), "coherence": value.tolist(), "level": level}


found = {
    "missing": MISSING,
    "welch": [welch(j) for j in range(4)],
    "tapered": [tapered(j) for j in range(4)],
    "coherence": [coherence(j) for j in range(4)],
    "together": {"segments": len(kept(0, 1, 2)), "effective": effective(kept(0, 1, 2), [window])},
}
path = pathlib.Path(__file__).with_name("gaps.json")
path.write_text(json.dumps(found) + "\n")
