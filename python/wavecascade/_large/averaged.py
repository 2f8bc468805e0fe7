"""Averages over segments of Dask arrays: partial sums of blocks, joined in a tree."""

from __future__ import annotations

import json
import math
import re
import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, Unpack, get_args

import numpy as np
import numpy.typing as npt

from wavecascade import _native
from wavecascade._arrays.axes import AXES, Axes, Placed, placed
from wavecascade._arrays.fields import is_dataarray, plain
from wavecascade._arrays.results import dataset, summary_attrs
from wavecascade._commands.parts import words_of
from wavecascade._keywords.options import SpectrumOptions
from wavecascade._large.store import shown
from wavecascade._large.workers import WorkerMemory, warn_once

Array = npt.NDArray[Any]
Averaged = Literal["spectrum", "coherence"]

#: Partials that are joined by one task.
_FAN_IN = 2
#: Sites that the library sums together.
_TOGETHER = 8
#: Bytes of a cell of a result while it is made, nodes of the tree that a task has at hand, and bytes
#: that a task may have in any case.
_OF_A_CELL, _NODES, _LEAST_AT_ONCE = 128, 12, 64 << 20
#: What an array is over if it is known of each place by itself.
_PLACES = frozenset({"frequency", "position", "wavenumber"})
#: How a warning begins that is of each site by itself.
_COUNTED = re.compile(r"^\d+ of \d+ sites ")
#: Parts of a summary that are known without samples.
_KNOWN = (
    "along",
    "time_unit",
    "space_unit",
    "unit",
    "segment",
    "overlap",
    "half_bandwidth",
    "tapers_along_time",
    "tapers_along_space",
    "alpha",
    "level",
)


@dataclass(frozen=True)
class Work:
    """What all blocks of a field have in common."""

    words: list[str]
    #: Of the record.
    times: int
    name: str
    quantity: str | None
    unit: str | None
    #: By which its warnings are known to be of one computation.
    computation: str

    def samples(self, values: Array) -> _native.Samples:
        """An array ``(time, site)`` as samples."""
        return _native.Samples(
            values, name=self.name, quantity=self.quantity, unit=self.unit, is_layout_known=True
        )

    def partial(self, first: int, pieces: list[list[Any]], reference: list[Any] | None) -> Any:
        """The sums of a block, which comes in rows of chunks; the reference becomes its first site."""
        rows = [[plain(piece)[0] for piece in row] for row in pieces]
        columns = [] if reference is None else [plain(piece)[0] for piece in reference]
        samples = self.samples(_assembled(rows, columns))
        is_stated = any(word.startswith("--memory=") for word in self.words)
        worker = None if is_stated else WorkerMemory.here()
        if worker is None:
            return _native.partial([samples], self.words, (first, self.times))
        words = [*self.words, f"--memory={max(1, worker.task)}"]
        try:
            return _native.partial([samples], words, (first, self.times))
        except MemoryError as error:
            raise MemoryError(
                f"{error}, in a worker of {shown(worker.limit)} that runs {worker.at_once} tasks at once "
                f"beside {shown(worker.overhead)} of Python; give workers more memory or fewer threads, "
                "or take shorter segments or smaller chunks"
            ) from None


def _assembled(rows: list[list[Array]], columns: list[Array]) -> Array:
    """One array of several, with at most one copy."""
    if len(rows) == 1 and len(rows[0]) == 1 and not columns:
        return rows[0][0]
    kinds = [piece.dtype for row in rows for piece in row] + [piece.dtype for piece in columns]
    before = 1 if columns else 0
    shape = sum(len(row[0]) for row in rows), before + sum(piece.shape[1] for piece in rows[0])
    whole = np.empty(shape, np.result_type(*kinds))
    n = 0
    for at, row in enumerate(rows):
        stop = n + len(row[0])
        if columns:
            whole[n:stop, 0] = columns[at]
        m = before
        for piece in row:
            whole[n:stop, m : m + piece.shape[1]] = piece
            m += piece.shape[1]
        n = stop
    return whole


def _rows(chunk: Any, start: int, stop: int) -> Any:
    """Some times of a chunk, as a copy that does not hold the rest."""
    return np.array(chunk[start:stop])


def _partial_of(work: Work, first: int, pieces: list[list[Any]], reference: list[Any] | None) -> Any:
    return work.partial(first, pieces, reference)


def _joined(partials: list[Any]) -> Any:
    return _native.join(partials)


