"""Arrays of NumPy, xarray and Dask, with their coordinates and units, as samples of a field."""

from __future__ import annotations

import datetime
import os
from collections.abc import Mapping, MutableMapping
from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np

from wavecascade import _native
from wavecascade._arrays.labelled import SITES, TIMES, Coordinate, Labelled, labelled
from wavecascade._keywords.advice import OF_FILES
from wavecascade._keywords.words import unit_text

#: Names of dimensions of repeated records.
SHOTS = {"shot", "shots", "realisation", "realization", "member", "ensemble", "trial", "repetition"}


#: Values, rounding, unit and step.
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


def plain(values: Any) -> tuple[np.ndarray[Any, Any], str | None]:
    """The numbers of an array and its unit: gaps of masked arrays are NaN, Dask is computed."""
    unit: str | None = None
    if hasattr(values, "magnitude") and hasattr(values, "units"):
        values, unit = values.magnitude, unit_text(values.units)
    elif hasattr(values, "value") and hasattr(values, "unit"):
        values, unit = values.value, unit_text(values.unit)
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


def _numbers(values: Any) -> tuple[np.ndarray[Any, Any], str | None, str | None]:
    """Values of a coordinate with their unit; dates in seconds from the first, and that one."""
    if hasattr(values, "to_timestamp"):
        # Periods, which count from their begin.
        values = values.to_timestamp()
    if getattr(values.dtype, "tz", None) is not None:
        values = values.tz_convert(None)
    numbers, unit = plain(values)
    if numbers.dtype.kind in "mM":
        tick: Any = np.datetime_data(numbers.dtype)[0]
        ticks = numbers.astype(f"{numbers.dtype.kind}8[{tick}]").astype(np.int64)
        if numbers.dtype.kind == "m":
            return ticks * (np.timedelta64(1, tick) / np.timedelta64(1, "s")), "s", None
        first = str(numbers[0]) if len(numbers) else None
        return (ticks - ticks[:1]) / (np.timedelta64(1, "s") / np.timedelta64(1, tick)), "s", first
    if numbers.dtype.kind == "O" and len(numbers):
        # Dates of other calendars, or of pandas.
        dates = [getattr(one, "start_time", one) for one in numbers]
        if hasattr(dates[0], "year"):
            second = datetime.timedelta(seconds=1)
            return np.array([(one - dates[0]) / second for one in dates], float), "s", str(dates[0])
        numbers = numbers.astype(np.float64)
    return numbers, unit, None


def _coordinates(coordinate: Any) -> tuple[Coordinates, str | None]:
    """Values, rounding, unit and step of a coordinate, and the date from which it counts."""
    attrs = getattr(coordinate, "attrs", {})
    values, unit, start = _numbers(getattr(coordinate, "data", coordinate))
    unit = unit or unit_text(attrs.get("units"))
    counts, since, date = (unit or "").partition(" since ")
    if since and values.dtype.kind in "iu" and len(values):
        # Counted from the first, since numbers of digits go to the years before it.
        unit = f"{counts} since {date} + {values[0]} {counts}" if values[0] else unit
        values = values - values[0]
    largest = float(np.max(np.abs(values), initial=0.0))
    is_single = values.dtype.kind == "f" and values.dtype.itemsize < 8
    relative = float(np.finfo(values.dtype).eps) if is_single else 2.0**-52
    step = attrs.get("step")
    listed = values.astype(np.float64).tolist()
    found = (listed, largest * relative, unit, None if step is None else float(step))
    return found, start or attrs.get("start")


@dataclass(frozen=True)
class Dims:
    """The dimensions of a field."""

    time: str
    space: str | None
    #: Those over which it is mapped.
    others: tuple[str, ...] = ()
    #: Whether names, dates or the caller say which is which.
    is_known: bool = True


