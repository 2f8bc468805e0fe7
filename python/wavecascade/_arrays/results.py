"""Arrays of a result as ``xarray.Dataset``, or as a dictionary where there is no xarray."""

from __future__ import annotations

import json
import os
import sys
import warnings
import weakref
import zlib
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wavecascade._keywords.words import CascadeWarning

if TYPE_CHECKING:
    import xarray as xr

    Result = xr.Dataset | dict[str, Any]


def _xarray() -> Any:
    try:
        import xarray
    except ImportError:
        return None
    return xarray


def warn(found: Mapping[str, Any]) -> None:
    """Issue the warnings of a result."""
    for _, message, advice in found.get("warnings", ()):
        warned(f"{message} ({advice})" if advice else message)


def warned(text: str) -> None:
    """Issue a warning where the package was called."""
    here = os.path.dirname(os.path.dirname(__file__)) + os.sep
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_code.co_filename.startswith(here):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, CascadeWarning, stacklevel=level)


def _axes(
    name: str, axes: list[str], shape: tuple[int, ...], lengths: Mapping[str, int]
) -> tuple[str, ...]:
    """The dimensions of an array: as they are stated, or of its own."""
    stated = tuple(axes) or (name,)
    fits = len(stated) == len(shape) and all(
        lengths.get(axis, length) == length for axis, length in zip(stated, shape, strict=True)
    )
    if fits:
        return stated
    return tuple(f"{name}_{i}" for i in range(len(shape))) if len(shape) > 1 else (name,)


def dataset(found: Mapping[str, Any], attrs: Mapping[str, Any]) -> Any:
    """All arrays with their dimensions, coordinates and attributes."""
    attrs = {**found["attributes"], **attrs}
    xarray = _xarray()
    if xarray is None:
        return {**{name: array for name, _, array, _ in found["arrays"]}, "attrs": attrs}
    lengths = {name: len(array) for name, _, array, _ in found["arrays"] if array.ndim == 1}
    variables = {}
    for name, axes, array, own in found["arrays"]:
        dims = _axes(name, axes, array.shape, lengths)
        own.pop("_FillValue", None)
        variables[name] = (dims, array, own)
    data = {name: one for name, one in variables.items() if one[0] != (name,)}
    coords = {name: one for name, one in variables.items() if one[0] == (name,)}
    return xarray.Dataset(data, coords, attrs)


def dataarray(found: Mapping[str, Any]) -> Any:
    """A field; without xarray a dictionary of the samples, the coordinates, and what is known."""
    attrs = {"quantity": found["quantity"], "long_name": found["quantity"].replace("_", " ")}
    known = (("units", "unit"), ("dispersion", "dispersion"), ("blake3", "hash"))
    attrs |= {key: found[name] for key, name in known if found[name] is not None}
    notes = [message for message, is_doubtful, _ in found["notes"] if not is_doubtful]
    if notes:
        attrs["read_as"] = "; ".join(notes)
    for message, is_doubtful, advice in found["notes"]:
        if is_doubtful:
            warned(f"{message} ({advice})" if advice else message)
    coords = {}
    for dim, axis in (("time", "time"), ("position", "space")):
        values, step, unit, is_counted = found[axis]
        if not is_counted:
            coords[dim] = (dim, values, {"step": step} | ({"units": unit} if unit else {}))
    name = found["quantity"]
    xarray = _xarray()
    if xarray is None:
        plain = {dim: values for dim, (_, values, _) in coords.items()}
        return {name: found["array"], **plain, "attrs": attrs}
    return xarray.DataArray(found["array"], coords, ("time", "position"), name, attrs)


def summary_attrs(
    summary: str, parts: Collection[str] | None = None, without: Collection[str] = ()
) -> dict[str, Any]:
    """These parts of a summary, or all but some, as attributes: numbers and texts, the rest in JSON."""
    read = json.loads(summary)
    attrs = {}
    for part in read if parts is None else parts:
        value = read.get(part)
        if value is None or part in without:
            continue
        if isinstance(value, bool):
            # A number, since files of NetCDF know no other.
            value = int(value)
        attrs[part] = value if isinstance(value, (str, int, float)) else json.dumps(value)
    return attrs


def frame(columns: Mapping[str, Any], attrs: Mapping[str, Any], page: Any) -> Any:
    """Columns as ``pandas.DataFrame``, or as a dictionary of arrays where there is no pandas."""
    try:
        import pandas
    except ImportError:
        table: Any = {**columns, "attrs": dict(attrs)}
    else:
        table = pandas.DataFrame(columns)
        table.attrs.update(attrs)
    hold(table, page)
    return table


def checksum(data: Any) -> int:
    """A checksum of all numbers with their names and shapes, whatever their types and byte order."""
    variables = getattr(data, "variables", data)
    total = 0
    for name in sorted(variables, key=str):
        values = np.asarray(getattr(variables[name], "values", variables[name]))
        if values.dtype.kind in "fiub":
            values = np.ascontiguousarray(values, "<f8")
        elif values.dtype.kind not in "cmM":
            continue
        total = zlib.crc32(f"{name} {values.shape}".encode(), total)
        total = zlib.crc32(np.ascontiguousarray(values).view(np.uint8).data, total)
    return total


#: Pages of tables, by their identity: attributes of tables go to files.
_PAGES: dict[int, tuple[Any, int]] = {}


def hold(out: Any, page: Any) -> None:
    """Keep with a result what its page is made of."""
    if hasattr(out, "encoding"):
        out.encoding["cascade_page"] = (page, checksum(out))
    elif isinstance(out, dict):
        out["page"] = (page, checksum({name: one for name, one in out.items() if name != "attrs"}))
    else:
        _PAGES[id(out)] = (page, checksum(out))
        weakref.finalize(out, _PAGES.pop, id(out), None)


def page_of(data: Any) -> Any:
    """What the page of a result is made of.

    Raises
    ------
    ValueError
        For a result that was changed, cut or exchanged since, or that has none.
    """
    if hasattr(data, "encoding"):
        kept, own = data.encoding.get("cascade_page"), data
    elif isinstance(data, dict):
        kept = data.get("page")
        own = {name: one for name, one in data.items() if name not in ("attrs", "page")}
    else:
        kept, own = _PAGES.get(id(data)), data
    if kept is None or kept[0] is None:
        raise ValueError(
            "result: expected what a function of wavecascade returned in this process, found another; "
            "compute it anew"
        )
    if kept[1] != checksum(own):
        raise ValueError(
            "result: expected the arrays as they were returned, found others: they were changed, cut or "
            "exchanged; compute anew from the field, or take the file"
        )
    return kept[0]
