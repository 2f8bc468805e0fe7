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
_SHOTS = {"shot", "shots", "realisation", "realization", "member", "ensemble", "trial", "repetition"}
_OF_FILES = ("variable", "header", "time_column", "delays", "read", "position_from")

Coordinates = tuple[list[float], float, str | None, float | None]


def is_path(field: object) -> TypeGuard[str | os.PathLike[str]]:
    """Whether ``field`` names a file."""
    return isinstance(field, (str, os.PathLike))


def is_dataarray(field: object) -> bool:
    """Whether ``field`` is an ``xarray.DataArray``, without importing xarray."""
    return type(field).__name__ == "DataArray" and hasattr(field, "dims")


def is_dataset(field: object) -> bool:
    """Whether ``field`` is an ``xarray.Dataset``, without importing xarray."""
    return type(field).__name__ == "Dataset" and hasattr(field, "data_vars")


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


def dims_of(field: Any, options: Mapping[str, object]) -> tuple[str, str | None]:
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


def shots(
    field: Any, options: MutableMapping[str, object], dim: object = None, is_record: bool = False
) -> list[Any]:
    """Repeated records: those of a sequence, of a leading dimension, or of a dimension of shots.

    Each is ``(time, site)``, or ``(time)`` where ``is_record``.
    """
    if isinstance(field, (list, tuple)):
        return list(field)
    if is_dataset(field):
        field = _of_dataset(field, options)
    if is_dataarray(field):
        dims = [str(name) for name in field.dims]
        if dim is not None and dim not in dims:
            raise ValueError(f"shot_dim: expected one of {', '.join(dims)}, found {dim}")
        if dim is None:
            dim = next((name for name in dims if name.lower() in _SHOTS), None)
        return [field] if dim is None else [field.isel({dim: i}) for i in range(field.sizes[dim])]
    if dim is not None:
        raise ValueError("shot_dim: expected named dimensions, found an array without")
    own = 1 if is_record else 2
    return list(field) if getattr(field, "ndim", 0) == own + 1 else [field]


def pair(one: Any, two: Any) -> Any:
    """The records of two sites as a field; a scalar coordinate of both says where they are."""
    if is_dataarray(one) and is_dataarray(two):
        import xarray

        for name, record in (("field", one), ("other", two)):
            if record.ndim != 1:
                raise ValueError(f"{name}: expected a record of one dimension, found {record.ndim}")
        dim = one.dims[0]
        if two.dims != one.dims or two.sizes != one.sizes:
            raise ValueError(
                f"other: expected a record like the first, {dict(one.sizes)}, found {dict(two.sizes)}"
            )
        if dim in one.coords and dim in two.coords and not one.indexes[dim].equals(two.indexes[dim]):
            raise ValueError(f"other: expected the same {dim} as of the first record, found others")
        numbers = [plain(record.data)[0] for record in (one, two)]
        coords = {dim: one.coords[dim]} if dim in one.coords else {}
        known = {
            str(name).lower(): str(name)
            for name in one.coords
            if one.coords[name].ndim == 0 and name in two.coords and two.coords[name].ndim == 0
        }
        space = next((known[name] for name in sorted(known) if name in _SITES), None)
        if space is not None:
            places = [record.coords[space] for record in (one, two)]
            if float(places[0]) != float(places[1]):
                coords[space] = (space, [float(place) for place in places], places[0].attrs)
        dims = (dim, space or "site")
        return xarray.DataArray(np.stack(numbers, axis=1), coords, dims, one.name, one.attrs)
    first, second = plain(one)[0], plain(two)[0]
    if first.ndim != 1 or first.shape != second.shape:
        raise ValueError(
            "other: expected two records of one dimension and of one length, "
            f"found shapes {first.shape} and {second.shape}"
        )
    return np.stack([first, second], axis=1)


def _of_dataset(data: Any, options: MutableMapping[str, object]) -> Any:
    """The array that ``variable`` names, else the velocity, else the only field."""
    fields = [str(name) for name in data.data_vars if data[name].ndim >= 2]
    name = options.pop("variable", None)
    if name is None:
        name = "velocity" if "velocity" in fields else fields[0] if len(fields) == 1 else None
    if name is None or name not in data:
        found = "none" if name is None else name
        raise ValueError(f"variable: expected one of {', '.join(fields)}, found {found}")
    return data[name]


def _run(data: Any) -> dict[str, Any]:
    """What a run says of its lattice, if ``data`` is one."""
    scene, time = data.attrs.get("scene"), data.coords.get("time")
    if not str(data.attrs.get("schema", "")).startswith("cascade.run/") or scene is None:
        return {}
    if time is None or len(time) < 2:
        return {}
    struck = data.attrs.get("struck_site")
    step = float(time[1] - time[0])
    return {"scene": (str(scene), step), "struck": None if struck is None else int(struck)}


def samples(field: Any, options: MutableMapping[str, object]) -> _native.Samples:
    """An array with what is known of it; options that are used up here are removed."""
    run: dict[str, Any] = {}
    if is_dataset(field):
        data = field
        field = _of_dataset(data, options)
        run = _run(data)
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
    time, space = dims_of(field, options)
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
        **run,
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
