"""Fields: opened, analyzed, filtered."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from wavecascade import _native
from wavecascade._arrays.fields import is_dataarray, is_dataset, is_path, opened_dims, source
from wavecascade._arrays.labelled import labelled
from wavecascade._arrays.mapped import over
from wavecascade._arrays.results import dataarray, dataset, hold, page_of, summary_attrs, warn
from wavecascade._arrays.runs import is_run, is_whole, run_of
from wavecascade._commands.documented import documented
from wavecascade._keywords.advice import advising
from wavecascade._keywords.options import AnalyzeOptions, FieldOptions, FilterOptions, OpenOptions
from wavecascade._keywords.words import Progress, observed, words

if TYPE_CHECKING:
    import xarray as xr

_ANALYZE = frozenset(AnalyzeOptions.__annotations__) | frozenset(OpenOptions.__annotations__)
_FIELD = frozenset(FieldOptions.__annotations__)


@documented
def analyze(
    field: Any,
    *,
    progress: Progress = None,
    maps: bool = True,
    **options: Unpack[AnalyzeOptions],
) -> xr.Dataset:
    """Spectra of a velocity field v(t, x), their measures along x and t, and directions of travel.

    S(k, f) = 2 / (L T) |sum v(t, x) exp(i (k x - 2 pi f t)) dt dx|^2 / (2 pi), here as a density,
    one-sided in f; for f > 0, k > 0 travels towards +x.

    Parameters
    ----------
    field
        Samples ``(time, site)``: a NumPy array of any strides and byte order, which is not copied
        (masked samples are gaps), a pint quantity, an ``xarray.DataArray`` with its coordinates and
        ``units``, a Patch of DASCore, a Stream of obspy, a DataFrame of pandas, the Dataset of
        :func:`simulate`, whose lattice gives the dispersion branches and whose energies the answer in
        time, or the path of a file that ``cascade analyze`` reads.
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
        ``temporal_spectrum`` S(f, x) ``(frequency, position)``, ``spatial_spectrum`` S(k, t) ``(time,
        wavenumber)``, ``spacetime_spectrum`` S(k, f) ``(frequency, wavenumber_signed)``,
        ``kinetic_flux_surrogate`` ``(time, wavenumber)``;
        measures of S(f, x) at each site, ``frequency_centroid``, ``frequency_bandwidth``,
        ``frequency_effective_bandwidth``, ``frequency_entropy``, ``frequency_participation``,
        ``frequency_zero_share``, ``frequency_median``, ``frequency_90``, ``frequency_energy``, and
        those of S(k, t) at each time, ``wavenumber_centroid``, ``wavenumber_bandwidth``,
        ``wavenumber_effective_bandwidth``, ``wavenumber_entropy``, ``wavenumber_participation``,
        ``wavenumber_zero_share``, ``wavenumber_median``, ``wavenumber_90``, ``wavenumber_energy``;
        bands, ``low_frequency_share``, ``high_frequency_share``, ``low_wavenumber_share``,
        ``high_wavenumber_share``, and where a front passes ``front_arrival``,
        ``low_frequency_share_front``, ``high_frequency_share_front``; directions
        ``toward_plus_x_share`` and ``toward_minus_x_share`` ``(frequency)``; where asked for,
        ``dispersion_frequency`` ``(dispersion_branch, dispersion_wavenumber)``,
        ``short_time_spectrum`` ``(short_time_position, short_time_frequency, short_time_time)`` and
        ``short_space_spectrum`` ``(short_space_time, short_space_wavenumber, short_space_position)``.

        The answer is attributes: ``frequency_verdict``, ``frequency_up``, ``frequency_up_at``,
        ``frequency_bound``, ``frequency_most_share``, ``wavenumber_verdict``,
        ``direction_toward_plus_x`` and all others of ``moved`` in ``summary.json`` that are known, the
        whole as JSON in ``moved``, the verdict in words in ``answer``; settings, Parseval residuals and
        accuracy beside them. Of
        further dimensions each place is analyzed, and attributes that differ are variables. Without
        xarray a dictionary of the arrays, whose attributes are under ``"attrs"``. Bits are those of
        the program.
    """

    def of(one: Any) -> Any:
        found = _found(one, dict(options), progress, maps)
        warn(found)
        return _arranged(found)

    return over(of, field, options)


def _found(field: Any, options: dict[str, object], progress: Progress, maps: bool) -> dict[str, Any]:
    """What the native half finds."""
    is_of_run = is_dataset(field) and options.get("variable") in (None, "velocity")
    run = run_of(field) if is_of_run and is_run(field) and is_whole(field) else None
    opened = source(field, options)
    files = opened if isinstance(opened, list) else ["field"]
    said = words("analyze", options, _ANALYZE, [os.fspath(file) for file in files])
    with advising(_ANALYZE, opened):
        return _native.found(said, observed(progress), [opened], runs=[run], maps=maps)


def _arranged(found: dict[str, Any]) -> Any:
    """The arrays of an analysis."""
    attrs = summary_attrs(
        found["summary"], ("answer", "moved", "accuracy", "direction", "low_high", "warnings")
    )
    for name, value in _said(json.loads(attrs.get("moved", "{}"))):
        attrs[name] = int(value) if isinstance(value, bool) else value
    out = dataset(found, attrs)
    hold(out, found["page"])
    return out


def _said(answer: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Each number and text of an answer with its path: ``frequency_most_share``."""
    if isinstance(answer, dict):
        for key, value in answer.items():
            yield from _said(value, f"{name}_{key}" if name else key)
    elif isinstance(answer, (str, int, float)):
        yield name, answer
    elif isinstance(answer, list) and all(isinstance(one, (int, float)) for one in answer) and answer:
        yield name, answer


