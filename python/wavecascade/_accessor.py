"""The accessor ``cascade`` of ``xarray.DataArray`` and ``xarray.Dataset``."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from typing import Any, Concatenate, ParamSpec, TypeVar

import xarray as xr

from wavecascade import _plot
from wavecascade._commands import analysis, estimates

P = ParamSpec("P")
R = TypeVar("R")


def _method(function: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[FieldAccessor, P], R]:
    """A function on fields as a method of the accessor, with its keywords."""

    @functools.wraps(function)
    def method(self: FieldAccessor, /, *others: P.args, **options: P.kwargs) -> R:
        return function(self._field, *others, **options)

    return method


class FieldAccessor:
    """A field with its functions: ``da.cascade.analyze()`` is ``wavecascade.analyze(da)``.

    Checkers of types see its keywords through ``field: wc.FieldAccessor = da.cascade``, since xarray's
    accessors have no type of their own.
    """

    def __init__(self, field: xr.DataArray) -> None:
        self._field = field

    analyze = _method(analysis.analyze)
    filter = _method(analysis.filter)
    plan = _method(analysis.plan)
    temporal_spectrum = _method(analysis.temporal_spectrum)
    spatial_spectrum = _method(analysis.spatial_spectrum)
    bicoherence = _method(estimates.bicoherence)
    coherence = _method(estimates.coherence)
    increments = _method(estimates.increments)
    modes = _method(estimates.modes)
    ridges = _method(estimates.ridges)
    slope = _method(estimates.slope)
    spectrum = _method(estimates.spectrum)


class ResultAccessor:
    """A result: ``ds.cascade.report("out.html")``, ``ds.cascade.plot()``."""

    def __init__(self, result: xr.Dataset) -> None:
        self._result = result

    def report(self, path: str | os.PathLike[str]) -> None:
        """As :func:`wavecascade.report`."""
        analysis.report(self._result, path)

    def plot(self, names: str | Sequence[str] | None = None, axes: Any = None) -> Any:
        """Draw the main variables of a result, or those of these names.

        Parameters
        ----------
        names
            Variables of one or two dimensions.
        axes
            Axes of matplotlib to draw on, one a variable; by default those of a new figure.

        Returns
        -------
        numpy.ndarray
            The axes of matplotlib, one a variable.

        Raises
        ------
        ValueError
            For a variable that is not there, or has more dimensions.
        """
        return _plot.drawn(self._result, names, axes)


# Not as decorators, which are untyped in xarray and would hide the classes from checkers.
_register: Any = xr
_register.register_dataarray_accessor("cascade")(FieldAccessor)
_register.register_dataset_accessor("cascade")(ResultAccessor)
