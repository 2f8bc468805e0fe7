"""Averages over segments of Dask arrays: spectra and coherence of groups of sites."""

from __future__ import annotations

import json
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Unpack, get_args

import numpy as np

from wavecascade._arrays.axes import AXES, Axes, placed
from wavecascade._arrays.fields import is_dataarray
from wavecascade._arrays.results import summary_attrs
from wavecascade._commands.parts import Divided, words_of
from wavecascade._keywords.options import DividedOptions
from wavecascade._large.columns import Reference
from wavecascade._large.lazy import lazy_array, lazy_dataset
from wavecascade._large.tasks import (
    STATES,
    Work,
    finished,
    independence_of,
    stated,
    summed,
    sums_at_hand,
    work_of,
)

if TYPE_CHECKING:
    import xarray as xr

#: Sites that the library sums together.
_TOGETHER = 8
#: Bytes of a cell of a result while it is made.
_OF_A_CELL = 128
#: What an array is over if it is known of each place by itself.
_PLACES = frozenset({"frequency", "position"})
#: Parts of a summary that are known without samples; ``level`` is that of a steady reference.
_ATTRIBUTES_OF_AVERAGES = (
    "along",
    "time_unit",
    "space_unit",
    "unit",
    "segment",
    "overlap",
    "half_bandwidth",
    "alpha",
    "level",
)