def dims_of(field: Any, options: Mapping[str, object]) -> Dims:
    """Which dimensions of a labelled array are times and sites."""
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

    time, space = named(0, TIMES), named(1, SITES)
    if time is None:
        dated = (d for d in dims if d in field.coords and field.coords[d].dtype.kind in "mM")
        time = next(dated, None)
    is_known = True
    rest = [dim for dim in dims if dim not in (time, space)]
    if time is None and space is not None and len(rest) == 1:
        time = rest.pop()
    elif space is None and time is not None and len(rest) == 1:
        space = rest.pop()
    elif time is None and space is None and len(dims) <= 2:
        first_is_site = options.get("layout") == "site-time" and len(dims) == 2
        time, space = dims[::-1] if first_is_site else [*dims, None][:2]
        is_known, rest = options.get("layout") is not None, []
    if time is None or (space is None and rest):
        raise ValueError(
            f"field: expected a dimension of times and one of sites, found {', '.join(dims)}; "
            "state `time_dim` and `space_dim`"
        )
    return Dims(time, space, tuple(rest), is_known)


def _taken(field: Any, options: MutableMapping[str, object]) -> Any:
    """The part of further dimensions that ``at`` names."""
    at = options.pop("at", None)
    if at is None:
        return field
    if not isinstance(at, Mapping):
        texts = [at] if isinstance(at, str) else list(at)  # type: ignore[call-overload]
        at = dict(text.split("=", 1) for text in texts)
    for name, place in at.items():
        if name not in field.dims:
            raise ValueError(f"at: expected one of {', '.join(map(str, field.dims))}, found {name}")
        if isinstance(place, str) and place.startswith("#"):
            field = field.isel({name: int(place[1:])})
        elif name in field.coords:
            values, _ = plain(field.coords[name].data)
            field = field.isel({name: int(np.argmin(np.abs(values - float(place))))})
        else:
            raise ValueError(f"at: expected coordinates of {name}, found none; count as `{name}=#0`")
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
        field = of_dataset(field, options)
    found = labelled(field)
    if found is not None:
        field = found
        dims = [str(name) for name in field.dims]
        if dim is not None and dim not in dims:
            raise ValueError(f"shot_dim: expected one of {', '.join(dims)}, found {dim}")
        if dim is None:
            dim = next((name for name in dims if name.lower() in SHOTS), None)
        return [field] if dim is None else [field.isel({dim: i}) for i in range(field.sizes[dim])]
    if dim is not None:
        raise ValueError("shot_dim: expected named dimensions, found an array without")
    own = 1 if is_record else 2
    return list(field) if getattr(field, "ndim", 0) == own + 1 else [field]


def pair(one: Any, two: Any) -> Any:
    """The records of two sites as a field; a scalar coordinate of both says where they are."""
    records = [labelled(one), labelled(two)]
    if any(record is None for record in records):
        first, second = plain(one)[0], plain(two)[0]
        if first.ndim != 1 or first.shape != second.shape:
            raise ValueError(
                "other: expected two records of one dimension and of one length, "
                f"found shapes {first.shape} and {second.shape}"
            )
        return np.stack([first, second], axis=1)
    # A trace is a field of one site.
    records = [one.isel({d: 0 for d in one.dims[1:] if one.sizes[d] == 1}) for one in records]
    for name, record in zip(("field", "other"), records, strict=True):
        if record.ndim != 1:
            raise ValueError(f"{name}: expected a record of one dimension, found {record.ndim}")
    first, second = records
    dim = str(first.dims[0])
    if tuple(second.dims) != (dim,) or dict(second.sizes) != dict(first.sizes):
        raise ValueError(
            f"other: expected a record like the first, {dict(first.sizes)}, found {dict(second.sizes)}"
        )
    coords: dict[str, Coordinate] = {}
    if dim in first.coords and dim in second.coords:
        times = [_coordinates(record.coords[dim]) for record in records]
        if times[0] != times[1]:
            raise ValueError(f"other: expected the same {dim} as of the first record, found others")
    if dim in first.coords:
        along = first.coords[dim]
        coords[dim] = Coordinate(along.data, (dim,), along.attrs)
    known = {
        str(name).lower(): str(name)
        for name in first.coords
        if first.coords[name].ndim == 0 and name in second.coords and second.coords[name].ndim == 0
    }
    space = next((known[name] for name in sorted(known) if name in SITES), None)
    if space is not None:
        places = [record.coords[space] for record in records]
        values = [float(np.asarray(place.data)) for place in places]
        if values[0] != values[1]:
            coords[space] = Coordinate(np.array(values), (space,), places[0].attrs)
    numbers = np.stack([plain(record.data)[0] for record in records], axis=1)
    return Labelled(numbers, (dim, space or "site"), coords, first.attrs, first.name)


