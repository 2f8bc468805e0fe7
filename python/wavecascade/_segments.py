"""Averages over segments as partial sums, which add up to the same bits however they are shared out.

Segment ``s`` of a record begins at sample ``s hop``. Sums over segments are those of a binary tree over
their indices: node ``(k, i)`` holds segments ``i 2^k`` to ``(i + 1) 2^k - 1``, and is the sum of nodes
``(k - 1, 2 i)`` and ``(k - 1, 2 i + 1)``. A :class:`Partial` holds the largest nodes that its segments
fill, so that the bits of the whole depend neither on the blocks nor on the order in which they arrive.
"""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from wavecascade._axes import Axes, placed
from wavecascade._windows import columns, detrended, pairwise_sum, sum_of, window

Array = npt.NDArray[Any]
Of = Literal["temporal", "spacetime", "coherence"]
Sums = dict[str, Array]

#: Samples of the segments that are transformed at once, in bytes.
_BATCH = 4 << 20


@dataclass(frozen=True)
class Cut:
    """How records become segments, and what is summed over them."""

    of: str
    length: int
    hop: int
    window: Any = "hann"
    window_space: Any = "none"
    detrend: str = "mean"

    def __post_init__(self) -> None:
        if self.of not in ("temporal", "spacetime", "coherence"):
            raise ValueError(f"of: expected temporal, spacetime or coherence, found {self.of!r}")
        if self.length < 4:
            raise ValueError(f"segment: expected at least 4 samples, found {self.length}")
        if not 1 <= self.hop <= self.length:
            last, found = self.length - 1, self.length - self.hop
            raise ValueError(f"overlap: expected 0 to {last} samples, or a share below 1, found {found}")
        if self.detrend not in ("none", "mean", "linear"):
            raise ValueError(f"detrend: expected none, mean or linear, found {self.detrend!r}")
        window(self.window, self.length)

    @classmethod
    def new(
        cls, of: str, segment: int, overlap: float, window: Any, window_space: Any, detrend: str
    ) -> Cut:
        """From what a caller states: an overlap in samples, or as a share of a segment."""
        shared = int(overlap * segment) if isinstance(overlap, float) else int(overlap)

        def listed(weights: Any) -> Any:
            return weights if isinstance(weights, str) else tuple(np.asarray(weights, float).tolist())

        return cls(of, segment, segment - shared, listed(window), listed(window_space), detrend)

    def count(self, samples: int) -> int:
        """Segments that fit in ``samples``."""
        return 0 if samples < self.length else 1 + (samples - self.length) // self.hop

    def taper(self) -> Array:
        """The window with sum w^2 = 1."""
        weights = window(self.window, self.length)
        return np.asarray(weights / np.sqrt(sum_of(weights * weights)))


def _added(a: Sums, b: Sums) -> Sums:
    return {name: a[name] + b[name] for name in a}


