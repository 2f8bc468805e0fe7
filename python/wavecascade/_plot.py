"""Results on axes of matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

#: What answers a result's question, of all that may be in it.
_MAIN = (
    # Of an analysis.
    "temporal_spectrum",
    "spatial_spectrum",
    "spacetime_spectrum",
    # Of estimates.
    "spectrum",
    "mean_spectrum",
    "coherence",
    "delay",
    "eigenvalues",
    "gain",
    "power",
    "compensated",
    "space_structure",
    "time_structure",
    "total_plus",
    "total_minus",
    "loss_factor",
    # Of chains.
    "velocity",
    "force",
    "kinetic_energy",
    "flux",
    "energy_passed",
    "transfer",
)
#: Points of results that are lists of points: ordinate, abscissa, colour.
_POINTS = {
    "branch": ("frequency", "wavenumber", "branch"),
    "biphase": ("second", "first", "bicoherence"),
}
#: Whose values, and whose scales, are powers.
_LOGARITHMIC = ("spectrum", "eigenvalues", "structure", "power", "compensated")


def drawn(result: Any, names: str | Sequence[str] | None, axes: Any) -> Any:
    """The axes on which the variables of a result are drawn."""
    import matplotlib.pyplot as plt

    points = next((found for mark, found in _POINTS.items() if mark in result.variables), None)
    if names is None and points is not None:
        flat = _axes_of(plt, axes, 1)
        _scatter(flat[0], result, points)
        return flat
    if names is None:
        drawable = [name for name in _MAIN if name in result and result[name].size]
        chosen = [name for name in drawable if result[name].ndim in (1, 2)]
        others = [name for name in result.data_vars if result[name].ndim in (1, 2)]
        chosen = chosen or others[:4]
    else:
        chosen = [names] if isinstance(names, str) else list(names)
    known = [str(name) for name in result.data_vars]
    for name in chosen:
        if name not in result or result[name].ndim not in (1, 2):
            found = f"{result[name].ndim} dimensions of {name}" if name in result else name
            raise ValueError(
                f"names: expected variables of one or two dimensions, of {known}, found {found}"
            )
    flat = _axes_of(plt, axes, len(chosen))
    for place, name in zip(flat, chosen, strict=True):
        _one(place, result[name], result)
    return flat


def _axes_of(plt: Any, axes: Any, count: int) -> Any:
    if count == 0:
        raise ValueError("result: expected variables of one or two dimensions, found none")
    if axes is None:
        _, axes = plt.subplots(1, count, figsize=(5.0 * count, 4.0), layout="constrained", squeeze=False)
    flat = np.atleast_1d(np.asarray(axes, object)).ravel()
    if len(flat) != count:
        raise ValueError(f"axes: expected {count}, one a variable, found {len(flat)}")
    return flat


def _scatter(place: Any, result: Any, points: tuple[str, str, str]) -> None:
    y, x, colour = (result[name] for name in points)
    drawn = place.scatter(x.values, y.values, c=colour.values, s=12)
    place.figure.colorbar(drawn, ax=place, label=_label(colour))
    place.set(xlabel=_label(x), ylabel=_label(y))


def _label(array: Any) -> str:
    unit = array.attrs.get("units")
    return f"{str(array.name).replace('_', ' ')} [{unit}]" if unit else str(array.name).replace("_", " ")


def _one(place: Any, array: Any, result: Any) -> None:
    """A map of two dimensions, a line of one with its interval."""
    from matplotlib.colors import LogNorm

    values = np.asarray(array.values, float)
    finite = values[np.isfinite(values)]
    is_power = any(word in str(array.name) for word in _LOGARITHMIC) and (finite > 0).any()
    if array.ndim == 2:
        largest = float(finite.max(initial=0.0))
        norm = (
            LogNorm(max(float(finite[finite > 0].min()), 1e-8 * largest), largest) if is_power else None
        )
        xs, ys = array.dims[1], array.dims[0]
        array.plot.pcolormesh(ax=place, x=xs, y=ys, norm=norm)
        return
    array.plot.line(ax=place)
    low, high = _interval(array, result)
    if low is not None:
        place.fill_between(array[array.dims[0]], low, high, alpha=0.3)
    if is_power:
        place.set_yscale("log")


def _interval(array: Any, result: Any) -> tuple[Any, Any]:
    """The ends of the interval that a result states beside a variable."""
    for suffix in ("_error", "_half"):
        name = f"{array.name}{suffix}"
        if name in result and result[name].dims == array.dims:
            return array - result[name], array + result[name]
    return None, None