def averaged(
    field: Any,
    estimate: Divided = "spectrum",
    *,
    reference: int | Any = None,
    **options: Unpack[DividedOptions],
) -> xr.Dataset:
    """Averages over the segments of a Dask array, lazy: one task a chunk, then their sums.

    As :func:`wavecascade.spectrum` with ``no_jackknife=True`` or :func:`wavecascade.coherence`, but for
    rounding, for any chunks and workers. A chunk of times passes its neighbour the samples that their
    segments share; a chunk of sites stands by itself.

    Parameters
    ----------
    field
        ``xarray.DataArray`` over Dask, or a Dask array ``(time, site)``, in chunks of any sizes.
    estimate
        ``"spectrum"`` or ``"coherence"``.
    reference
        For coherence, a site's index (0 by default), or the record of the reference.
    **options
        As for :func:`wavecascade.partial`; of how fields are read, those that name axes and units.

    Returns
    -------
    xarray.Dataset
        The arrays of the estimate that are known of each site by itself, lazy, and ``steadiness``. The
        attribute ``level`` of a coherence is the level of significance of a steady reference.

    Raises
    ------
    ValueError
        For options that do not fit; when it is computed, for samples that do not.
    MemoryError
        When it is computed, for sums beyond ``memory``: by default, in a worker of Dask, the share of a
        task in its memory limit, less the samples that the task holds.

    Warns
    -----
    CascadeWarning
        When it is computed, once, as of :func:`spectrum` and :func:`coherence`. Each process of the
        workers of a ``distributed.Client`` sends it there once, and the default filters of Python show
        one. Of sites in several chunks it says that some have a transient.
    """
    if estimate not in get_args(Divided):
        raise ValueError(f"estimate: expected spectrum or coherence, found {estimate!r}")
    own: dict[str, Any] = dict(options)
    if own.get("part") is not None:
        raise ValueError(
            f"part: expected none, since the chunks are the parts, found {own['part']!r}; "
            "use partial for a part of a record"
        )
    of_field = {
        name: own.pop(name) for name in list(own) if name in AXES | {"time_dim", "space_dim", "layout"}
    }
    found = placed(field, of_field)
    if not found.is_lazy:
        raise ValueError(
            f"field: expected a Dask array, found {type(found.samples).__name__}; use partial and combine"
        )
    compared = _reference(found.samples, estimate, reference)
    n_times, _ = map(int, found.samples.shape)
    if compared is not None:
        own["reference"] = 0
    words = words_of(estimate, own | stated(found.axes, of_field), ["field"])
    work = work_of(words, n_times, field, found)
    # Other sites have arrays of the same kinds.
    known, cut = work.outline(2)
    tapers = json.loads(known["summary"])["independence"]["tapers"]
    state = _bytes_of_a_state(estimate, cut, tapers)
    groups = _groups_of_sites(found.samples, _OF_A_CELL * (cut[0] // 2 + 1) + STATES * state)
    wholes = [summed(work, cut, found.samples, sites, compared) for sites in groups]
    return _dataset(work, known, found.axes, groups, wholes, compared is not None)


def _dataset(
    work: Work,
    known: dict[str, Any],
    axes: Axes,
    groups: list[range],
    wholes: list[Any],
    is_compared: bool,
) -> Any:
    """What the sums over these groups of sites give."""
    from dask.delayed import delayed

    # What is over sites; there is no jackknife in parts.
    kept = [
        one
        for one in known["arrays"]
        if set(one[1]) <= _PLACES and one[1] != [one[0]] and not one[0].startswith("jackknife")
    ]
    names = [name for name, *_ in kept]
    n_sites = groups[-1].stop
    of_sites = n_sites if len(groups) > 1 else None
    results = [delayed(finished)(work, whole, names, is_compared, of_sites) for whole in wholes]
    arrays = []
    for name, dims, array, attrs in kept:
        is_of_sites = dims[-1] == "position"
        lengths = [len(sites) if is_of_sites else array.shape[-1] for sites in groups]
        parts = list(zip(lengths, results, strict=True))
        arrays.append((name, dims, lazy_array(parts, name, array), attrs))
    for name, dims, array, attrs in known["arrays"][:2]:
        places = axes.positions(0, n_sites) if name == "position" else array
        arrays.insert(0, (name, dims, places, attrs))
    summary = json.loads(known["summary"])
    attrs = summary_attrs(known["summary"], [name for name in _ATTRIBUTES_OF_AVERAGES if name in summary])
    # Of a spectrum along time it is known of each site.
    scalars = [] if "steadiness" in names else ["steadiness"]
    return lazy_dataset(arrays, attrs | independence_of(known), results[0], scalars)


def _bytes_of_a_state(estimate: Divided, cut: tuple[int, int, int], tapers: int) -> int:
    """Bytes of a site in a state: each frequency, pieces of a record, what filling leaves."""
    length, hop, count = cut
    # Power and product with the reference; or power under each taper and, of several, the test for lines.
    of_a_bin = 3 if estimate == "coherence" else tapers + (5 if tapers > 1 else 0)
    reached = (count - 1) * hop + length
    pieces = reached // max(1, reached // 16) + 1
    return 8 * (of_a_bin * (length // 2 + 1) + 3 * pieces + 4)


def _groups_of_sites(samples: Any, of_a_site: int) -> list[range]:
    """Sites that are taken together: chunks, or pieces of those whose sums are much larger."""
    most = max(_TOGETHER, sums_at_hand(samples) // of_a_site // _TOGETHER * _TOGETHER)
    ends = np.cumsum((0, *samples.chunks[1])).tolist()
    pieces = [(a, b, -(-(b - a) // most)) for a, b in pairwise(ends)]
    return [
        range(a + i * (b - a) // n, a + (i + 1) * (b - a) // n) for a, b, n in pieces for i in range(n)
    ]


def _reference(samples: Any, estimate: Divided, reference: Any) -> Reference | None:
    """The record of the reference of a coherence."""
    if estimate != "coherence":
        if reference is not None:
            raise ValueError(f"reference: expected none with {estimate}, found {reference!r}")
        return None
    reference = 0 if reference is None else reference
    if isinstance(reference, (int, np.integer)):
        if not 0 <= reference < samples.shape[1]:
            last = samples.shape[1] - 1
            raise ValueError(f"reference: expected a site from 0 to {last}, found {reference}")
        return Reference(samples[:, int(reference)], int(reference))
    shape = tuple(np.shape(reference))
    if shape != (samples.shape[0],):
        raise ValueError(f"reference: expected {samples.shape[0]} samples, found the shape {shape}")
    return Reference(reference.data if is_dataarray(reference) else reference, None)
