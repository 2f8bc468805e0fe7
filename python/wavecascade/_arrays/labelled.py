"""Objects with axes as one kind: an array with dimensions, coordinates and attributes.

A ``DataArray`` of xarray is one; a ``Patch`` of DASCore, a ``Stream`` or ``Trace`` of obspy, a
``DataFrame`` or ``Series`` of pandas become a :class:`Labelled`, which has as much of its interface as is
used here. They are known by what they have, so that none of the packages is needed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wavecascade._keywords.words import unit_text

#: What only objects have that know more of their samples than an array does.
_MARKS = ("coords", "columns", "stats", "traces", "dimensions", "xindex", "times", "schema")
#: `time (s)`, `x [mm]`: a name with its unit.
_NAME = re.compile(r"^\s*(?P<name>[^\[(]*?)\s*[\[(](?P<unit>[^\])]*)[\])]\s*$")

#: Names of dimensions, as the readers of files know them.
TIMES = {"time", "t", "times"}
SITES = {"space", "position", "site", "x", "distance", "channel", "trace", "offset", "sites"}


@dataclass(frozen=True)
class Coordinate:
    """Values along dimensions."""

    data: Any
    dims: tuple[str, ...]
    attrs: Mapping[str, Any] = field(default_factory=dict)

    @property
    def dtype(self) -> Any:
        return self.data.dtype

    @property
    def ndim(self) -> int:
        return len(self.dims)

    def along(self, dim: str, index: Any) -> Coordinate:
        """The values at one place, or at several, of a dimension."""
        if dim not in self.dims:
            return self
        axis = self.dims.index(dim)
        data = self.data[(slice(None),) * axis + (index,)]
        dims = self.dims if np.ndim(index) or isinstance(index, slice) else _without(self.dims, dim)
        return Coordinate(data, dims, self.attrs)


@dataclass(frozen=True)
class Labelled:
    """An array with its dimensions, as ``xarray.DataArray`` has them."""

    data: Any
    dims: tuple[str, ...]
    coords: Mapping[str, Coordinate] = field(default_factory=dict)
    attrs: Mapping[str, Any] = field(default_factory=dict)
    name: str | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(self.data.shape)

    @property
    def ndim(self) -> int:
        return len(self.dims)

    @property
    def dtype(self) -> Any:
        return self.data.dtype

    @property
    def sizes(self) -> dict[str, int]:
        return dict(zip(self.dims, self.shape, strict=True))

    def transpose(self, *dims: str) -> Labelled:
        order = [self.dims.index(dim) for dim in dims]
        return Labelled(self.data.transpose(order), dims, self.coords, self.attrs, self.name)

    def isel(self, places: Mapping[str, Any]) -> Labelled:
        data, dims, coords = self.data, self.dims, dict(self.coords)
        for dim, index in places.items():
            along = Coordinate(data, dims).along(dim, index)
            data, dims = along.data, along.dims
            coords = {name: one.along(dim, index) for name, one in coords.items()}
        return Labelled(data, dims, coords, self.attrs, self.name)


def _without(dims: tuple[str, ...], dim: str) -> tuple[str, ...]:
    return tuple(one for one in dims if one != dim)


def labelled(field: object) -> Any:
    """An object with axes as a DataArray or :class:`Labelled`; ``None`` for arrays, which have none.

    Raises
    ------
    TypeError
        For an object whose axes are not known here.
    """
    if type(field).__name__ == "DataArray" and hasattr(field, "dims"):
        return field
    if isinstance(field, Labelled):
        return field
    whole: Any = field
    coords = getattr(whole, "coords", None)
    if hasattr(coords, "get_array") and hasattr(whole, "dims"):
        return _of_patch(whole)
    if hasattr(whole, "traces"):
        return _of_traces(list(whole.traces))
    if hasattr(whole, "stats") and hasattr(whole, "data"):
        return _of_traces([whole])
    if hasattr(whole, "iloc") and hasattr(whole, "index"):
        return _of_table(whole.compute() if hasattr(whole, "compute") else whole)
    if isinstance(field, (list, tuple)):
        return None
    is_variable = type(field).__name__ == "Variable" and isinstance(getattr(whole, "dims", None), tuple)
    if is_variable and hasattr(whole, "attrs"):
        return Labelled(whole.data, tuple(map(str, whole.dims)), {}, whole.attrs)
    known = next((mark for mark in _MARKS if hasattr(field, mark)), None)
    if known is not None or field is None or isinstance(field, Mapping):
        kind = type(field)
        found = f"{kind.__module__.partition('.')[0]}.{kind.__name__}"
        raise TypeError(
            f"field: expected an array, or an object of xarray, pandas, DASCore or obspy, found {found}"
            f"{'' if known is None else f', whose axes are not read (`{known}`)'}; "
            "give its numbers as xarray.DataArray(values, coords, dims), or as array with `dt` and `dx`"
        )
    return None


def _of_patch(patch: Any) -> Labelled:
    """A patch of DASCore: coordinates with units, ``data_units``, ``data_type``."""
    dims = tuple(map(str, patch.dims))
    by_name = getattr(patch.coords, "dim_map", {dim: (dim,) for dim in dims})
    coords = {}
    for name, along in by_name.items():
        values = np.asarray(patch.coords.get_array(name))
        unit = None if values.dtype.kind in "mM" else getattr(_coord(patch, name), "units", None)
        coords[str(name)] = Coordinate(values, tuple(along), {} if unit is None else {"units": unit})
    attrs = {
        "units": unit_text(getattr(patch.attrs, "data_units", None)),
        "standard_name": getattr(patch.attrs, "data_type", None) or None,
    }
    known = {key: value for key, value in attrs.items() if value is not None}
    return Labelled(patch.data, dims, coords, known)


def _coord(patch: Any, name: str) -> Any:
    coords = patch.coords
    return coords.get_coord(name) if hasattr(coords, "get_coord") else None


def _of_traces(traces: list[Any]) -> Labelled:
    """Traces of obspy, which begin together; their places are ``stats.distance``, in metres."""
    if not traces:
        raise ValueError("field: expected traces, found an empty stream")
    first = traces[0].stats
    for trace in traces[1:]:
        for name in ("starttime", "delta", "npts"):
            if getattr(trace.stats, name) != getattr(first, name):
                raise ValueError(
                    f"field: expected traces of one {name}, found {getattr(first, name)} and "
                    f"{getattr(trace.stats, name)}; align them with Stream.trim, merge or resample"
                )
    apart = first.delta * np.arange(first.npts)
    start = {"units": "s", "step": float(first.delta), "start": str(first.starttime)}
    coords = {"time": Coordinate(apart, ("time",), start)}
    names = [getattr(trace, "id", "") for trace in traces]
    coords["trace_id"] = Coordinate(np.asarray(names), ("trace",))
    places = [getattr(trace.stats, "distance", None) for trace in traces]
    if all(place is not None for place in places):
        coords["trace"] = Coordinate(np.asarray(places, float), ("trace",), {"units": "m"})
    data = [trace.data for trace in traces]
    is_masked = any(isinstance(one, np.ma.MaskedArray) for one in data)
    stacked = np.ma.stack(data, axis=1) if is_masked else np.stack(data, axis=1)
    return Labelled(stacked, ("time", "trace"), coords)


def _named(label: object) -> tuple[str, dict[str, Any]]:
    """The name and the unit of a heading."""
    found = _NAME.match(str(label))
    return (found["name"], {"units": found["unit"]}) if found else (str(label).strip(), {})


def _of_table(table: Any) -> Labelled:
    """A table of pandas: rows are times, columns sites; a column of times is no site.

    An index that counts from 0 says nothing, nor do columns that are no even numbers.
    """
    if table.index.nlevels == 2 and not hasattr(table, "columns"):
        # Samples by time and site; those that are missing are gaps.
        table = table.unstack()
    if table.index.nlevels > 1:
        raise ValueError(
            f"field: expected rows of times, found an index of {table.index.nlevels} levels; "
            "make one a column of sites with unstack"
        )
    if not hasattr(table, "columns"):
        own = {"time": _index(table.index) if _says(table.index) else None}
        name = None if table.name is None else str(table.name)
        return Labelled(_values(table), ("time",), _some(own), dict(table.attrs), name)
    headings = [_named(label) for label in table.columns]
    timed = [i for i, (name, _) in enumerate(headings) if name.lower() in TIMES]
    times: Coordinate | None
    if timed and not _says(table.index):
        _, attrs = headings[timed[0]]
        times = Coordinate(table.iloc[:, timed[0]].array, ("time",), attrs)
        table = table.iloc[:, [i for i in range(len(headings)) if i != timed[0]]]
    else:
        times = _index(table.index) if _says(table.index) else None
    others = [str(label) for label in table.columns if table[label].dtype.kind not in "fiub"]
    if others:
        raise ValueError(
            f"field: expected columns of numbers, found {', '.join(others[:8])} of others; "
            "choose columns with DataFrame[[...]], and set the times with DataFrame.set_index"
        )
    columns = _index(table.columns, "site") if _says(table.columns) else None
    # What says nothing may be either way round.
    dims = ("row", "column") if times is None and columns is None else ("time", "site")
    coords = {"time": times, "site": columns}
    return Labelled(_values(table), dims, _some(coords), dict(table.attrs))


def _values(table: Any) -> Any:
    """The numbers of a table; those of nullable and Arrow's columns are floats, with NaN for none."""
    kinds = [table.dtype] if not hasattr(table, "columns") else list(table.dtypes)
    if all(isinstance(kind, np.dtype) for kind in kinds):
        return table.to_numpy()
    return table.to_numpy(dtype=float, na_value=np.nan)


def _some(coords: Mapping[str, Coordinate | None]) -> dict[str, Coordinate]:
    return {name: one for name, one in coords.items() if one is not None}


def _says(index: Any) -> bool:
    """Whether an index is more than a count."""
    is_count = type(index).__name__ == "RangeIndex" and index.start == 0 and index.step == 1
    return not is_count


def _index(index: Any, dim: str = "time") -> Coordinate | None:
    """The numbers or dates of an index; names of columns may be numbers with a unit, ``"2 mm"``."""
    _, attrs = _named(index.name) if index.name is not None else ("", {})
    if index.dtype.kind in "iufmM" or hasattr(index, "to_timestamp") or hasattr(index, "tz"):
        return Coordinate(index.array, (dim,), attrs)
    numbers = [re.match(r"^\s*([-+.\deE]+)\s*([^\d\s]*)\s*$", str(label)) for label in index]
    units = {found[2] for found in numbers if found}
    if not all(numbers) or len(units) != 1:
        return None
    try:
        values = np.array([float(found[1]) for found in numbers if found])
    except ValueError:
        return None
    unit = units.pop()
    return Coordinate(values, (dim,), {"units": unit} if unit else attrs)
