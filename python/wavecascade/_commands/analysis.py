"""Fields: opened, analysed, filtered."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from wavecascade import _native
from wavecascade._arrays.fields import is_dataarray, is_path, source
from wavecascade._arrays.results import dataarray, dataset, held, hold, summary_attrs, warn
from wavecascade._commands.documented import documented
from wavecascade._keywords.options import AnalyzeOptions, FieldOptions, FilterOptions, OpenOptions
from wavecascade._keywords.words import Progress, observed, words

_ANALYZE = frozenset(AnalyzeOptions.__annotations__) | frozenset(OpenOptions.__annotations__)
_FIELD = frozenset(FieldOptions.__annotations__)


@documented
def analyze(
    field: Any,
    *,
    progress: Progress = None,
    maps: bool = True,
    **options: Unpack[AnalyzeOptions],
) -> Any:
    """Spectra of a velocity field v(t, x), their measures along x and t, and directions of travel.

    S(k, f) = 2 / (L T) |sum v(t, x) exp(i (k x - 2 pi f t)) dt dx|^2 / (2 pi), here as a density,
    one-sided in f; for f > 0, k > 0 travels towards +x.

    Parameters
    ----------
    field
        Samples ``(time, site)``: a NumPy array of any strides and byte order, which is not copied
        (masked samples are gaps), a pint quantity, an ``xarray.DataArray`` with its coordinates and
        ``units``, the Dataset of :func:`simulate`, whose lattice gives the dispersion branches, or
        the path of a file that ``cascade analyze`` reads.
    progress
        ``True`` for a bar of tqdm, or a function of ``(stage, done, total)``.
    maps
        Whether :func:`report` can show maps of the spectra.
    **options
        The options of ``cascade analyze`` with ``_`` for ``-``: ``dt=1e-5`` or ``dt="10 us"``,
        ``dx``, ``segment``, ``window_time``, ``only=["temporal"]``, and so on, with the same
        defaults.

    Returns
    -------
    xarray.Dataset or dict
        The arrays of ``spectra.nc`` with their dimensions, coordinates and units; the verdicts
        (``frequency_verdict``, ``frequency_up``, ``wavenumber_verdict``, ..., all of it as JSON in
        ``answer``), Parseval residuals and accuracy are attributes. Without xarray a
        dictionary of the arrays, whose attributes are under ``"attrs"``. Bits are those of the
        program.
    """
    found = _found(field, dict(options), progress, maps)
    warn(found, stacklevel=3)
    return _arranged(found)


def _found(field: Any, options: dict[str, object], progress: Progress, maps: bool) -> dict[str, Any]:
    """What the native half finds."""
    opened = source(field, options)
    files = opened if isinstance(opened, list) else ["field"]
    said = words("analyze", options, _ANALYZE, [os.fspath(file) for file in files])
    return _native.analyze(opened, said, observed(progress), maps)


def _arranged(found: dict[str, Any]) -> Any:
    """The arrays of an analysis."""
    attrs = summary_attrs(found["summary"], ("answer", "accuracy", "direction", "low_high", "warnings"))
    answer = json.loads(attrs.get("answer", "{}"))
    for axis in ("frequency", "wavenumber"):
        for part in ("verdict", "up", "down"):
            value = answer.get(axis, {}).get(part)
            if value is not None:
                attrs[f"{axis}_{part}"] = value
    out = dataset(found, attrs)
    hold(out, "analysis", found["analysis"])
    return out


def report(analysis: Any, path: str | os.PathLike[str]) -> None:
    """Write the interactive page of an analysis, which opens offline.

    Parameters
    ----------
    analysis
        What :func:`analyze` returned in this process; with ``maps=False`` the page has no maps.
    path
        File to write, such as ``"out.html"``.

    Raises
    ------
    ValueError
        For a dataset that was computed from others, changed or cut, or read from a file.
    """
    found = held(analysis, "analysis", "analysis")
    if found is None:
        raise ValueError(
            "analysis: expected what `analyze` returned in this process, found a dataset without it"
        )
    Path(path).write_text(_native.report(found), encoding="utf-8")


def _lazy(field: Any, which: str, options: dict[str, object]) -> Any:
    """A spectrum of a Dask array block by block: each block has whole records, or whole profiles."""
    import dask.array
    import xarray

    from wavecascade._arrays.fields import dims_of

    time, space = dims_of(field, options)
    if space is None:
        raise ValueError("field: expected times and sites, found one dimension")
    ordered = field.transpose(time, space)
    axis = 0 if which == "temporal" else 1
    blocks = _whole(ordered, axis)
    # The axes of the result are those of one record, or of one profile.
    one = ordered.isel({space if axis == 0 else time: slice(0, 1)})
    one = one.copy(data=np.zeros(one.shape, one.dtype))
    like = _spectrum(one, which, {**options, "noise": None})
    whole = like.dims[0] if axis == 0 else like.dims[1]
    length = like.sizes[whole]
    coords = {dim: ordered.coords[dim] for dim in (time, space) if dim in ordered.coords}

    def block(values: Any) -> Any:
        part = xarray.DataArray(values, dims=(time, space), attrs=ordered.attrs)
        steps = {dim: coords[dim].data for dim in (time, space) if dim in coords}
        kept = time if axis == 0 else space
        if kept in steps:
            part = part.assign_coords({kept: (kept, steps[kept], coords[kept].attrs)})
        return _spectrum(part, which, options).data

    chunks = list(blocks.chunks)
    chunks[axis] = (length,)
    chunked: Any = dask.array
    data = chunked.map_blocks(block, blocks, chunks=tuple(chunks), dtype=like.dtype)
    out = xarray.DataArray(data, dims=like.dims, attrs=like.attrs, name=like.name)
    out = out.assign_coords({whole: like.coords[whole]})
    other, own = (like.dims[1], space) if axis == 0 else (like.dims[0], time)
    if own in coords:
        place = coords[own]
        out = out.assign_coords({other: (other, place.data, place.attrs)})
    return out


def _whole(field: Any, axis: int) -> Any:
    """The field in blocks of whole records, or of whole profiles, unless far above a chunk's size."""
    import dask

    from wavecascade._large.store import shown

    chunks = field.data.chunks
    across = max(chunks[1 - axis])
    one = field.dtype.itemsize * field.shape[axis]
    limit = 4 * dask.utils.parse_bytes(dask.config.get("array.chunk-size"))
    if len(chunks[axis]) > 1 and one * across > limit:
        dims = field.dims
        least = max(1, limit // (4 * one))
        raise ValueError(
            f"field: expected whole {('records', 'profiles')[axis]} in blocks of at most {shown(limit)}, "
            f"found {len(chunks[axis])} chunks along {dims[axis]}, together {shown(one * across)} for "
            f"{across} along {dims[1 - axis]}; use field.chunk({{{dims[1 - axis]!r}: {least}}}), average "
            "segments (distributed.averaged), or transform over a store (distributed.plan_spacetime)"
        )
    return field.data.rechunk({axis: -1})


def quiet(field: Any, options: dict[str, object]) -> Any:
    """An analysis without its warnings: doubts about a whole field are none about a block of it."""
    return _arranged(_found(field, options, None, False))


def _spectrum(field: Any, which: str, options: dict[str, object]) -> Any:
    return quiet(field, {**options, "only": which})[f"{which}_spectrum"]


def _one_axis(field: Any, which: str, options: dict[str, object]) -> Any:
    """A spectrum along one axis, lazy where its field is."""
    is_lazy = is_dataarray(field) and hasattr(field.data, "dask")
    return (_lazy if is_lazy else _spectrum)(field, which, options)


def temporal_spectrum(field: Any, **options: Unpack[AnalyzeOptions]) -> Any:
    """S(f, x), the spectrum of each site's record: shape (frequency, position).

    As ``analyze(field, only="temporal")["temporal_spectrum"]``, with the same options and errors.
    For a DataArray over Dask it is lazy and blockwise by sites: each block is analysed with whole
    records when it is computed, and no block waits for another.
    """
    return _one_axis(field, "temporal", dict(options))


def spatial_spectrum(field: Any, **options: Unpack[AnalyzeOptions]) -> Any:
    """S(k, t), the spectrum of each instant's profile: shape (time, wavenumber).

    As ``analyze(field, only="spatial")["spatial_spectrum"]``, with the same options and errors. For
    a DataArray over Dask it is lazy and blockwise by times.
    """
    return _one_axis(field, "spatial", dict(options))


def open(path: Any, **options: Unpack[OpenOptions]) -> Any:
    """A field from any file that the program reads, as DataArray ``(time, position)``.

    Parameters
    ----------
    path
        NumPy, text tables, HDF5, NetCDF, MATLAB, SEG-Y, UFF 58, TDMS, miniSEED or LAMMPS dumps; with
        ``position_from`` a list of files with one record each.
    **options
        As for ``cascade analyze``: ``layout``, ``dt``, ``dx``, ``variable``, and so on.

    Returns
    -------
    xarray.DataArray or dict
        Samples in single or double precision, as the file has them, with coordinates and units.

    Raises
    ------
    OSError
        For a file that cannot be read, or is not what its format promises.
    ValueError
        For an option that does not apply.
    """
    paths = [os.fspath(path)] if is_path(path) else [os.fspath(one) for one in path]
    said = words("analyze", dict(options), frozenset(OpenOptions.__annotations__) | _FIELD, paths)
    return dataarray(_native.open(paths, said))


def filter(field: Any, *, progress: Progress = None, **options: Unpack[FilterOptions]) -> Any:
    """The part of a field in a band, at a speed, or in a direction of travel.

    The field is transformed in time and space, multiplied by 1 or 0, and transformed back.

    Parameters
    ----------
    field
        As for :func:`analyze`.
    progress
        As for :func:`analyze`; an exception there, or Ctrl-C, ends the work before or behind the
        transform.
    **options
        ``frequency``, ``wavenumber`` and ``speed`` as ``(from, to)``, whose ends may be ``None``;
        ``towards`` as ``"plus-x"``, ``"minus-x"`` or ``"nowhere"``; ``pad=True`` first doubles both
        axes with zeros; and how the field is read.

    Returns
    -------
    xarray.DataArray or dict
        A field with the same axes. The energy before and after, sum of v^2, are attributes.

    Raises
    ------
    ValueError
        For bands that do not fit.
    """
    typed: dict[str, object] = dict(options)
    opened = source(field, typed)
    allowed = frozenset(FilterOptions.__annotations__) | _FIELD
    file = os.fspath(opened[0]) if isinstance(opened, list) else "field"
    found = _native.filter(opened, words("filter", typed, allowed, [file]), observed(progress))
    warn(found, stacklevel=3)
    if found["is_single"]:
        found["array"] = found["array"].astype(np.float32)
    out = dataarray(found)
    energies = {name: found[name] for name in ("energy_before", "energy_after")}
    (out.attrs if hasattr(out, "dims") else out["attrs"]).update(energies)
    return out
