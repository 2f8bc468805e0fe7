"""Tasks of averages over segments of Dask arrays: partial sums of blocks, joined two by two."""

from __future__ import annotations

import json
import math
import re
import uuid
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from wavecascade import _native
from wavecascade._arrays.axes import Axes, Placed
from wavecascade._arrays.fields import is_dataarray, plain
from wavecascade._large.columns import Columns, Reference
from wavecascade._large.workers import Share, warn_once

Array = npt.NDArray[Any]

#: Partials that are joined by one task.
_FAN_IN = 2
#: States of sums that a task has at hand (two, and what becomes of them), and bytes that it may have
#: in any case.
STATES, _LEAST_AT_HAND = 4, 64 << 20
#: How a warning begins that is of each site by itself.
_COUNTED = re.compile(r"^\d+ of \d+ sites ")


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

    def stated(self, option: str) -> str | None:
        """What the words say of an option."""
        begin = f"--{option}="
        return next((word.removeprefix(begin) for word in self.words if word.startswith(begin)), None)

    def share(self, samples: int = 0) -> Share:
        """What a task may take beside so many bytes of samples."""
        return Share.of(self.stated("memory"), self.stated("threads"), samples)

    def outline(self, sites: int) -> tuple[dict[str, Any], tuple[int, int, int]]:
        """A result at so many sites without a look at samples, and how records are cut."""
        # The memory that is stated is that of a task, not of the client.
        words = [word for word in self.words if not word.startswith("--memory=")]
        silent = np.broadcast_to(np.float64(0.0), (2, sites))
        return _native.outline(self.samples(silent), words, self.times)

    def partial(
        self, first: int, pieces: list[list[Any]], reference: list[Any] | None, columns: Columns
    ) -> Any:
        """The sums of a block, which comes in rows of chunks; the reference becomes its first site."""
        rows = [[plain(piece)[0] for piece in row] for row in pieces]
        records = [] if reference is None else [plain(piece)[0] for piece in reference]
        block = _assembled(rows, records)
        own = [piece for row in rows for piece in row] + records
        held = sum(piece.nbytes for piece in own) + (0 if own[0] is block else block.nbytes)
        share = self.share(held)
        options = {"memory": share.memory, "threads": share.threads}
        words = self.words + [
            f"--{option}={value}"
            for option, value in options.items()
            if value is not None and self.stated(option) is None
        ]
        try:
            with share.explained():
                return _native.partial([self.samples(block)], words, (first, self.times))
        except ValueError as error:
            # The library counts the sites of the block.
            raise ValueError(columns.explained(str(error), block, first)) from None


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


def _partial_of(
    work: Work, first: int, pieces: list[list[Any]], reference: list[Any] | None, columns: Columns
) -> Any:
    return work.partial(first, pieces, reference, columns)


def _joined(work: Work, partials: list[Any]) -> Any:
    share = work.share()
    with share.explained():
        return _native.join(partials, share.memory)


def combined(work: Work, whole: Any) -> dict[str, Any]:
    """The result of all segments."""
    share = work.share()
    with share.explained():
        return _native.combine([whole], share.memory, threads=share.threads)


def finished(
    work: Work, whole: Any, names: list[str], without_first: bool, of_sites: int | None
) -> dict[str, Any]:
    """These arrays and all scalars of all segments; ``of_sites`` in all, where these are only some."""
    found = combined(work, whole)
    for _, message, advice in found["warnings"]:
        if of_sites is not None:
            # What other groups of sites find is not known here, and all that warn are to say the same.
            message = _COUNTED.sub(f"some of {of_sites} sites ", message)
        warn_once(f"{message} ({advice})", work.computation)
    arrays = {name: array for name, _, array, _ in found["arrays"] if name in names}
    if without_first:
        arrays = {name: array[..., 1:] for name, array in arrays.items()}
    summary = json.loads(found["summary"])
    return {"steadiness": np.float64(summary["independence"]["steadiness"])} | arrays


def summed(
    work: Work,
    cut: tuple[int, int, int],
    samples: Any,
    sites: range | list[int],
    reference: Reference | None,
) -> Any:
    """The sums over all segments of these sites of a field."""
    from dask.delayed import delayed

    length, hop, count = cut
    ends = np.cumsum((0, *samples.chunks[0])).tolist()
    index = slice(sites.start, sites.stop, sites.step) if isinstance(sites, range) else sites
    blocks = samples[:, index].to_delayed()
    columns = Columns.of(sites, reference)
    records: Any = None
    if reference is not None:
        compared = reference.record
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
        leaves.append(delayed(_partial_of)(work, first * hop, parts, record, columns))
    while len(leaves) > 1:
        groups = [leaves[i : i + _FAN_IN] for i in range(0, len(leaves), _FAN_IN)]
        # One that is left over goes up as it is.
        leaves = [delayed(_joined)(work, group) if len(group) > 1 else group[0] for group in groups]
    return leaves[0]


def sums_at_hand(samples: Any) -> int:
    """Bytes of sums that a task may have."""
    return max(_LEAST_AT_HAND, 2 * math.prod(samples.chunksize) * samples.dtype.itemsize)


def independence_of(known: Mapping[str, Any]) -> dict[str, Any]:
    """What is known of realisations without samples."""
    independence = json.loads(known["summary"])["independence"]
    return {key: independence[key] for key in ("segments", "tapers", "effective")}


def stated(axes: Axes, of_field: Mapping[str, object]) -> dict[str, object]:
    """Axes and quantity as options; axes that count samples or sites are not stated."""
    options: dict[str, object] = {}
    for step, origin, name in (("dt", "t0", "time"), ("dx", "x0", "space")):
        place = (axes.dt, axes.t0) if name == "time" else (axes.dx, axes.x0)
        if axes.units.get(name) is not None or place != (1.0, 0.0):
            options |= {step: place[0], origin: place[1], f"{name}_unit": axes.units.get(name)}
    return options | ({"quantity": of_field["quantity"]} if of_field.get("quantity") else {})


def work_of(words: list[str], n_times: int, field: Any, found: Placed) -> Work:
    """With the name, the quantity and the unit of a whole field."""
    unit = found.axes.units.get("value")
    computation = uuid.uuid4().hex
    if not is_dataarray(field):
        return Work(words, n_times, "field", None, unit, computation)
    name = None if field.name is None else str(field.name)
    quantity = field.attrs.get("standard_name") or name
    return Work(words, n_times, name or "field", quantity, unit, computation)