def _finished(
    work: Work, whole: Any, names: list[str], without_first: bool, of_sites: int | None
) -> dict[str, Any]:
    """These arrays of the result of all segments; ``of_sites`` in all, where these are only some."""
    found = _native.combine([whole])
    for _, message, advice in found["warnings"]:
        if of_sites is not None:
            # What other groups of sites find is not known here, and all that warn are to say the same.
            message = _COUNTED.sub(f"some of {of_sites} sites ", message)
        warn_once(f"{message} ({advice})", work.computation)
    arrays = {name: array for name, _, array, _ in found["arrays"] if name in names}
    if without_first:
        arrays = {name: array[..., 1:] for name, array in arrays.items()}
    if "steadiness" not in arrays:
        arrays["steadiness"] = np.float64(json.loads(found["summary"])["independence"]["steadiness"])
    return arrays


def averaged(
    field: Any,
    estimate: Averaged = "spectrum",
    *,
    reference: int | Any = None,
    **options: Unpack[SpectrumOptions],
) -> Any:
    """Averages over the segments of a Dask array, lazy: one task a chunk, then a tree of sums.

    As :func:`wavecascade.spectrum` with ``no_jackknife=True``, or :func:`wavecascade.coherence`, to the
    bit, for any chunks and workers. A chunk of times passes its neighbour the samples that their segments
    share; a chunk of sites stands by itself, except for ``along="both"``, where a task takes all sites of
    its times.

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
        The arrays of the estimate that are known of each site (or wavenumber) by itself, lazy, and
        ``steadiness``; the level of significance of a steady reference is an attribute.

    Raises
    ------
    ValueError
        For options that do not fit; when it is computed, for samples that do not.
    MemoryError
        When it is computed, for sums beyond ``memory``: by default, in a worker of Dask, the share of a
        task in its memory limit.

    Warns
    -----
    CascadeWarning
        When it is computed, once, as of :func:`spectrum` and :func:`coherence`; workers of a
        ``distributed.Client`` warn there. Of sites in several chunks it says that some have a transient.
    """
    if estimate not in get_args(Averaged):
        raise ValueError(
            f"estimate: expected spectrum or coherence, found {estimate!r}; a bicoherence is summed by "
            "partial and combine"
        )
    own: dict[str, Any] = dict(options)
    of_field = {
        name: own.pop(name) for name in list(own) if name in AXES | {"time_dim", "space_dim", "layout"}
    }
    found = placed(field, of_field)
    samples = found.samples
    if not found.is_lazy:
        raise ValueError(
            f"field: expected a Dask array, found {type(samples).__name__}; use partial and combine"
        )
    n_times, n_sites = map(int, samples.shape)
    compared = None
    if estimate == "coherence":
        compared = _reference(samples, 0 if reference is None else reference)
        own["reference"] = 0
    elif reference is not None:
        raise ValueError(f"reference: expected none with {estimate}, found {reference!r}")
    is_both = own.get("along") == "both"
    said = words_of(estimate, {**own, **_stated(found.axes), **_quantity(of_field)}, ["field"])
    work = _work(said, n_times, field, found)
    # Without a look at samples; other sites have arrays of the same kinds.
    silent = np.broadcast_to(np.float64(0.0), (2, n_sites if is_both else 2))
    known, cut = _native.outline(work.samples(silent), said, n_times)
    kept = [one for one in known["arrays"] if set(one[1]) <= _PLACES and one[1] != [one[0]]]
    # There is no jackknife in parts.
    kept = [one for one in kept if not one[0].startswith("jackknife")]
    names = [name for name, *_ in kept]

    import dask.array
    from dask.delayed import delayed

    dask_array: Any = dask.array
    groups = [(0, n_sites)]
    if not is_both:
        tapers = json.loads(known["summary"])["independence"]["tapers"]
        node = _bytes_of_a_node(estimate, cut, tapers)
        groups = _groups(samples, _OF_A_CELL * (cut[0] // 2 + 1) + _NODES * node)
    wholes = [_whole(work, cut, samples[:, a:b], compared) for a, b in groups]
    is_compared = compared is not None
    of_sites = n_sites if len(groups) > 1 else None
    results = [delayed(_finished)(work, whole, names, is_compared, of_sites) for whole in wholes]
    arrays = []
    for name, dims, array, attrs in kept:
        blocks = []
        for (a, b), result in zip(groups, results, strict=True):
            shape = (*array.shape[:-1], b - a if dims[-1] == "position" else array.shape[-1])
            blocks.append(dask_array.from_delayed(result[name], shape, array.dtype))
        arrays.append((name, dims, dask_array.concatenate(blocks, axis=-1), attrs))
    for name, dims, array, attrs in known["arrays"][:2]:
        places = found.axes.positions(0, n_sites) if name == "position" else array
        arrays.insert(0, (name, dims, places, attrs))
    summary = json.loads(known["summary"])
    independence = {key: summary["independence"][key] for key in ("segments", "tapers", "effective")}
    attrs = summary_attrs(known["summary"], [name for name in _KNOWN if name in summary])
    out = dataset({"attributes": {}, "arrays": arrays}, {**attrs, **independence})
    if "steadiness" not in names:
        single = dask_array.from_delayed(results[0]["steadiness"], (), np.float64)
        out["steadiness"] = single if isinstance(out, dict) else ((), single)
    return out


def _bytes_of_a_node(estimate: Averaged, cut: tuple[int, int, int], tapers: int) -> int:
    """Bytes of a site in a node of the tree: sums of each frequency, and of the pieces of its record."""
    length, hop, count = cut
    # Power and product with the reference; or power under each taper and, of several, the test for lines.
    of_a_bin = 3 if estimate == "coherence" else tapers + (5 if tapers > 1 else 0)
    reached = (count - 1) * hop + length
    pieces = reached // max(1, reached // 16) + 1
    return 8 * (of_a_bin * (length // 2 + 1) + 3 * pieces + 1)


def _groups(samples: Any, of_a_site: int) -> list[tuple[int, int]]:
    """Sites that are taken together: chunks, or pieces of those whose sums are much larger."""
    at_once = max(_LEAST_AT_ONCE, 2 * math.prod(samples.chunksize) * samples.dtype.itemsize)
    most = max(_TOGETHER, at_once // of_a_site // _TOGETHER * _TOGETHER)
    ends = np.cumsum((0, *samples.chunks[1])).tolist()
    pieces = [(a, b, -(-(b - a) // most)) for a, b in pairwise(ends)]
    return [(a + i * (b - a) // n, a + (i + 1) * (b - a) // n) for a, b, n in pieces for i in range(n)]


def _whole(work: Work, cut: tuple[int, int, int], samples: Any, compared: Any) -> Any:
    """The sums over all segments of some sites."""
    from dask.delayed import delayed

    length, hop, count = cut
    ends = np.cumsum((0, *samples.chunks[0])).tolist()
    blocks = samples.to_delayed()
    records: Any = None
    if compared is not None:
        records = [compared[a:b] for a, b in pairwise(ends)]
        if hasattr(compared, "dask"):
            records = compared.rechunk((samples.chunks[0],)).to_delayed()

    def taken(chunk: Any, piece: tuple[int, int, int]) -> Any:
        m, low, high = piece
        return chunk if (low, high) == (0, ends[m + 1] - ends[m]) else delayed(_rows)(chunk, low, high)

    leaves = []
    for n, (start, stop) in enumerate(pairwise(ends)):
        # Segments that begin in this chunk.
        first, last = -(-start // hop), min(-(-stop // hop), count) - 1
        if last < first:
            continue
        reach = last * hop + length
        pieces = []
        for m in range(n, len(ends) - 1):
            low, high = max(first * hop, ends[m]) - ends[m], min(reach, ends[m + 1]) - ends[m]
            if low < high:
                pieces.append((m, low, high))
            if ends[m + 1] >= reach:
                break
        parts = [[taken(block, piece) for block in blocks[piece[0]]] for piece in pieces]
        record = None if records is None else [taken(records[piece[0]], piece) for piece in pieces]
        leaves.append(delayed(_partial_of)(work, first * hop, parts, record))
    while len(leaves) > 1:
        leaves = [delayed(_joined)(leaves[i : i + _FAN_IN]) for i in range(0, len(leaves), _FAN_IN)]
    return leaves[0]


def _reference(samples: Any, reference: Any) -> Any:
    """The record of the reference."""
    if isinstance(reference, (int, np.integer)):
        if not 0 <= reference < samples.shape[1]:
            last = samples.shape[1] - 1
            raise ValueError(f"reference: expected a site from 0 to {last}, found {reference}")
        return samples[:, int(reference)]
    shape = tuple(np.shape(reference))
    if shape != (samples.shape[0],):
        raise ValueError(f"reference: expected {samples.shape[0]} samples, found the shape {shape}")
    return reference.data if is_dataarray(reference) else reference


def _stated(axes: Axes) -> dict[str, object]:
    """Axes as options; those that count samples or sites are not stated."""
    said: dict[str, object] = {}
    for step, origin, name in (("dt", "t0", "time"), ("dx", "x0", "space")):
        place = (axes.dt, axes.t0) if name == "time" else (axes.dx, axes.x0)
        if axes.units.get(name) is not None or place != (1.0, 0.0):
            said |= {step: place[0], origin: place[1], f"{name}_unit": axes.units.get(name)}
    return said


def _quantity(options: Mapping[str, object]) -> dict[str, object]:
    return {"quantity": options["quantity"]} if options.get("quantity") else {}


def _work(said: list[str], n_times: int, field: Any, found: Placed) -> Work:
    """With the name, the quantity and the unit of a whole field."""
    unit = found.axes.units.get("value")
    computation = uuid.uuid4().hex
    if not is_dataarray(field):
        return Work(said, n_times, "field", None, unit, computation)
    name = None if field.name is None else str(field.name)
    quantity = field.attrs.get("standard_name") or name
    return Work(said, n_times, name or "field", quantity, unit, computation)
