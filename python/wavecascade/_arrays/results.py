"""Arrays of a result as ``xarray.Dataset``, or as a dictionary where there is no xarray."""

from __future__ import annotations

import json
import warnings
import zlib
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wavecascade._keywords.words import CascadeWarning

if TYPE_CHECKING:
    import xarray as xr

    Result = xr.Dataset | dict[str, Any]

#: Dimensions of arrays that only have names, by the number of their axes and their first words.
_NAMED: dict[str, tuple[str, ...]] = {
    "kinetic_energy": ("time",),
    "contact_energy": ("time",),
    "lost_energy": ("time",),
    "input_energy": ("time",),
    "left_behind": ("time",),
    "wavenumber_centroid": ("time",),
    "low_wavenumber_energy": ("time",),
    "band_edge_flux": ("time",),
    "optical_energy": ("time",),
    "optical_transfer": ("time",),
    "low_frequency_passed": ("contact_position",),
    "high_frequency_passed": ("contact_position",),
    "scale_sigma": ("scale",),
    "scale_cutoff_wavenumber": ("scale",),
    "velocity": ("time", "position"),
    "displacement": ("time", "position"),
    "overlap": ("time", "contact_position"),
    "force": ("time", "contact_position"),
    "energy_flux": ("time", "contact_position"),
    "energy_passed": ("time", "contact_position"),
    "energy": ("time", "position"),
}


def _xarray() -> Any:
    try:
        import xarray
    except ImportError:
        return None
    return xarray


def warn(found: Mapping[str, Any], stacklevel: int = 4) -> None:
    """Issue the warnings of a result."""
    for _, message, advice in found.get("warnings", ()):
        warnings.warn(f"{message} ({advice})", CascadeWarning, stacklevel=stacklevel)


def _axes(
    name: str, axes: list[str], shape: tuple[int, ...], lengths: Mapping[str, int]
) -> tuple[str, ...]:
    """The dimensions of an array: as they are stated, as its name has it, or of its own."""
    if axes:
        stated = tuple(axes)
    else:
        base = name.removesuffix("_error")
        stated = _NAMED.get(name) or _NAMED.get(base) or (name,)
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
            help_ = f" ({advice})" if advice else ""
            warnings.warn(f"{message}{help_}", CascadeWarning, stacklevel=4)
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


def frame(columns: Mapping[str, Any], attrs: Mapping[str, Any]) -> Any:
    """Columns as ``pandas.DataFrame``, or as a dictionary of arrays where there is no pandas."""
    try:
        import pandas
    except ImportError:
        return {**columns, "attrs": dict(attrs)}
    table = pandas.DataFrame(columns)
    table.attrs.update(attrs)
    return table


def _sum(data: Any) -> int:
    """A checksum of all numbers of a result, with their names and shapes."""
    variables = getattr(data, "variables", data)
    total = 0
    for name in sorted(variables, key=str):
        values = np.asarray(getattr(variables[name], "values", variables[name]))
        if values.dtype.kind not in "fiucbmM":
            continue
        total = zlib.crc32(f"{name} {values.shape} {values.dtype.str}".encode(), total)
        total = zlib.crc32(np.ascontiguousarray(values).view(np.uint8).data, total)
    return total


class Held:
    """What arrays of a result were made from, as long as they are those arrays."""

    def __init__(self, native: Any, data: Any) -> None:
        self.native = native
        self._sum = _sum(data)

    def of(self, data: Any, what: str) -> Any:
        """The original of ``data``.

        Raises
        ------
        ValueError
            For arrays that were changed, cut or exchanged since.
        """
        if _sum(data) != self._sum:
            raise ValueError(
                f"{what}: expected the arrays as they were returned, found others: they were changed, "
                "cut or exchanged; compute anew from the field, or take the file"
            )
        return self.native


def hold(out: Any, key: str, native: Any) -> None:
    """Keep with a result what it was made from."""
    if hasattr(out, "encoding"):
        out.encoding[f"cascade_{key}"] = Held(native, out)
    else:
        out[key] = Held(native, {name: array for name, array in out.items() if name != "attrs"})


def held(data: Any, key: str, what: str) -> Any:
    """What a result was made from; ``None`` for others.

    Raises
    ------
    ValueError
        As :meth:`Held.of`.
    """
    encoding = getattr(data, "encoding", None)
    if encoding is not None:
        kept = encoding.get(f"cascade_{key}")
        return kept.of(data, what) if isinstance(kept, Held) else None
    kept = data.get(key) if isinstance(data, dict) else None
    arrays = {name: array for name, array in data.items() if name not in ("attrs", key)} if kept else {}
    return kept.of(arrays, what) if isinstance(kept, Held) else None
