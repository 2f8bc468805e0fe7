"""The accessor ``cascade`` of ``xarray.DataArray`` and ``xarray.Dataset``."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any

import xarray as xr

from wavecascade._commands import analysis, chains, estimates

# Untyped in xarray.
_register: Any = xr


def _method(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function on fields as a method of the accessor."""

    @functools.wraps(function)
    def method(self: FieldAccessor, *others: Any, **options: Any) -> Any:
        return function(self._field, *others, **options)

    return method


@_register.register_dataarray_accessor("cascade")
class FieldAccessor:
    """A field with its functions: ``da.cascade.analyze()`` is ``wavecascade.analyze(da)``."""

    def __init__(self, field: xr.DataArray) -> None:
        self._field = field

    analyze = _method(analysis.analyze)
    filter = _method(analysis.filter)
    temporal_spectrum = _method(analysis.temporal_spectrum)
    spatial_spectrum = _method(analysis.spatial_spectrum)
    bicoherence = _method(estimates.bicoherence)
    coherence = _method(estimates.coherence)
    increments = _method(estimates.increments)
    modes = _method(estimates.modes)
    ridges = _method(estimates.ridges)
    slope = _method(estimates.slope)
    spectrum = _method(estimates.spectrum)
    triads = _method(chains.triads)


@_register.register_dataset_accessor("cascade")
class AnalysisAccessor:
    """The result of an analysis: ``ds.cascade.report("out.html")``."""

    def __init__(self, analysis: xr.Dataset) -> None:
        self._analysis = analysis

    def report(self, path: str | os.PathLike[str]) -> None:
        """As :func:`wavecascade.report`."""
        analysis.report(self._analysis, path)