def plan(field: Any, **options: Unpack[AnalyzeOptions]) -> dict[str, Any]:
    """What :func:`analyze` would do: passes, blocks and memory, as ``cascade analyze --plan --json``.

    Parameters
    ----------
    field, **options
        As for :func:`analyze`. No sample is read.

    Raises
    ------
    ValueError
        For options that do not fit the field.
    MemoryError
        For a field that needs more than it may take.
    """
    typed: dict[str, object] = dict(options)
    opened = source(field, typed)
    files = opened if isinstance(opened, list) else ["field"]
    said = words("analyze", typed, _ANALYZE, [os.fspath(file) for file in files])
    with advising(_ANALYZE, opened):
        return json.loads(_native.planned(opened, said))


@documented
def inspect(path: Any, *, channels: bool = False, **options: Unpack[OpenOptions]) -> dict[str, Any]:
    """What is in a file, and what of it would be taken for the field, as ``cascade inspect --json``.

    Parameters
    ----------
    path
        A file, or with ``position_from`` several.
    channels
        Whether all samples are read, to find channels that are dead, clipped, too loud or noisy.
    **options
        As for :func:`open`.

    Returns
    -------
    dict
        ``format``, ``attributes``, ``variables``, ``channels``, and ``field`` with its axes and notes, or
        with the ``error`` that keeps it from being one, and ``advice``.
    """
    paths = [os.fspath(path)] if is_path(path) else [os.fspath(one) for one in path]
    allowed = frozenset(OpenOptions.__annotations__) | _FIELD | {"channels"}
    return json.loads(
        _native.inspected(words("inspect", {**options, "channels": channels}, allowed, paths))
    )


@documented
def report(result: Any, path: str | os.PathLike[str]) -> None:
    """Write the interactive page of a result, which opens offline.

    Parameters
    ----------
    result
        What any function of this package returned in this process, but fields; of :func:`analyze` with
        ``maps=False`` the page has no maps.
    path
        File to write, such as ``"out.html"``.
    """
    Path(path).write_text(_native.report(page_of(result)), encoding="utf-8")