@dataclass
class Partial:
    """Sums over some segments of a field; see :func:`partial`."""

    cut: Cut
    axes: Axes
    sites: int
    nodes: dict[tuple[int, int], Sums] = field(default_factory=dict)

    @property
    def ranges(self) -> list[tuple[int, int]]:
        """The segments it holds, as ``(from, to)`` without ``to``, in order."""
        found: list[tuple[int, int]] = []
        for start, stop in sorted((i << k, (i + 1) << k) for k, i in self.nodes):
            if found and found[-1][1] == start:
                found[-1] = (found[-1][0], stop)
            else:
                found.append((start, stop))
        return found

    @property
    def segments(self) -> int:
        """How many segments it holds."""
        return sum(1 << k for k, _ in self.nodes)

    def __repr__(self) -> str:
        held = ", ".join(f"{a} to {b - 1}" for a, b in self.ranges) or "none"
        return f"<Partial of {self.cut.of}: {self.segments} segments of {self.cut.length}: {held}>"

    def add(self, level: int, index: int, sums: Sums) -> None:
        """Add a node, and join it with its neighbours as far as they are there."""
        start, stop = index << level, (index + 1) << level
        for k, i in self.nodes:
            if i << k < stop and start < (i + 1) << k:
                raise ValueError(
                    f"partials: expected each segment once, found segment {max(start, i << k)} twice"
                )
        while (level, index ^ 1) in self.nodes:
            other = self.nodes.pop((level, index ^ 1))
            sums = _added(other, sums) if index & 1 else _added(sums, other)
            level, index = level + 1, index >> 1
        self.nodes[level, index] = sums

    def total(self) -> Sums:
        """The sums over all segments, of which none may be missing.

        Raises
        ------
        ValueError
            For no segments, and for a gap between them.
        """
        ranges = self.ranges
        if not ranges or ranges[0][0] != 0 or len(ranges) > 1:
            first = ranges[0] if ranges else (0, 0)
            gap = (0, first[0] - 1) if first[0] else (first[1], ranges[1][0] - 1 if ranges[1:] else "on")
            raise ValueError(
                f"partials: expected all segments from 0 on, found none of {gap[0]} to {gap[1]}; "
                "combine the partials that hold them"
                if ranges
                else "partials: expected at least one segment, found none"
            )
        # As the tree has it where its last nodes lack segments.
        nodes = [self.nodes[key] for key in sorted(self.nodes, key=lambda key: key[1] << key[0])]
        total = nodes.pop()
        while nodes:
            total = _added(nodes.pop(), total)
        return total

    def spectrum(self, significance: float = 0.05) -> Any:
        """The average with its degrees of freedom and intervals; see :func:`combine`."""
        from wavecascade._averages import averaged

        return averaged(self, significance)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it to an archive ``.npz``, whole or not at all."""
        path = Path(path)
        axes = asdict(self.axes)
        axes["spectra"] = [[*key, unit] for key, unit in self.axes.spectra.items()]
        head: dict[str, Any] = {"schema": "wavecascade.partial/1", "cut": asdict(self.cut), "axes": axes}
        head |= {"sites": self.sites}
        arrays = {"head": np.array(json.dumps(head))}
        for (k, i), sums in self.nodes.items():
            arrays |= {f"{k}/{i}/{name}": array for name, array in sums.items()}
        beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}.npz")
        try:
            with beside.open("wb") as file:
                np.savez(file, **arrays)  # type: ignore[arg-type]
                file.flush()
                os.fsync(file.fileno())
            beside.replace(path)
        finally:
            beside.unlink(missing_ok=True)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Partial:
        """Read what :meth:`save` wrote.

        Raises
        ------
        ValueError
            For another archive.
        """
        with np.load(path, allow_pickle=False) as archive:
            head = json.loads(str(archive["head"])) if "head" in archive.files else {}
            if head.get("schema") != "wavecascade.partial/1":
                raise ValueError(f"{os.fspath(path)}: expected what Partial.save wrote, found no partial")
            nodes: dict[tuple[int, int], Sums] = {}
            for name in archive.files:
                if name != "head":
                    k, i, what = name.split("/")
                    nodes.setdefault((int(k), int(i)), {})[what] = archive[name]
        cut, axes = head["cut"], head["axes"]
        axes["spectra"] = {(which, scaling): unit for which, scaling, unit in axes["spectra"]}
        for name in ("window", "window_space"):
            cut[name] = cut[name] if isinstance(cut[name], str) else tuple(cut[name])
        return cls(Cut(**cut), Axes(**axes), head["sites"], nodes)


def _energies(x: Array) -> Sums:
    """Of the energies of segments, for how evenly they are spread."""
    energy = pairwise_sum(np.square(x))
    return {"energy": energy, "energy_squared": energy * energy}


def _powers(transforms: Array) -> Array:
    return np.asarray(transforms.real * transforms.real + transforms.imag * transforms.imag)


def _joined(level: int, sums: Sums) -> Sums:
    """The node of ``2^level`` segments, pair by pair."""
    for _ in range(level):
        sums = {name: a[0::2] + a[1::2] for name, a in sums.items()}
    return {name: a[0] for name, a in sums.items()}


@dataclass(frozen=True)
class Work:
    """What the segments of a block have in common."""

    cut: Cut
    taper: Array
    across: Array | None

    def transforms(self, x: Array) -> Array:
        """Along time, of segments without their trends."""
        return columns(x * self.taper[None, :, None], 1, real=True)

    def spacetime(self, segments: Array) -> Sums:
        """Of segments of all sites."""
        from wavecascade import fft

        x = detrended(segments, self.cut.detrend)
        energy = pairwise_sum(np.square(x)).sum(axis=1, keepdims=True)
        found = self.transforms(x)
        if self.across is not None:
            found = found * self.across
        found = np.fft.fftshift(fft.c2c(found, 2, norm="forward", inverse=True), axes=2)
        return {"power": _powers(found), "energy": energy, "energy_squared": energy * energy}

    def sites(self, segments: Array, own: Array | None) -> Sums:
        """Of segments of some sites, beside the transforms of the reference."""
        x = detrended(segments, self.cut.detrend)
        found = self.transforms(x)
        if own is None:
            return {"power": _powers(found), **_energies(x)}
        cross = np.empty(found.shape, np.complex128)
        cross.real = own.real * found.real + own.imag * found.imag
        cross.imag = own.real * found.imag - own.imag * found.real
        return {"power": _powers(found), "cross": cross}


def _check(pieces: list[Array], first_time: int) -> None:
    """Refuses samples that are no finite real numbers."""
    for piece in pieces:
        if piece.dtype.kind not in "fiub":
            raise TypeError(f"field: expected real numbers, found {piece.dtype}")
        # In parts, since the answers take memory of their own.
        step = max(1, _BATCH // max(1, piece.shape[1]))
        for row in range(0, len(piece), step):
            finite = np.isfinite(piece[row : row + step])
            if not finite.all():
                n, j = np.argwhere(~finite)[0]
                raise ValueError(
                    f"field: expected finite samples, found {piece[row + n, j]} at time "
                    f"{first_time + row + n}, site {j} of the block; fill gaps first"
                )
        first_time += len(piece)


def add_block(
    to: Partial, pieces: list[Array], first: int, reference: list[Array] | None = None
) -> Partial:
    """Add the segments of a block, whose first row is the first sample of segment ``first``.

    The block and the record of the reference come in pieces, one after another in time.
    """
    cut = to.cut
    count = cut.count(sum(map(len, pieces)))
    if count == 0:
        return to
    _check(pieces, first * cut.hop)
    sites = pieces[0].shape[1]
    weights = window(cut.window_space, sites) if cut.of == "spacetime" else None
    across = None if weights is None or (weights == 1.0).all() else weights
    work = Work(cut, cut.taper(), across)
    together = sites if cut.of == "spacetime" else min(sites, 8)
    batch = max(1, _BATCH // (8 * cut.length * together)).bit_length() - 1

    def cut_out(pieces: list[Array], at: int, n: int, columns: slice) -> Array:
        """``n`` segments of some sites."""
        start = (at - first) * cut.hop
        stop, taken = start + (n - 1) * cut.hop + cut.length, []
        for piece in pieces:
            if stop > 0 and start < len(piece):
                taken.append(piece[max(start, 0) : stop, columns])
            start, stop = start - len(piece), stop - len(piece)
        rows = taken[0] if len(taken) == 1 else np.concatenate(taken)
        view = np.lib.stride_tricks.sliding_window_view(rows, cut.length, axis=0)[:: cut.hop]
        return np.ascontiguousarray(view.transpose(0, 2, 1), np.float64)

    at = first
    while at < first + count:
        # The largest node that begins here, is not too much at once, and is filled.
        lowest = (at & -at).bit_length() - 1 if at else batch
        level = min(lowest, batch, (first + count - at).bit_length() - 1)
        n = 1 << level
        if cut.of == "spacetime":
            sums = _joined(level, work.spacetime(cut_out(pieces, at, n, slice(None))))
        else:
            sums, own = {}, None
            if reference is not None:
                x = detrended(cut_out(reference, at, n, slice(None)), cut.detrend)
                own = work.transforms(x)
                sums = _joined(level, {"reference": _powers(own), **_energies(x)})
            step = max(8, _BATCH // (8 * cut.length * n))
            for j in range(0, sites, step):
                columns = slice(j, min(j + step, sites))
                part = _joined(level, work.sites(cut_out(pieces, at, n, columns), own))
                for name, array in part.items():
                    if name not in sums:
                        sums[name] = np.empty((*array.shape[:-1], sites), array.dtype)
                    sums[name][..., columns] = array
        to.add(level, at >> level, sums)
        at += n
    return to


def partial(
    field: Any,
    *,
    segment: int,
    overlap: float = 0.5,
    first: int = 0,
    of: Of = "temporal",
    reference: Any = None,
    window: Any = "hann",
    window_space: Any = "none",
    detrend: Literal["none", "mean", "linear"] = "mean",
    **options: Any,
) -> Partial:
    """Sums over the segments of one block of a field, for :func:`combine`.

    With X_s the transforms of the windowed segments, ``of="temporal"`` sums |X_s(f, x)|^2,
    ``"spacetime"`` |X_s(k, f)|^2, and ``"coherence"`` also conj(X_s(f, r)) X_s(f, x) of a reference r.

    Parameters
    ----------
    field
        Samples ``(time, site)`` of NumPy or xarray; its first row is sample ``first * hop`` of the whole,
        with ``hop`` the samples of a segment that its neighbour does not share. Rows at the end that fill
        no segment are left out: the next block begins ``hop`` after the last segment's beginning.
    segment, overlap
        Samples of a segment; samples (an integer) or the share (a float) that neighbours have in common.
    first
        Index of the block's first segment.
    of
        What is summed.
    reference
        For ``"coherence"``: a site's index in the block, or the record of the reference, as long as it.
    window, window_space
        A name, such as ``"hann"``, ``"none"`` or ``"tukey:0.1"``, or an array of weights; along space
        for ``"spacetime"`` alone.
    detrend
        What is removed from each segment.
    **options
        ``dt``, ``dx``, units and so on, as for :func:`analyze`.

    Returns
    -------
    Partial
        The sums; :meth:`Partial.save` and :meth:`Partial.load` take them to other machines.

    Raises
    ------
    ValueError
        For options that do not fit, and for samples that are not finite.
    """
    if first < 0:
        raise ValueError(f"first: expected the index of a segment, from 0 on, found {first}")
    cut = Cut.new(of, segment, overlap, window, window_space, detrend)
    found = placed(field, options)
    samples: Array = np.asarray(found.samples)
    record = reference_of(cut, samples, reference)
    whole = Partial(cut, found.axes, samples.shape[1])
    return add_block(whole, [samples], first, None if record is None else [record])


def reference_of(cut: Cut, samples: Any, reference: Any) -> Any:
    """The record of the reference as one column; ``None`` without a reference."""
    if (cut.of == "coherence") != (reference is not None):
        expected = "a site, or its record" if cut.of == "coherence" else f"none with of={cut.of!r}"
        raise ValueError(f"reference: expected {expected}, found {reference!r}")
    if reference is None:
        return None
    if isinstance(reference, (int, np.integer)):
        if not 0 <= reference < samples.shape[1]:
            last = samples.shape[1] - 1
            raise ValueError(f"reference: expected a site from 0 to {last}, found {reference}")
        return samples[:, int(reference) : int(reference) + 1]
    shape = tuple(np.shape(reference))
    if shape != (samples.shape[0],):
        raise ValueError(f"reference: expected {samples.shape[0]} samples, found the shape {shape}")
    return reference[:, None]


def combine(partials: Iterable[Partial]) -> Partial:
    """All segments of several partials, in any order, with the same bits for any of them.

    ``combine(partials).spectrum()`` is the average: an ``xarray.Dataset`` with

    - ``spectrum``, the one-sided power spectral density S = 2 dt <|X|^2> / sum w^2 (over 2 pi and times
      dx / sum w_x^2 for S(k, f)), of shape (frequency, position) or (frequency, wavenumber_signed),
    - ``degrees_of_freedom``, and ``low`` and ``high``, the ends of the interval by the chi-square
      distribution; NaN where the energy is spread over the segments as that of a transient, which is one
      realisation, and at f = 0 where means are removed,
    - ``steadiness``, (sum e)^2 / (n sum e^2) of the energies of the n segments,
    - of coherence also ``coherence``, ``phase`` and ``cross_spectrum``, with the level as an attribute.

    Raises
    ------
    ValueError
        For partials of different fields or options, segments that appear twice, and, from ``spectrum``,
        segments that are missing.
    """
    whole: Partial | None = None
    for one in partials:
        if whole is None:
            whole = Partial(one.cut, one.axes, one.sites, dict(one.nodes))
            continue
        if (one.cut, one.sites) != (whole.cut, whole.sites) or not one.axes.agrees(whole.axes):
            raise ValueError(
                f"partials: expected those of one field with one set of options, found {whole!r} with "
                f"{whole.sites} sites and {one!r} with {one.sites} sites, or other steps or units"
            )
        for (level, index), sums in sorted(one.nodes.items()):
            whole.add(level, index, sums)
    if whole is None:
        raise ValueError("partials: expected at least one, found none")
    return whole
