"""Fields and sweeps that have outgrown one machine, over Dask or executors of ``concurrent.futures``.

Averages are partial sums with a fixed tree (:func:`averaged`, and :func:`wavecascade.partial` for any
other engine), whole records go over a store of Zarr (:func:`plan_spacetime`), sweeps are split in parts
(:func:`sweep`). Nothing is rechunked, and bits depend on neither chunks nor workers.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from wavecascade._averages import arranged, averages, described
from wavecascade._axes import placed
from wavecascade._chains import Scene
from wavecascade._chains import sweep as _sweep
from wavecascade._segments import Cut, Of, Partial, add_block, combine, partial, reference_of
from wavecascade._spacetime import SpacetimePlan, open_spacetime, plan_spacetime
from wavecascade._store import Task, run_each
from wavecascade._words import Progress

__all__ = [
    "Partial",
    "SpacetimePlan",
    "averaged",
    "combine",
    "open_spacetime",
    "partial",
    "plan_spacetime",
    "sweep",
]

#: Partials that are added by one task.
_FAN_IN = 2


def _rows(chunk: Any, start: int, stop: int) -> Any:
    """Some times of a chunk, as a copy that does not hold the rest."""
    return np.array(chunk[start:stop])


def _partial_of(to: Partial, first: int, parts: list[list[Any]], reference: list[Any] | None) -> Partial:
    pieces = [row[0] if len(row) == 1 else np.concatenate(row, axis=1) for row in parts]
    return add_block(to, pieces, first, reference)


def _averages_of(whole: Partial, significance: float) -> dict[str, Any]:
    return averages(whole, significance)


def averaged(
    field: Any,
    *,
    segment: int,
    overlap: float = 0.5,
    of: Of = "temporal",
    reference: int | Any = None,
    window: Any = "hann",
    window_space: Any = "none",
    detrend: Literal["none", "mean", "linear"] = "mean",
    significance: float = 0.05,
    **options: Any,
) -> Any:
    """Averages over segments of a Dask array, lazy: one task a chunk, then a tree of sums.

    As ``combine([partial(field, ...)]).spectrum()``, with the same bits for any chunks and workers. A
    chunk of times passes its neighbour the samples that their segments share; a chunk of sites stands by
    itself, except for ``of="spacetime"``, where a task takes all sites of its times.

    Parameters
    ----------
    field
        ``xarray.DataArray`` over Dask, or a Dask array ``(time, site)``, in chunks of any sizes.
    reference
        For ``of="coherence"``, a site's index, or the record of the reference.
    significance
        Probability with which the true spectrum is outside of its interval.
    segment, overlap, of, window, window_space, detrend, **options
        As for :func:`wavecascade.partial`.

    Returns
    -------
    xarray.Dataset
        The arrays of :func:`wavecascade.combine`, lazy.

    Raises
    ------
    ValueError
        For options that do not fit; when it is computed, for samples that are not finite.
    """
    cut = Cut.new(of, segment, overlap, window, window_space, detrend)
    found = placed(field, options)
    samples = found.samples
    if not found.is_lazy:
        raise ValueError(
            f"field: expected a Dask array, found {type(samples).__name__}; use partial and combine"
        )
    if not 0.0 < significance < 1.0:
        raise ValueError(f"significance: expected a probability from 0 to 1, found {significance}")
    n_times, n_sites = map(int, samples.shape)
    count = cut.count(n_times)
    if count == 0:
        raise ValueError(f"segment: expected at most the {n_times} samples of a record, found {segment}")
    compared = reference_of(cut, samples, reference)

    import dask.array
    from dask.delayed import delayed

    dask_array: Any = dask.array
    ends = np.cumsum((0, *samples.chunks[0])).tolist()
    blocks = samples.to_delayed()
    records: Any = None
    if compared is not None:
        records = [compared[a:b] for a, b in pairwise(ends)]
        if hasattr(compared, "dask"):
            records = compared.rechunk((samples.chunks[0], 1)).to_delayed()[:, 0]

    # Sites that are taken together: chunks by themselves, or all.
    sites = samples.chunks[1] if of != "spacetime" else (n_sites,)
    groups = [[m] for m in range(len(sites))] if of != "spacetime" else [list(range(blocks.shape[1]))]
    results = []
    for width, group in zip(sites, groups, strict=True):
        leaves = []
        for n, (start, stop) in enumerate(pairwise(ends)):
            # Segments that begin in this chunk.
            first, last = -(-start // cut.hop), min(-(-stop // cut.hop), count) - 1
            if last < first:
                continue
            reach = last * cut.hop + cut.length
            pieces = []
            for m in range(n, len(ends) - 1):
                low, high = max(first * cut.hop, ends[m]) - ends[m], min(reach, ends[m + 1]) - ends[m]
                if low < high:
                    pieces.append((m, low, high))
                if ends[m + 1] >= reach:
                    break

            def taken(chunk: Any, piece: tuple[int, int, int]) -> Any:
                m, low, high = piece
                is_whole = (low, high) == (0, ends[m + 1] - ends[m])
                return chunk if is_whole else delayed(_rows)(chunk, low, high)

            parts = [[taken(blocks[piece[0], m], piece) for m in group] for piece in pieces]
            record = None if records is None else [taken(records[piece[0]], piece) for piece in pieces]
            empty = Partial(cut, found.axes, int(width))
            leaves.append(delayed(_partial_of)(empty, first, parts, record))
        while len(leaves) > 1:
            leaves = [delayed(combine)(leaves[i : i + _FAN_IN]) for i in range(0, len(leaves), _FAN_IN)]
        results.append(delayed(_averages_of)(leaves[0], significance))

    bins = segment // 2 + 1
    arrays: dict[str, Any] = {}
    names = ["spectrum", "degrees_of_freedom", "low", "high", "steadiness"]
    names += ["coherence", "phase", "cross_spectrum"] if of == "coherence" else []
    for name in names:
        is_single = name == "steadiness"
        dtype = np.complex128 if name == "cross_spectrum" else np.float64
        pieces_of = []
        for width, result in zip(sites, results, strict=True):
            single = (int(width) if of == "temporal" else 1,)
            shape = single if is_single else (bins, int(width))
            pieces_of.append(dask_array.from_delayed(result[name], shape, dtype))
        if is_single and of != "temporal":
            pieces_of = pieces_of[:1]
        arrays[name] = dask_array.concatenate(pieces_of, axis=-1)
    return arranged(cut, found.axes, n_sites, arrays, described(cut, found.axes, count, significance))


def _part(scene: Scene, vary: Any, out: str, part: str, keys: dict[str, Any]) -> int:
    """One part of a sweep, which resumes in its directory; how many members are known there."""
    return len(_sweep(scene, vary=vary, out=out, part=part, **keys)["failure"])


def sweep(
    scene: Scene = None,
    *,
    vary: Mapping[str, object] | str | Sequence[str],
    out: str | os.PathLike[str],
    pool: Any,
    parts: int | None = None,
    progress: Progress = None,
    **keys: Any,
) -> Any:
    """As :func:`wavecascade.sweep`, in parts over the workers of a pool.

    Every part keeps its finished members in ``OUT-parts/K-of-N``, and resumes there, in another worker if
    its own is lost. In the end all are merged into ``out``, where the table is that of one machine, byte
    for byte.

    Parameters
    ----------
    scene, vary, **keys
        As for :func:`wavecascade.sweep`; ``threads`` of each part, 1 by default.
    out
        Directory of the result, which all workers reach.
    pool
        A ``distributed.Client`` or an executor of ``concurrent.futures``.
    parts
        Into how many parts it is split, by default four a worker; a sweep that was begun keeps its own.
    progress
        As for :func:`analyze`, by parts.

    Returns
    -------
    pandas.DataFrame or dict
        A row for each member, as of :func:`wavecascade.sweep`.

    Raises
    ------
    ValueError
        For keys or values that are invalid, and for a directory that holds another sweep.
    """
    out = Path(os.path.abspath(out))
    if not isinstance(scene, Mapping) and scene is not None:
        scene = os.path.abspath(scene)
    beside = out.with_name(out.name + "-parts")
    keys.setdefault("threads", 1)
    if not (out / "table.csv").exists():
        begun = sorted({int(path.name.rpartition("-")[2]) for path in beside.glob("*-of-*")})
        if (out / "sweep.json").exists() and not begun:
            raise ValueError(
                f"{out}: expected a new directory, or a sweep that was split, found one begun in one "
                "part; end it with wavecascade.sweep"
            )
        if parts is not None and begun and begun != [parts]:
            raise ValueError(f"parts: expected {begun[0]}, as {beside} has it, found {parts}")
        if hasattr(pool, "scheduler_info"):
            workers = sum(pool.nthreads().values())
        else:
            workers = getattr(pool, "_max_workers", None) or os.cpu_count() or 1
        n = begun[0] if begun else (parts or 4 * workers)
        beside.mkdir(parents=True, exist_ok=True)
        # The split is kept, so that a part that was begun is found again.
        held = [beside / f"{k}-of-{n}" for k in range(1, n + 1)]
        tasks: list[Task] = [
            (path.name, _part, (scene, vary, str(path), f"{k}/{n}", keys))
            for k, path in enumerate(held, 1)
        ]
        run_each(tasks, lambda name, known: None, pool, "parts", progress)
        _merge(held, out)
    table = _sweep(scene, vary=vary, out=out, **keys)
    shutil.rmtree(beside, ignore_errors=True)
    return table


def _merge(parts: list[Path], out: Path) -> None:
    """``cascade sweep --merge``, in a process of its own."""
    code = "import sys; from wavecascade._program import main; sys.exit(main())"
    words = ["sweep", "--quiet", "--out", str(out), "--merge", *map(str, parts)]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True)
    if not (out / "table.csv").exists():
        raise RuntimeError(f"{out}: expected the parts to be merged, found: {done.stderr.strip()}")
