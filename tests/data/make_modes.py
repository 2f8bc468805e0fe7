#!/usr/bin/env python3
"""Writes modes.json: eigenvalues and modes of spectral proper orthogonal decompositions.

    pip install numpy==2.4.6 pyspod==2.0.0

Records: two waves in noise, of integers of a linear congruential generator, the same in
tests/analysis/peers.rs. `numpy`: singular values and vectors of the scaled realisations, by `numpy.linalg.svd`.
`pyspod`: `pyspod.spod.standard.Standard` with its window replaced by the Hann window of this program (its own is a
symmetric Hamming window), scaled from its amplitudes to densities.
"""

import json
import pathlib
import tempfile

import numpy as np
import pyspod.spod.utils
from pyspod.spod.standard import Standard

COUNT, SITES, DT, DX, SEGMENT, HOP = 272, 11, 0.25, 0.5, 32, 16
BINS = [3, 4, 9]


def noise(seed, count):
    values, state = [], seed
    for _ in range(count):
        state = (1103515245 * state + 12345) % 2**31
        values.append(state / 2**30 - 1)
    return np.array(values)


def field(sites):
    t, x = DT * np.arange(COUNT)[:, None], DX * np.arange(sites)[None, :]
    wave = np.cos(0.9 * x - 2 * np.pi * 0.4 * t) + 0.7 * np.cos(0.4 * x + 2 * np.pi * 1.1 * t) * (1 + 0.1 * x)
    return wave + noise(1, COUNT * sites).reshape(COUNT, sites)


window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(SEGMENT) / SEGMENT)
folds = np.where(np.isin(np.arange(SEGMENT // 2 + 1), [0, SEGMENT // 2]), 1.0, 2.0)


def by_svd(v):
    """Of `X[site, realisation]`, with the modes' phases as motions `exp(-2 pi i f t)`."""
    starts = range(0, COUNT - SEGMENT + 1, HOP)
    segments = np.array([v[s : s + SEGMENT] for s in starts])
    segments = segments - segments.mean(axis=1, keepdims=True)
    x = np.fft.rfft(segments * window[None, :, None], axis=1)
    x *= np.sqrt(DT * DX / (window**2).sum() / len(starts) * folds)[None, :, None]
    values, modes = [], {}
    for m in range(SEGMENT // 2 + 1):
        u, s, _ = np.linalg.svd(x[:, m].T, full_matrices=False)
        values.append((s**2).tolist())
        if m in BINS:
            modes[m] = u.conj().T[:3] / np.sqrt(DX)
    return {
        "eigenvalues": values,
        "real": [modes[m].real.tolist() for m in BINS],
        "imag": [modes[m].imag.tolist() for m in BINS],
    }


def by_pyspod(v):
    pyspod.spod.utils._hamming_window = lambda n: window
    with tempfile.TemporaryDirectory() as folder:
        how = {
            "time_step": DT,
            "n_space_dims": 1,
            "n_variables": 1,
            "n_dft": SEGMENT,
            "overlap": 50,
            "mean_type": "blockwise",
            "savedir": folder,
        }
        spod = Standard(params=how)
        spod.fit(data_list=[v[:, :, None]])
        # Weights of 1; both signs of a frequency are counted already.
        scale = DT * DX * window.sum() ** 2 / (window**2).sum()
        return (spod.eigs.real * scale).tolist()


found = {
    "wide": by_svd(field(SITES * 2)),
    "narrow": by_svd(field(SITES)),
    "pyspod": by_pyspod(field(SITES * 2)),
}
path = pathlib.Path(__file__).with_name("modes.json")
path.write_text(json.dumps(found) + "\n")