def _lazy(field: Any, which: str, options: dict[str, object]) -> Any:
    """A spectrum of a Dask array block by block: each block has whole records, or whole profiles."""
    import dask.array
    import xarray

    from wavecascade._arrays.fields import dims_of

    dims = dims_of(field, options)
    time, space = dims.time, dims.space
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

    def of(one: Any) -> Any:
        is_lazy = is_dataarray(one) and hasattr(one.data, "dask")
        return (_lazy if is_lazy else _spectrum)(one, which, options)

    return over(of, field, options)


def temporal_spectrum(field: Any, **options: Unpack[AnalyzeOptions]) -> xr.DataArray:
    """S(f, x), the spectrum of each site's record: shape (frequency, position).

    As ``analyze(field, only="temporal")["temporal_spectrum"]``, with the same options and errors.
    For a DataArray over Dask it is lazy and blockwise by sites: each block is analyzed with whole
    records when it is computed, and no block waits for another.
    """
    return _one_axis(field, "temporal", dict(options))


def spatial_spectrum(field: Any, **options: Unpack[AnalyzeOptions]) -> xr.DataArray:
    """S(k, t), the spectrum of each instant's profile: shape (time, wavenumber).

    As ``analyze(field, only="spatial")["spatial_spectrum"]``, with the same options and errors. For
    a DataArray over Dask it is lazy and blockwise by times.
    """
    return _one_axis(field, "spatial", dict(options))


@documented
def open(path: Any, **options: Unpack[OpenOptions]) -> xr.DataArray:
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
    """
    paths = [os.fspath(path)] if is_path(path) else [os.fspath(one) for one in path]
    allowed = frozenset(OpenOptions.__annotations__) | _FIELD
    with advising(allowed, paths):
        return dataarray(_native.open(paths, words("analyze", dict(options), allowed, paths)))


@documented
def filter(field: Any, *, progress: Progress = None, **options: Unpack[FilterOptions]) -> xr.DataArray:
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
        A field with the dimensions, coordinates and attributes of ``field``, so that
        ``da - da.cascade.filter(...)`` is what was removed. The energy before and after, sum of v^2, are
        attributes.
    """
    found = over(lambda one: _filtered(one, dict(options), progress), field, options)
    known = None if is_path(field) or is_dataset(field) else labelled(field)
    if known is not None and hasattr(found, "transpose") and set(found.dims) == set(known.dims):
        return found.transpose(*known.dims)
    return found


def _filtered(field: Any, options: dict[str, object], progress: Progress) -> Any:
    kept = None if is_path(field) else opened_dims(field, options)
    opened = source(field, options)
    allowed = frozenset(FilterOptions.__annotations__) | _FIELD
    file = os.fspath(opened[0]) if isinstance(opened, list) else "field"
    said = words("filter", options, allowed, [file])
    with advising(allowed, opened):
        found = _native.filter(opened, said, observed(progress))
    warn(found)
    if found["is_single"]:
        found["array"] = found["array"].astype(np.float32)
    energies = {name: found[name] for name in ("energy_before", "energy_after")}
    out = dataarray(found) if kept is None else _in_place_of(kept, found)
    (out.attrs if hasattr(out, "dims") else out["attrs"]).update(energies)
    return out


def _in_place_of(field: Any, found: dict[str, Any]) -> Any:
    """The samples that passed, in the place of those of the field."""
    own = dataarray(found)
    time, space = field.dims[0], field.dims[1] if field.ndim > 1 else None
    if not hasattr(own, "dims"):
        return own
    if own.shape != (*field.shape, 1)[:2]:
        return own.rename({"time": time} | ({"position": space} if space else {}))
    import xarray

    data = own.data if space else own.data[:, 0]
    coords = {name: (tuple(one.dims), one.data, dict(one.attrs)) for name, one in field.coords.items()}
    return xarray.DataArray(data, coords, field.dims, field.name, dict(field.attrs))
