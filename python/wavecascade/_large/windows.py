"""Windows and sums in the order of operations of the program, for what is transformed over a store."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

NAMES = "none, hann, hamming, blackman-harris, flat-top, tukey[:SHARE], or an array of weights"

_SUMS = {
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),
    "flat-top": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
}
#: Terms that are added plainly before sums are paired, and those that are added side by side.
_LEAF, _LANES = 256, 8


def pairwise_sum(x: Array) -> Array:
    """Sum over the second axis of ``(segment, sample, ...)``: pairwise, by a tree of the length alone."""
    n = x.shape[1]
    if n > _LEAF:
        half = -(-(n // 2) // _LEAF) * _LEAF
        return pairwise_sum(x[:, :half]) + pairwise_sum(x[:, half:])
    whole = n // _LANES * _LANES
    lanes = np.zeros((x.shape[0], _LANES, *x.shape[2:]))
    for at in range(0, whole, _LANES):
        lanes += x[:, at : at + _LANES]
    tail = np.zeros((x.shape[0], *x.shape[2:]))
    for at in range(whole, n):
        tail += x[:, at]
    a, b, c, d, e, f, g, h = (lanes[:, i] for i in range(_LANES))
    return (((a + e) + (b + f)) + ((c + g) + (d + h))) + tail


def sum_of(x: Array) -> float:
    """The same of one record."""
    return float(pairwise_sum(np.asarray(x, np.float64)[None, :])[0])


def _cos_turns(p: int, q: int) -> float:
    """cos(2 pi p / q), reduced to an eighth of a cycle in integers."""
    p %= q
    p = min(p, q - p)
    if 8 * p <= q:
        return math.cos(math.pi * (2 * p / q))
    if 4 * p <= q:
        return math.sin(math.pi * ((q - 4 * p) / (2 * q)))
    if 8 * p < 3 * q:
        return -math.sin(math.pi * ((4 * p - q) / (2 * q)))
    return -math.cos(math.pi * ((q - 2 * p) / q))


def window(name: object, n: int) -> Array:
    """The ``n`` samples of a window in its periodic form, or an array of as many weights.

    Raises
    ------
    ValueError
        For a name that is none, weights of another length, and weights that are all 0.
    """
    if not isinstance(name, str):
        weights = np.array(name, np.float64)
        if weights.shape != (n,) or not np.isfinite(weights).all() or not weights.any():
            raise ValueError(
                f"window: expected {n} finite weights, one a sample, found an array of {weights.shape}"
            )
        return weights
    base, _, parameter = name.partition(":")
    try:
        share = float(parameter) if parameter else 0.25
    except ValueError:
        share = math.nan
    known = base in ("none", *_SUMS) and not parameter
    if not known and not (base == "tukey" and 0.0 <= share <= 1.0):
        raise ValueError(f"window: expected {NAMES}, found {name!r}")
    if n <= 1:
        return np.ones(n)

    def sample(j: int) -> float:
        if base == "none" or (base == "tukey" and 2.0 * j >= share * n):
            return 1.0
        if base == "tukey":
            s = math.sin(math.pi * (j / (share * n)))
            return s * s
        total = 0.0
        for k, a in enumerate(_SUMS[base]):
            total += a * _cos_turns(2 * k * j + k * n, 2 * n)
        return total

    half = [sample(j) for j in range(n // 2 + 1)]
    return np.array([half[min(j, n - j)] for j in range(n)])
