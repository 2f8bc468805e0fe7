"""Fields and sweeps that have outgrown one machine, over Dask or executors of ``concurrent.futures``.

Averages are partial sums (:func:`averaged`, and :func:`wavecascade.partial` for any other engine),
whole records go over a store of Zarr (:func:`plan_spacetime`), sweeps are split in parts
(:func:`sweep`). Nothing is rechunked, and bits do not depend on workers.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wavecascade._commands.chains import Scene
from wavecascade._commands.chains import sweep as _sweep
from wavecascade._commands.parts import combine, partial
from wavecascade._keywords.words import Progress
from wavecascade._large.averaged import averaged
from wavecascade._large.spacetime import SpacetimePlan, open_spacetime, plan_spacetime
from wavecascade._large.store import Task, run_each
from wavecascade._native import Partial

if TYPE_CHECKING:
    import pandas as pd

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
) -> pd.DataFrame:
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
