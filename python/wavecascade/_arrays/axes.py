"""The axes of a field, without a look at its samples."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from wavecascade._arrays.fields import dims_of, is_dataarray
from wavecascade._keywords.options import FieldOptions

#: Options of fields that say nothing of axes.
_OTHERS = frozenset({"time_dim", "space_dim", "layout", "at", "select", "read", "memory", "header"})
#: What can be stated of axes.
AXES = (
    frozenset(FieldOptions.__annotations__) - _OTHERS - {"resample", "delays", "variable", "time_column"}
)


@dataclass(frozen=True)
class Axes:
    """Steps, first coordinates and units of a field."""

    dt: float
    dx: float
    t0: float
    x0: float
    #: Of time, space, value, frequency and wavenumber; ``None`` where it is not known.
    units: Mapping[str, str | None]
    #: Of ``temporal`` and ``spacetime`` spectra, by their scaling.
    spectra: Mapping[tuple[str, str], str | None]

    def agrees(self, other: Axes) -> bool:
        """Whether records along both axes have the same steps and units."""
        steps = ((self.dt, other.dt), (self.dx, other.dx))
        is_near = all(abs(a - b) <= 1e-6 * abs(a) for a, b in steps)
        return is_near and dict(self.units) == dict(other.units)

    def frequency(self, n: int) -> np.ndarray[Any, Any]:
        """Frequencies m / (n dt), m = 0 .. n / 2, in cycles."""
        return np.arange(n // 2 + 1) / (n * self.dt)

    def wavenumber(self, n: int) -> np.ndarray[Any, Any]:
        """Wavenumbers 2 pi m / (n dx), m = 0 .. n / 2, in rad."""
        return 2.0 * np.pi * np.arange(n // 2 + 1) / (n * self.dx)

    def wavenumber_signed(self, n: int) -> np.ndarray[Any, Any]:
        """Wavenumbers of both signs, ascending, in rad."""
        return 2.0 * np.pi * (np.arange(n) - n // 2) / (n * self.dx)

    def positions(self, first: int, n: int) -> np.ndarray[Any, Any]:
        """Positions of ``n`` sites from the one with index ``first`` on."""
        return self.x0 + (first + np.arange(n)) * self.dx


@dataclass(frozen=True)
class Placed:
    """The samples of a field as ``(time, site)``, not computed, and its axes."""

    samples: Any
    axes: Axes
    dims: tuple[str, str]

    @property
    def is_lazy(self) -> bool:
        """Whether the samples are a Dask array."""
        return hasattr(self.samples, "dask")


def placed(field: Any, options: Mapping[str, object]) -> Placed:
    """The samples and the axes of an array of NumPy, Dask, Zarr or xarray.

    Raises
    ------
    ValueError
        For more or fewer dimensions than times and sites, and for coordinates that are not even.
    """
    unknown = [name for name in options if name not in AXES | {"time_dim", "space_dim", "layout"}]
    if unknown:
        raise TypeError(f"got an unexpected keyword argument {unknown[0]!r}")
    said = {name: value for name, value in options.items() if name in AXES and value is not None}
    if is_dataarray(field):
        dims = dims_of(field, options)
        time, space = dims.time, dims.space
        if dims.others:
            raise ValueError(f"field: expected times and sites, found {', '.join(map(str, field.dims))}")
        if space is None:
            raise ValueError("field: expected times and sites, found one dimension")
        ordered = field.transpose(time, space)
        n_times, n_sites = ordered.shape
        zeros = np.broadcast_to(np.float64(0.0), (n_times, 1))
        along_time = ordered.isel({space: slice(0, 1)}).copy(data=zeros)
        zeros = np.broadcast_to(np.float64(0.0), (min(2, n_times), n_sites))
        along_space = ordered.isel({time: slice(0, 2)}).copy(data=zeros)
        axes = _axes(along_time, along_space, {**said, "time_dim": time, "space_dim": space}, n_times)
        return Placed(ordered.data, axes, (time, space))
    shape = tuple(getattr(field, "shape", np.shape(field)))
    if len(shape) != 2:
        raise ValueError(f"field: expected times and sites, found {len(shape)} dimensions")
    if options.get("layout") == "site-time":
        field, shape = field.T, shape[::-1]
    return Placed(field, _stated(tuple(sorted(said.items()))), ("time", "position"))


@lru_cache(maxsize=64)
def _stated(options: tuple[tuple[str, Any], ...]) -> Axes:
    """The axes of an array that has no coordinates."""
    zeros = np.broadcast_to(np.float64(0.0), (16, 2))
    return _axes(zeros, zeros, {**dict(options), "layout": "time-site"}, 16)


def _axes(along_time: Any, along_space: Any, options: dict[str, object], n_times: int) -> Axes:
    """What the program makes of the coordinates of fields of zeros."""
    from wavecascade._commands.analysis import quiet

    def found(field: Any, **more: Any) -> tuple[dict[str, Any], dict[str, str | None]]:
        result = quiet(field, {**options, **more})
        attrs = result["attrs"] if isinstance(result, dict) else result.attrs
        units: dict[str, str | None] = {}
        if not isinstance(result, dict):
            units = {name: result[name].attrs.get("units") for name in result.data_vars}
        return attrs, units

    spectra: dict[tuple[str, str], str | None] = {}
    for scaling in ("density", "energy", "spectrum"):
        time, units = found(along_time, scaling=scaling, only="temporal", segment=min(n_times, 8))
        spectra["temporal", scaling] = units.get("temporal_spectrum")
        space, units = found(along_space, scaling=scaling, only="spacetime")
        spectra["spacetime", scaling] = units.get("spacetime_spectrum")
    units = json.loads(time["units"])
    others = json.loads(space["units"])
    units |= {name: others[name] for name in ("space", "wavenumber")}
    return Axes(
        float(time["dt"]), float(space["dx"]), float(time["t0"]), float(space["x0"]), units, spectra
    )
