"""Arrays of NumPy, xarray and Dask, with their coordinates and units, as samples of a field."""

from __future__ import annotations

import os
from collections.abc import Mapping, MutableMapping
from typing import Any, TypeGuard

import numpy as np

from wavecascade import _native

#: Names of dimensions, as the readers of files know them.
_TIMES = {"time", "t", "times"}
_SITES = {"space", "position", "site", "x", "distance", "channel", "trace", "offset", "sites"}
_OF_FILES = ("variable", "header", "time_column", "delays", "read", "position_from")

Coordinates = tuple[list[float], float, str | None, float | None]


def is_path(field: object) -> TypeGuard[str | os.PathLike[str]]:
    """Whether ``field`` names a file."""
    return isinstance(field, (str, os.PathLike))


def is_dataarray(field: object) -> bool:
    """Whether ``field`` is an ``xarray.DataArray``, without importing xarray."""
    return type(field).__name__ == "DataArray" and hasattr(field, "dims")


def unit_text(unit: object) -> str | None:
    """A unit as text, of pint without the spaces."""
    if unit is None:
        return None
    text = f"{unit:~}" if hasattr(unit, "dimensionality") else str(unit)
    text = text.replace(" ", "") if hasattr(unit, "dimensionality") else text.strip()
    return text or None


def plain(values: Any) -> tuple[np.ndarray[Any, Any], str | None]:
    """The numbers of an array and its unit: gaps of masked arrays are NaN, Dask is computed."""
    unit: str | None = None
    if hasattr(values, "magnitude") and hasattr(values, "units"):
        values, unit = values.magnitude, unit_text(values.units)
    if hasattr(values, "compute") and hasattr(values, "dask"):
        values = values.compute()
    if isinstance(values, np.ma.MaskedArray):
        if np.ma.is_masked(values):
            is_float = np.issubdtype(values.dtype, np.floating)
            floats: Any = values.astype(values.dtype if is_float else np.float64)
            values = floats.filled(np.nan)
        else:
            values = values.data
    return np.asarray(values), unit


def _since(values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], str | None]:
    """Dates and durations as seconds, dates from the first one, and that one."""
    unit: Any = np.datetime_data(values.dtype)[0]
    ticks = values.astype(f"{values.dtype.kind}8[{unit}]").astype(np.int64)
    if values.dtype.kind == "m":
        return ticks * (np.timedelta64(1, unit) / np.timedelta64(1, "s")), None
    first = values[0] if len(values) else None
    per_second = np.timedelta64(1, "s") / np.timedelta64(1, unit)
    return (ticks - ticks[:1]) / per_second, None if first is None else str(first)


def _coordinates(coordinate: Any) -> tuple[Coordinates, str | None]:
    """Values, rounding, unit and step of a coordinate, and the date from which it counts."""
    attrs = getattr(coordinate, "attrs", {})
    values, unit = plain(getattr(coordinate, "data", coordinate))
    start = None
    if values.dtype.kind in "mM":
        values, start = _since(values)
        unit = "s"
    unit = unit or unit_text(attrs.get("units"))
    largest = float(np.max(np.abs(values), initial=0.0))
    is_single = values.dtype.kind == "f" and values.dtype.itemsize < 8
    relative = float(np.finfo(values.dtype).eps) if is_single else 2.0**-52
    step = attrs.get("step")
    listed = values.astype(np.float64).tolist()
    return (listed, largest * relative, unit, None if step is None else float(step)), start


def _dims(field: Any, options: Mapping[str, object]) -> tuple[str, str | None]:
    """The dimensions of times and of sites."""
    dims = [str(dim) for dim in field.dims]
    given = [options.get("time_dim"), options.get("space_dim")]

    def named(place: int, names: set[str]) -> str | None:
        stated = given[place]
        if stated is not None:
            name = dims[int(str(stated))] if str(stated).isdigit() else str(stated)
            if name not in dims:
                option = ("time_dim", "space_dim")[place]
                raise ValueError(f"{option}: expected one of {', '.join(dims)}, found {name}")
            return name
        return next((dim for dim in dims if dim.lower() in names), None)

    time, space = named(0, _TIMES), named(1, _SITES)
    if time is None:
        dated = (d for d in dims if d in field.coords and field.coords[d].dtype.kind in "mM")
        time = next(dated, None)
    rest = [dim for dim in dims if dim not in (time, space)]
    if time is None and space is not None and len(rest) == 1:
        time = rest[0]
    elif space is None and time is not None and len(rest) == 1:
        space = rest[0]
    elif time is None and space is None and len(dims) <= 2:
        first_is_site = options.get("layout") == "site-time" and len(dims) == 2
        time, space = dims[::-1] if first_is_site else [*dims, None][:2]
    if time is None or len(set(dims) - {time, space}) > 0:
        raise ValueError(
            f"field: expected a dimension of times and one of sites, found {', '.join(dims)}; "
            "state `time_dim` and `space_dim`, and take one place of the others with `at` or `isel`"
        )
    return time, space


def _taken(field: Any, options: MutableMapping[str, object]) -> Any:
    """The part of further dimensions that ``at`` names."""
    at = options.pop("at", None)
    if at is None:
        return field
    if not isinstance(at, Mapping):
        texts = [at] if isinstance(at, str) else list(at)  # type: ignore[call-overload]
        at = dict(text.split("=", 1) for text in texts)
    for name, place in at.items():
        if isinstance(place, str) and place.startswith("#"):
            field = field.isel({name: int(place[1:])})
        else:
            field = field.sel({name: float(place)}, method="nearest")
    return field


def samples(field: Any, options: MutableMapping[str, object]) -> _native.Samples:
    """An array with what is known of it; options that are used up here are removed."""
    for option in _OF_FILES:
        if options.get(option) is not None:
            raise ValueError(f"{option}: expected a file, whose option it is, found an array")
    if not is_dataarray(field):
        for option in ("time_dim", "space_dim", "at"):
            if options.get(option) is not None:
                raise ValueError(f"{option}: expected named dimensions, found an array without")
        values, unit = plain(field)
        return _native.Samples(values, name="field", unit=unit)
    field = _taken(field, options)
    time, space = _dims(field, options)
    for option in ("layout", "time_dim", "space_dim"):
        options.pop(option, None)
    field = field.transpose(*([time] if space is None else [time, space]))
    values, unit = plain(field.data)
    axes: dict[str, Coordinates | None] = {"time": None, "space": None}
    start = None
    for axis, dim in (("time", time), ("space", space)):
        if dim is not None and dim in field.coords:
            axes[axis], since = _coordinates(field.coords[dim])
            start = start or since
    name = None if field.name is None else str(field.name)
    return _native.Samples(
        values,
        name=name or "field",
        quantity=field.attrs.get("standard_name") or name,
        unit=unit or unit_text(field.attrs.get("units")),
        time=axes["time"],
        space=axes["space"],
        axis_names=(time, space),
        start=start,
        is_layout_known=True,
    )


def source(
    field: Any, options: MutableMapping[str, object]
) -> _native.Samples | list[str | os.PathLike[str]]:
    """What the native half opens: paths, or the samples of an array."""
    if is_path(field):
        return [os.fspath(field)]
    if isinstance(field, (list, tuple)) and field and all(is_path(one) for one in field):
        return [os.fspath(one) for one in field]
    return samples(field, options)
