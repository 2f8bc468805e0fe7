"""S(k, f) of a whole record that no worker can hold: planned, then run over a store of Zarr."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from wavecascade._arrays.axes import Axes, placed
from wavecascade._keywords.words import Progress
from wavecascade._large.blocks import blocks, bytes_read, identity_of, longest_of, source_of
from wavecascade._large.halves import (
    CHUNK,
    Job,
    Source,
    along_space,
    along_time,
    first_bytes,
    second_bytes,
)
from wavecascade._large.store import Journal, Task, differing, run_each, shown
from wavecascade._large.windows import sum_of, window
from wavecascade._large.workers import WorkerMemory
from wavecascade._native import version

Array = npt.NDArray[Any]
#: Name of the journal of a store that is not finished.
JOURNAL = ".journal"
Scaling = Literal["energy", "density", "spectrum"]


@dataclass
class SpacetimePlan:
    """What :func:`plan_spacetime` found; ``print`` shows it, :meth:`run` does it."""

    job: Job
    axes: Axes
    source: Any
    scaling: str
    worker: WorkerMemory
    parseval_factor: float
    identity: dict[str, Any]
    bytes_read: int

    @property
    def blocks(self) -> tuple[int, int]:
        """Blocks of times and of wavenumbers."""
        bins = self.job.shape[1] // 2 + 1
        return len(self.job.bounds) - 1, -(-bins // self.job.wavenumbers)

    @property
    def tasks(self) -> int:
        """Tasks of both halves."""
        return sum(self.blocks)

    @property
    def bytes_between(self) -> int:
        """Bytes that are written between the halves, and read again."""
        return 16 * self.job.shape[0] * (self.job.shape[1] // 2 + 1)

    @property
    def bytes_written(self) -> int:
        """Bytes of the result."""
        return 16 * (self.job.shape[0] // 2 + 1) * (self.job.shape[1] // 2 + 1)

    @property
    def files(self) -> int:
        """Files between the halves."""
        return self.blocks[0] * self.blocks[1]

    @property
    def peak_bytes(self) -> int:
        """Memory of a worker at most, with what Python takes."""
        rows = longest_of(self.job.bounds)
        nt, nx = self.job.shape
        task = max(first_bytes(rows, nx), second_bytes(nt, self.job.wavenumbers))
        return self.worker.overhead + self.worker.at_once * task

    def __str__(self) -> str:
        nt, nx = self.job.shape
        first, second = self.blocks
        rows = longest_of(self.job.bounds)
        piece = 16 * rows * self.job.wavenumbers
        field = f"S(k, f) of {nt} times x {nx} sites: {shown(8 * nt * nx)} in double precision"
        lines = [
            field,
            f"  1. along x    {first} tasks of {rows} times         read {shown(self.bytes_read)}, "
            f"write {shown(self.bytes_between)} in {self.files} pieces of {shown(piece)}",
            f"  2. along t    {second} tasks of {self.job.wavenumbers} wavenumbers  "
            f"read {shown(self.bytes_between)}, write {shown(self.bytes_written)}",
            f"  moved         {shown(self.bytes_read + 2 * self.bytes_between + self.bytes_written)}",
            f"  memory        {shown(self.peak_bytes)} of a worker's {shown(self.worker.limit)}, "
            f"{shown(self.worker.overhead)} of it Python's",
            f"  disk          {shown(self.bytes_between + self.bytes_written)} in {self.job.store}, "
            f"{shown(self.bytes_written)} once it is done",
        ]
        return "\n".join(lines)

    def run(self, pool: Any = None, *, progress: Progress = None) -> Any:
        """Do what is not done yet, and open the result.

        Parameters
        ----------
        pool
            A ``distributed.Client``, an executor of ``concurrent.futures``, or ``None`` for this process.
        progress
            As for :func:`analyze`.

        Returns
        -------
        xarray.DataArray
            S(k, f), lazy, as :func:`open_spacetime` opens it.

        Raises
        ------
        ValueError
            For samples that are not finite, and for a store that holds other work.
        RuntimeError
            For a store that another process fills, and where energy is not conserved to 1e-10.
        """
        path = Path(self.job.store)
        held = finished(path)
        if held is not None:
            if held != self.identity:
                raise ValueError(differing(path, held, self.identity))
            return open_spacetime(path)
        others = path.exists() and any(path.iterdir()) and not (path / JOURNAL).exists()
        if others or (path.exists() and not path.is_dir()):
            raise ValueError(f"{path}: expected a new or an unfinished store, found something else")
        with Journal(path / JOURNAL, self.identity).opened() as journal:
            if "created" not in journal.done:
                self._create(path)
                journal.add("created", version)
            self._half(journal, "x", self.blocks[0], "along x", pool, progress)
            self._half(journal, "t", self.blocks[1], "along t", pool, progress)
            self._finish(path, journal)
        return open_spacetime(path)

    def _half(
        self, journal: Journal, half: str, count: int, stage: str, pool: Any, progress: Progress
    ) -> None:
        names = [(f"{half}{i}", i) for i in range(count) if f"{half}{i}" not in journal.done]
        make = self._first if half == "x" else self._second
        tasks: list[Task] = [(name, *make(i)) for name, i in names]
        run_each(tasks, journal.add, pool, stage, progress)

    def _first(self, i: int) -> tuple[Any, tuple[Any, ...]]:
        start, stop = self.job.bounds[i], self.job.bounds[i + 1]
        if isinstance(self.source, Source):
            return along_space, (self.job, i, self.source)
        if not hasattr(self.source, "dask"):
            return along_space, (self.job, i, self.source[start:stop])
        from dask.delayed import delayed

        ends = np.cumsum((0, *self.source.chunks[0]))
        rows = [n for n in range(len(ends) - 1) if start <= ends[n] < stop]
        parts = [
            [self.source.blocks[n, m].to_delayed().item() for m in range(self.source.numblocks[1])]
            for n in rows
        ]
        return None, (delayed(along_space)(self.job, i, parts),)

    def _second(self, j: int) -> tuple[Any, tuple[Any, ...]]:
        return along_time, (self.job, j)

    def _create(self, path: Path) -> None:
        import zarr

        for name in ("intermediate", "spacetime_spectrum", "frequency", "side", "wavenumber"):
            shutil.rmtree(path / name, ignore_errors=True)
        nt, nx = self.job.shape
        bins, width = nx // 2 + 1, self.job.wavenumbers
        rows = longest_of(self.job.bounds)
        attrs = {
            "scaling": self.scaling,
            "dt": self.axes.dt,
            "dx": self.axes.dx,
            "n_sites": nx,
            "units": dict(self.axes.units),
            "sign": "plane wave exp(i (k x - 2 pi f t)): side 1 has k >= 0 and travels towards +x",
        }
        (path / "zarr.json").unlink(missing_ok=True)
        group = zarr.create_group(path, attributes=attrs, overwrite=False)
        bare: dict[str, Any] = {"compressors": None}
        group.create_array(
            "intermediate",
            shape=(len(self.job.bounds) - 1, rows, bins),
            chunks=(1, rows, min(width, bins)),
            dtype="c16",
            **bare,
        )
        nf = nt // 2 + 1
        unit = self.axes.spectra.get(("spacetime", self.scaling))
        group.create_array(
            "spacetime_spectrum",
            shape=(nf, 2, bins),
            chunks=(min(self.job.chunk, nf), 2, min(width, bins)),
            dtype="f8",
            fill_value=np.nan,
            dimension_names=("frequency", "side", "wavenumber"),
            attributes={"units": unit} if unit else {},
            **bare,
        )
        units = self.axes.units
        for name, values, own in (
            ("frequency", self.axes.frequency(nt), units.get("frequency")),
            ("side", np.array([-1, 1]), None),
            ("wavenumber", self.axes.wavenumber(nx), units.get("wavenumber")),
        ):
            array = group.create_array(
                name,
                data=values,
                dimension_names=(name,),
                attributes={"units": own} if own else {},
            )
            del array

    def _finish(self, path: Path, journal: Journal) -> None:
        """Parseval: what went in against what came out."""
        import zarr

        def total(half: str, count: int) -> float:
            return float(sum((Fraction(journal.done[f"{half}{i}"]) for i in range(count)), Fraction(0)))

        before = total("x", self.blocks[0]) * self.parseval_factor
        after = total("t", self.blocks[1])
        residual = after / before - 1.0 if before else after
        if abs(residual) > 1e-10:
            raise RuntimeError(
                f"{path}: expected the energy of the samples in the spectrum, found it {residual:.1e} "
                "apart; was the field written to meanwhile?"
            )
        # Finished is what has its request in its attributes.
        zarr.open_group(path, mode="r+").update_attributes(
            {"parseval": residual, "request": self.identity}
        )
        shutil.rmtree(path / "intermediate", ignore_errors=True)
        journal.path.unlink()


def plan_spacetime(
    field: Any,
    store: str | os.PathLike[str],
    pool: Any = None,
    *,
    memory: int | str | None = None,
    at_once: int | None = None,
    scaling: Scaling = "energy",
    window_time: Any = "none",
    window_space: Any = "none",
    show: bool = True,
    **options: Any,
) -> SpacetimePlan:
    """Plan S(k, f) of a whole record that is larger than the memory of a worker.

    S(k, f) = 2 / (L T) |sum v(t, x) exp(i (k x - 2 pi f t)) dt dx|^2 / (2 pi), here as a density, as
    :func:`analyze` has it, to rounding. Blocks of times are transformed along x and written to ``store``,
    in pieces of few wavenumbers; then each block of wavenumbers is read and transformed along t. Nothing
    is rechunked, no worker sends samples to another, and the bits depend on neither blocks nor workers.

    Parameters
    ----------
    field
        Samples (time, site): the path of a store of Zarr, which workers read by themselves, with the
        coordinates beside the array, a Dask array or a DataArray over one, or an array of NumPy.
        ``layout="site-time"`` turns an array round.
    store
        Directory of the result, which all workers reach. Finished blocks are kept there: a plan of the
        same field and store goes on where the last one ended.
    pool
        The ``distributed.Client`` whose workers are planned for.
    memory
        What one worker may take, such as ``"450 MB"``; by default the limit of the client's workers.
    at_once
        Tasks of a worker at once, by default its threads.
    scaling, window_time, window_space
        As for :func:`analyze`; windows as names or as arrays of weights.
    show
        Print the plan.
    **options
        ``dt``, ``dx``, units and so on, as for :func:`analyze`.

    Returns
    -------
    SpacetimePlan
        Bytes moved, peak memory, tasks; nothing is computed or written before :meth:`SpacetimePlan.run`.

    Raises
    ------
    ValueError
        For a field that does not fit: the message says what memory would do.
    """
    if scaling not in ("energy", "density", "spectrum"):
        raise ValueError(f"scaling: expected energy, density or spectrum, found {scaling!r}")
    source, array = source_of(field)
    given: dict[str, object] = dict(options)
    if source is not None and not hasattr(array, "dims"):
        is_turned = given.pop("layout", None) == "site-time"
        shape = array.shape[::-1] if is_turned else array.shape
        array = np.broadcast_to(np.float64(0.0), shape)
        source = Source(source.path, source.array, is_turned)
    found = placed(array, given)
    if source is not None and hasattr(array, "dims"):
        source = Source(source.path, source.array, found.dims[0] != array.dims[0])
    nt, nx = map(int, found.samples.shape)
    if nt < 2 or nx < 2:
        raise ValueError(f"field: expected at least 2 times and 2 sites, found {nt} and {nx}")
    samples: Any = found.samples if source is None else source
    worker = WorkerMemory.of(pool, memory, at_once)
    bounds, width = blocks(samples, (nt, nx), worker)
    held = finished(Path(store)) or Journal.read(Path(store) / JOURNAL)[0]
    if held is not None and "bounds" in held:
        # Blocks that were begun are kept, if they fit.
        bounds, width = tuple(held["bounds"]), held["wavenumbers"]
    needed = max(first_bytes(longest_of(bounds), nx), second_bytes(nt, width))
    worker.check("the blocks that the store was begun with need", needed)

    weights = window(window_time, nt), window(window_space, nx)
    factor, total = _scale(scaling, weights, (nt, nx), found.axes)
    chunk = max(1, CHUNK // (16 * width))
    names = [w if isinstance(w, str) else tuple(map(float, w)) for w in (window_time, window_space)]
    job = Job(os.path.abspath(store), (nt, nx), bounds, width, chunk, names[0], names[1], factor)
    identity = {
        "schema": "wavecascade.spacetime/1",
        "version": version,
        "field": identity_of(samples),
        "shape": [nt, nx],
        "axes": json.loads(json.dumps({k: v for k, v in asdict(found.axes).items() if k != "spectra"})),
        "scaling": scaling,
        "windows": [w if isinstance(w, str) else list(w) for w in names],
        "bounds": list(bounds),
        "wavenumbers": width,
    }
    plan = SpacetimePlan(
        job,
        found.axes,
        samples,
        scaling,
        worker,
        total,
        identity,
        bytes_read(samples, bounds),
    )
    if show:
        print(plan)
    return plan


def _scale(
    scaling: str, weights: tuple[Array, Array], shape: tuple[int, int], axes: Axes
) -> tuple[float, float]:
    """S / |X|^2, and sum S / sum (w v)^2."""
    factor = 1.0
    for w, n, step, turn in zip(weights, shape, (axes.dt, axes.dx), (1.0, 2.0 * np.pi), strict=True):
        power = sum_of(w * w)
        if scaling == "spectrum":
            factor *= 1.0 / sum_of(w) ** 2
        else:
            factor *= step / power / turn * (n * step if scaling == "energy" else 1.0)
    return factor, factor * shape[0] * shape[1]


def finished(path: Path) -> dict[str, Any] | None:
    """The request that a finished store answers."""
    if not (path / "zarr.json").exists():
        return None
    text = json.loads((path / "zarr.json").read_text())
    request = text.get("attributes", {}).get("request")
    return request if isinstance(request, dict) else None


def open_spacetime(store: str | os.PathLike[str]) -> Any:
    """S(k, f) of a finished store as a lazy ``xarray.DataArray`` (frequency, wavenumber_signed).

    In the store, ``spacetime_spectrum`` is (frequency, side, wavenumber): side -1 has the wavenumbers
    below 0, +1 the others; k = 0 and, for even numbers of sites, the Nyquist wavenumber are on one side,
    NaN on the other. One-sided in f: bins are doubled but for 0 and, at even lengths, Nyquist.

    Raises
    ------
    ValueError
        For a store that is not finished.
    """
    import dask.array
    import xarray
    import zarr

    request = finished(Path(store))
    if request is None:
        _, done, _ = Journal.read(Path(store) / JOURNAL)
        raise ValueError(f"{os.fspath(store)}: expected a finished store, found {len(done)} steps of one")
    group = zarr.open_group(store, mode="r")
    attrs: Mapping[str, Any] = dict(group.attrs)
    dask_array: Any = dask.array
    sides = dask_array.from_zarr(os.fspath(store), component="spacetime_spectrum")
    nx = int(request["shape"][1])
    lower = sides[:, 0, 1 : nx // 2 + 1][:, ::-1]
    upper = sides[:, 1, : nx - nx // 2]
    data = dask_array.concatenate([lower, upper], axis=1)
    units = attrs["units"]
    k = np.asarray(group["wavenumber"])
    signed = np.concatenate([-k[1 : nx // 2 + 1][::-1], k[: nx - nx // 2]])
    frequency = np.asarray(group["frequency"])
    own = dict(group["spacetime_spectrum"].attrs)
    kept = {name: attrs[name] for name in ("scaling", "dt", "dx", "sign", "parseval")}
    coords = {
        "frequency": ("frequency", frequency, _unit(units.get("frequency"))),
        "wavenumber_signed": ("wavenumber_signed", signed, _unit(units.get("wavenumber"))),
    }
    dims = ("frequency", "wavenumber_signed")
    return xarray.DataArray(data, coords, dims, "spacetime_spectrum", {**own, **kept})


def _unit(unit: str | None) -> dict[str, str]:
    return {"units": unit} if unit else {}