def of_dataset(data: Any, options: MutableMapping[str, object]) -> Any:
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
        field = of_dataset(data, options)
        run = _run(data)
    if options.get("variable") == str(getattr(field, "name", None)):
        # One place of a variable of a dataset, which is mapped over.
        options.pop("variable")
    for option in OF_FILES:
        if options.get(option) is not None:
            raise ValueError(f"{option}: expected a file, whose option it is, found an array")
    found = None if is_path(field) else labelled(field)
    if found is None:
        for option in ("time_dim", "space_dim", "at"):
            if options.get(option) is not None:
                raise ValueError(f"{option}: expected named dimensions, found an array without")
        values, unit = plain(field)
        return _native.Samples(values, name="field", unit=unit)
    field = _taken(found, options)
    dims = dims_of(field, options)
    if dims.others:
        raise ValueError(
            f"field: expected times and sites, found {', '.join(map(str, field.dims))}; "
            "take one place of the others with `at`"
        )
    time, space = dims.time, dims.space
    for option in ("layout", "time_dim", "space_dim"):
        options.pop(option, None)
    field = field.transpose(*([time] if space is None else [time, space]))
    values, unit = plain(field.data)
    packed = [key for key in ("scale_factor", "add_offset", "_FillValue") if key in field.attrs]
    if packed and values.dtype.kind in "iu":
        raise ValueError(
            f"field: expected samples, found {values.dtype} packed by {', '.join(packed)}; "
            "unpack them with xarray.decode_cf(dataset), or read the file by its path"
        )
    axes: dict[str, Coordinates | None] = {"time": None, "space": None}
    start = None
    for axis, dim in (("time", time), ("space", space)):
        if dim is not None and dim in field.coords:
            axes[axis], since = _coordinates(field.coords[dim])
            start = start or since
    name = None if field.name is None else str(field.name)
    attrs = field.attrs
    return _native.Samples(
        values,
        name=name or "field",
        quantity=attrs.get("standard_name") or attrs.get("data_type") or name,
        unit=unit or unit_text(attrs.get("units", attrs.get("data_units"))),
        time=axes["time"],
        space=axes["space"],
        axis_names=(time, space),
        start=start,
        is_layout_known=dims.is_known,
        **run,
    )


def opened_dims(field: Any, options: Mapping[str, object]) -> Any:
    """A field with axes as ``(time, site)``, if it is opened as it is; ``None`` for others."""
    known = labelled(of_dataset(field, dict(options)) if is_dataset(field) else field)
    stated = ("dt", "dx", "t0", "x0", "rate", "fs", "resample", "select", "at")
    if known is None or any(options.get(option) is not None for option in stated):
        return None
    dims = dims_of(known, options)
    return known.transpose(*([dims.time] if dims.space is None else [dims.time, dims.space]))


def source(
    field: Any, options: MutableMapping[str, object]
) -> _native.Samples | list[str | os.PathLike[str]]:
    """What the native half opens: paths, or the samples of an array."""
    if is_path(field):
        return [os.fspath(field)]
    if isinstance(field, (list, tuple)) and field and all(is_path(one) for one in field):
        return [os.fspath(one) for one in field]
    return samples(field, options)
