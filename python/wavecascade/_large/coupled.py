"""Bicoherence over segments of Dask arrays: of the sites of its map, and of sites along x in groups."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from wavecascade._arrays.axes import Placed
from wavecascade._arrays.results import summary_attrs
from wavecascade._commands.parts import words_of
from wavecascade._keywords.words import range_word
from wavecascade._large.lazy import lazy_array, lazy_dataset
from wavecascade._large.tasks import (
    NODES,
    Work,
    combined,
    finished,
    independence_of,
    stated,
    summed,
    sums_at_hand,
    work_of,
)

#: Parts of the summary that are known without samples.
_ATTRIBUTES_OF_MAP = ("time_unit", "space_unit", "segment", "overlap", "alpha")
#: Sums of a triple, and of a bin.
_OF_A_TRIPLE, _OF_A_BIN = 3, 2


def coupled(field: Any, found: Placed, own: Mapping[str, Any], of_field: Mapping[str, object]) -> Any:
    """The bicoherence of a field, lazy."""
    n_sites = int(found.samples.shape[1])
    shared = {
        name: value for name, value in own.items() if name not in ("site", "output", "along", "every")
    }
    shared |= stated(found.axes, of_field)
    site, output = _site("site", own.get("site", 0), n_sites), own.get("output")
    output = site if output is None else _site("output", output, n_sites)
    chosen = _chosen(own.get("along"), own.get("every"), n_sites)
    known, arrays, result = _map(shared, site, output, field, found)
    if chosen:
        arrays += _along_x(shared, chosen, field, found)
    attrs = summary_attrs(known["summary"], _ATTRIBUTES_OF_MAP) | independence_of(known)
    for name, j in (("", site), ("output_", output)):
        attrs |= {name.rstrip("_") or "site": j, f"{name}position": found.axes.x0 + j * found.axes.dx}
    return lazy_dataset(arrays, attrs, result, ["steadiness", "cell_level"])


def _map(
    shared: Mapping[str, object], site: int, output: int, field: Any, found: Placed
) -> tuple[dict[str, Any], list[tuple[Any, ...]], Any]:
    """A map of zeros, the arrays of that of these sites, and the task that finds them."""
    from dask.delayed import delayed

    options: dict[str, object] = {**shared, "every": 0}
    columns = [site]
    if site != output:
        options["output"] = 1
        columns.append(output)
    work, known, cut = _planned(options, field, found)
    whole = summed(work, cut, found.samples, columns, None)
    values = ["bicoherence", "biphase"]
    result = delayed(finished)(work, whole, values, False, None)
    arrays = []
    for name, dims, array, attrs in known["arrays"]:
        lazy = lazy_array([(len(array), result)], name, array) if name in values else array
        arrays.append((name, dims, lazy, attrs))
    return known, arrays, result


def _along_x(
    shared: Mapping[str, object], chosen: range, field: Any, found: Placed
) -> list[tuple[Any, ...]]:
    """The arrays of the sites that are followed along x."""
    from dask.delayed import delayed

    # These words also ask for the map of site 0, so that each group sums that of its first site as well,
    # which costs what one more site does. The library has no words for sites without a map, and to gather
    # the first site from the cells of its map, with its levels, would be its work a second time.
    work, silent, cut = _planned(shared, field, found)
    bins = cut[0] // 2 + 1
    triples = sum(name == "first" and len(array) for name, _, array, _ in silent["arrays"])
    of_a_site = 8 * NODES * (_OF_A_TRIPLE * triples + _OF_A_BIN * bins)
    planes = [one for one in silent["arrays"] if one[0].startswith("along_")]
    names = [name for name, *_ in planes]
    parts = []
    for group in _groups_of_chosen(found.samples, chosen, of_a_site):
        whole = summed(work, cut, found.samples, group, None)
        parts.append((len(group), delayed(_found_along)(work, whole, names)))
    places = np.array(chosen, float)
    positions = found.axes.x0 + places * found.axes.dx
    arrays = []
    for name, dims, array, attrs in planes:
        if array.ndim == 1:
            values = places if name == "along_site" else positions
        else:
            values = lazy_array(parts, name, array)
        arrays.append((name, dims, values, attrs))
    return arrays


def _planned(
    options: Mapping[str, object], field: Any, found: Placed
) -> tuple[Work, dict[str, Any], tuple[int, int, int]]:
    """Words, a result of zeros, and segments, of two sites."""
    words = words_of("bicoherence", options, ["field"])
    work = work_of(words, int(found.samples.shape[0]), field, found)
    known, cut = work.outline(2)
    return work, known, cut


def _found_along(work: Work, whole: Any, names: list[str]) -> dict[str, Any]:
    """What was found along x; warnings are of the map, which is of no site that is meant."""
    found = combined(work, whole)
    return {name: array for name, _, array, _ in found["arrays"] if name in names}


def _site(option: str, value: Any, n_sites: int) -> int:
    if not isinstance(value, (int, np.integer)) or not 0 <= value < n_sites:
        raise ValueError(f"{option}: expected a site from 0 to {n_sites - 1}, found {value!r}")
    return int(value)


def _chosen(along: Any, every: Any, n_sites: int) -> range:
    """Sites that are followed along x."""
    step = 1 if every is None else every
    if not isinstance(step, (int, np.integer)) or step < 0:
        raise ValueError(f"every: expected a whole number of sites, or 0 for none, found {every!r}")
    step = int(step)
    first, end = 0, n_sites
    if along is not None:
        ends = str(along if isinstance(along, str) else range_word(along)).split(":")
        if len(ends) != 2 or not all(one.strip().isdigit() for one in ends):
            raise ValueError(f"along: expected two site indices, the end excluded, found {along!r}")
        first, end = map(int, ends)
    if not 0 <= first < end <= n_sites:
        raise ValueError(f"along: expected sites from 0 to {n_sites - 1}, found {first} to {end - 1}")
    return range(first, end, step) if step else range(0)


def _groups_of_chosen(samples: Any, chosen: range, of_a_site: int) -> list[range]:
    """Chosen sites of a chunk that are summed together."""
    most = max(1, sums_at_hand(samples) // of_a_site)
    ends = np.cumsum((0, *samples.chunks[1])).tolist()
    groups = []
    for a, b in pairwise(ends):
        step = chosen.step
        low = chosen.start + step * max(0, -((chosen.start - a) // step))
        of_chunk = range(low, min(b, chosen.stop), step)
        n = math.ceil(len(of_chunk) / most)
        groups += [of_chunk[i * len(of_chunk) // n : (i + 1) * len(of_chunk) // n] for i in range(n)]
    return groups
