"""Functions of fields over further dimensions, and further coordinates of sites and times."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from wavecascade._arrays.fields import SHOTS, Dims, dims_of, is_dataset, is_path, of_dataset, plain
from wavecascade._arrays.labelled import Coordinate, Labelled, labelled


def over(
    call: Callable[[Any], Any], field: Any, options: Mapping[str, Any], is_of_shots: bool = False
) -> Any:
    """What ``call`` makes of a field, or of each place of dimensions beside times and sites, in one.

    Coordinates of one dimension that stand beside those of sites and times stay with them.
    """
    if is_path(field) or isinstance(field, (list, tuple)):
        return call(field)
    whole = of_dataset(field, dict(options)) if is_dataset(field) else field
    known = labelled(whole)
    if known is None:
        shape = getattr(field, "shape", ())
        own = 3 if is_of_shots else 2
        if len(shape) <= own:
            return call(field)
        results = [over(call, one, options, is_of_shots) for one in field]
        return _stacked(results, f"batch_{len(shape) - own}", None)
    at = options.get("at")
    taken = {text.partition("=")[0] for text in ([at] if isinstance(at, str) else at or [])}
    dims = _dims(known, options, taken, is_of_shots)
    if dims.others:
        dim = dims.others[0]
        places = range(known.sizes[dim])
        results = [over(call, known.isel({dim: i}), options, is_of_shots) for i in places]
        return _stacked(results, dim, known.coords.get(dim))
    return _described(call(field), known, dims)


def _dims(known: Any, options: Mapping[str, Any], taken: set[str], is_of_shots: bool) -> Dims:
    """Which dimensions are mapped over: not those of which one place is taken, and not shots."""
    kept = [str(dim) for dim in known.dims if dim not in taken]
    shot = options.get("shot_dim")
    if is_of_shots:
        shot = shot or next((dim for dim in kept if dim.lower() in SHOTS), None)
        kept = [dim for dim in kept if dim != shot]
    sketch = Labelled(np.broadcast_to(0.0, [1] * len(kept)), tuple(kept), dict(known.coords))
    return dims_of(sketch, options)


def _stacked(results: list[Any], dim: str, places: Any) -> Any:
    """Results in one, along a dimension: attributes that differ become variables along it."""
    import xarray

    if not results or isinstance(results[0], dict):
        raise ValueError(f"field: expected times and sites, found {dim} too, which needs xarray")
    attrs = [result.attrs for result in results]
    names = dict.fromkeys(name for one in attrs for name in one)
    first = attrs[0]
    equal = {
        name: first[name] for name in names if all(one.get(name) == first.get(name) for one in attrs)
    }
    differ = {name: [one.get(name) for one in attrs] for name in names if name not in equal}
    bare = [result.copy() for result in results]
    for one in bare:
        one.attrs, one.encoding = {}, {}
    joined: Any = xarray.concat(bare, dim, join="outer", coords="minimal", compat="override")
    joined.attrs.update(equal)
    if isinstance(joined, xarray.Dataset):
        for name, values in differ.items():
            if name not in joined.variables:
                joined[name] = (dim, _column(values))
    if places is not None:
        joined = joined.assign_coords({dim: (dim, np.asarray(places.data), dict(places.attrs))})
    return joined


def _column(values: list[Any]) -> list[Any]:
    """Numbers, or texts; what is neither is JSON."""
    if all(isinstance(one, (int, float)) or one is None for one in values):
        return [np.nan if one is None else one for one in values]
    texts = ("" if one is None else one for one in values)
    return [one if isinstance(one, str) else json.dumps(one) for one in texts]


def _described(found: Any, field: Any, dims: Dims) -> Any:
    """A result with the further coordinates of the field, for the sites and times that it has."""
    if isinstance(found, dict) or not hasattr(found, "assign_coords"):
        return found
    own_names = {dims.time, dims.space, *found.coords, *found.dims, *getattr(found, "data_vars", ())}
    for name, coordinate in field.coords.items():
        if name in own_names:
            continue
        along = [str(dim) for dim in coordinate.dims]
        if not along:
            found = found.assign_coords({name: ((), np.asarray(coordinate.data)[()], coordinate.attrs)})
        for own, dim in ((dims.time, "time"), (dims.space, "position")):
            if along != [own] or dim not in found.sizes:
                continue
            rows = _rows(field.coords.get(own), field.sizes[own], found, dim)
            if rows is not None:
                values = np.asarray(coordinate.data)[rows]
                found = found.assign_coords({name: (dim, values, dict(coordinate.attrs))})
    return found


def _rows(own: Coordinate | None, length: int, found: Any, dim: str) -> Any:
    """Which samples of a dimension a result has."""
    if found.sizes[dim] == length:
        return slice(None)
    if own is None or dim not in found.coords:
        return None
    values, _ = plain(own.data)
    if values.dtype.kind not in "iuf":
        return None
    apart = np.abs(found.coords[dim].values[:, None] - values[None, :])
    rows = np.argmin(apart, axis=1)
    is_near = apart[np.arange(len(rows)), rows] <= 1e-6 * max(np.ptp(values), 1e-300)
    return rows if is_near.all() else None
