"""Contact laws from functions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

#: Points of a table, at first and at most.
_FIRST, _MOST = 33, 8193


def law(
    force: Callable[[np.ndarray], np.ndarray], least: float, most: float, *, error: float = 1e-6
) -> str:
    """A contact law from a function of the overlap, as a table that scenes take.

    F(d) = force(d) for least <= d <= most, a monotone cubic between points so dense that it differs
    from the function by ``error`` at most, relative to the largest force.

    Parameters
    ----------
    force
        The force at an array of overlaps, in N and m for a scene in SI; 0 at the overlap 0.
    least, most
        The overlaps between which the law is known; beyond, the force goes on along a line, and a
        run warns.
    error
        Largest difference from the function, relative to its largest value.

    Returns
    -------
    str
        For ``wc.simulate(law=...)``, or in ``laws=[...]``.

    Raises
    ------
    ValueError
        For a range without 0, a force other than 0 there, and a function that 8193 points do not follow.
    """
    if not (np.isfinite([least, most]).all() and least <= 0 < most):
        raise ValueError(f"law: expected a range with the overlap 0 in it, found {least} to {most}")
    count, off = _FIRST, np.inf
    while count <= _MOST:
        overlap = np.linspace(least, most, count)
        overlap[np.argmin(np.abs(overlap))] = 0.0
        overlap = np.unique(overlap)
        values = np.asarray(force(overlap), float)
        if values.shape != overlap.shape or not np.isfinite(values).all():
            raise ValueError("law: expected a finite force for each overlap of an array")
        if values[overlap == 0.0] != 0.0:
            raise ValueError(
                f"law: expected no force at the overlap 0, found {values[overlap == 0.0][0]}"
            )
        middle = 0.5 * (overlap[1:] + overlap[:-1])
        between = _middle(overlap, values)
        off = np.abs(between - force(middle)).max() / np.abs(values).max()
        if off <= error:
            rows = zip(overlap.tolist(), values.tolist(), strict=True)
            return "table " + ", ".join(f"{d!r} {f!r}" for d, f in rows)
        count = 2 * count - 1
    raise ValueError(f"law: expected a function that {_MOST} points follow to {error}, found {off:.1e}")


def _middle(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The cubic of a table in the middle of its pieces; slopes of Fritsch and Butland."""
    h, rise = np.diff(x), np.diff(y) / np.diff(x)
    first, second = 2 * h[1:] + h[:-1], h[1:] + 2 * h[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        inner = (first + second) / (first / rise[:-1] + second / rise[1:])
    inner[rise[:-1] * rise[1:] <= 0] = 0.0
    ends = rise[[0, -1]]
    slope = np.concatenate([ends[:1], inner, ends[1:]])
    return 0.5 * (y[1:] + y[:-1]) + h * (slope[:-1] - slope[1:]) / 8
