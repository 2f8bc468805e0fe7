"""The accessor ``cascade`` of ``xarray.DataArray`` and ``xarray.Dataset``."""

from __future__ import annotations

import os
from typing import Any, Unpack

import xarray as xr

from wavecascade import _analysis
from wavecascade._options import AnalyzeOptions, CoherenceOptions, FilterOptions
from wavecascade._words import Progress

# Untyped in xarray.
_register: Any = xr


@_register.register_dataarray_accessor("cascade")
class FieldAccessor:
    """A field with its functions: ``da.cascade.analyze()``."""

    def __init__(self, field: xr.DataArray) -> None:
        self._field = field

    def analyze(
        self, *, progress: Progress = None, maps: bool = True, **options: Unpack[AnalyzeOptions]
    ) -> Any:
        """As :func:`wavecascade.analyze`."""
        return _analysis.analyze(self._field, progress=progress, maps=maps, **options)

    def filter(self, **options: Unpack[FilterOptions]) -> Any:
        """As :func:`wavecascade.filter`."""
        return _analysis.filter(self._field, **options)

    def coherence(self, *, progress: Progress = None, **options: Unpack[CoherenceOptions]) -> Any:
        """As :func:`wavecascade.coherence`."""
        return _analysis.coherence(self._field, progress=progress, **options)

    def temporal_spectrum(self, **options: Unpack[AnalyzeOptions]) -> Any:
        """As :func:`wavecascade.temporal_spectrum`."""
        return _analysis.temporal_spectrum(self._field, **options)

    def spatial_spectrum(self, **options: Unpack[AnalyzeOptions]) -> Any:
        """As :func:`wavecascade.spatial_spectrum`."""
        return _analysis.spatial_spectrum(self._field, **options)


@_register.register_dataset_accessor("cascade")
class AnalysisAccessor:
    """The result of an analysis: ``ds.cascade.report("out.html")``."""

    def __init__(self, analysis: xr.Dataset) -> None:
        self._analysis = analysis

    def report(self, path: str | os.PathLike[str]) -> None:
        """As :func:`wavecascade.report`."""
        _analysis.report(self._analysis, path)
