"""The accessor ``cascade`` of ``xarray.DataArray`` and ``xarray.Dataset``."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import xarray as xr

from wavecascade import _plot
from wavecascade._commands import analysis
from wavecascade._commands.estimates import EstimateMethods
from wavecascade._commands.methods import method


class FieldAccessor(EstimateMethods):
    """A field with its functions: ``da.cascade.analyze()`` is ``wavecascade.analyze(da)``.

    Checkers of types see its keywords through ``field: wc.FieldAccessor = da.cascade``, since xarray's
    accessors have no type of their own.
    """

    def __init__(self, field: xr.DataArray) -> None:
        self._field = field

    analyze = method(analysis.analyze)
    filter = method(analysis.filter)
    plan = method(analysis.plan)
    temporal_spectrum = method(analysis.temporal_spectrum)
    spatial_spectrum = method(analysis.spatial_spectrum)


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
