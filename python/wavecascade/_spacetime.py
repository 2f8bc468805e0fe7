"""S(k, f) of a whole record that no worker can hold: planned, then run over a store of Zarr."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np
import numpy.typing as npt

from wavecascade._axes import Axes, placed
from wavecascade._native import version
from wavecascade._options import FieldOptions
from wavecascade._store import Journal, Task, run_each, shown, size_of
from wavecascade._windows import columns, pairwise_sum, sum_of, window
from wavecascade._words import Progress

Array = npt.NDArray[Any]
Scaling = Literal["energy", "density", "spectrum"]

#: Share of a worker's memory that is used: Dask pauses workers from 0.8 on.
_SHARE = 0.75
#: What Python and the libraries take, where no worker can be asked.
_OVERHEAD = 220_000_000
#: Bytes a sample in the first half (samples, their copy, transforms, what is written), and of each column in
#: the second (transforms, spectra), with what each column that is being transformed takes beside it.
_FIRST, _SECOND, _WIDTH_COST = 28, 26, 48
#: Columns that are transformed at once.
_WIDTH = 4
#: Below, a store has more files than any file system likes.
_LEAST_PIECE = 4096
_CHUNK = 4 << 20


@dataclass(frozen=True)
class Source:
    """Where samples are read: an array of a store of Zarr, by its path."""

    path: str
    array: str | None
    is_turned: bool

    def opened(self) -> Any:
        """The array."""
        import zarr

        return zarr.open_array(self.path, path=self.array, mode="r")

    def read(self, start: int, stop: int) -> Array:
        """Some times of all sites, one chunk of the store after another."""
        array = self.opened()
        if self.is_turned:
            step, n = array.chunks[0], array.shape[0]
            parts = (array[at : at + step, start:stop].T for at in range(0, n, step))
        else:
            step, n = array.chunks[1], array.shape[1]
            parts = (array[start:stop, at : at + step] for at in range(0, n, step))
        rows = np.empty((stop - start, n), array.dtype)
        for i, part in enumerate(parts):
            rows[:, i * step : (i + 1) * step] = part
        return rows

    def fingerprint(self) -> str:
        """Number, bytes and latest change of its files, so that a field that changed is not resumed."""
        root = Path(self.path, self.array or "")
        files = [file.stat() for file in root.rglob("*") if file.is_file()]
        latest = max((file.st_mtime_ns for file in files), default=0)
        return f"{len(files)} files, {sum(file.st_size for file in files)} bytes, {latest}"


@dataclass(frozen=True)
class Job:
    """What every task has to know."""

    store: str
    shape: tuple[int, int]
    bounds: tuple[int, ...]
    wavenumbers: int
    chunk: int
    window_time: Any
    window_space: Any
    factor: float

    def opened(self, name: str, mode: Literal["r", "r+"]) -> Any:
        """An array of the store."""
        import zarr

        return zarr.open_array(self.store, path=name, mode=mode)


def exact(values: Array) -> str:
    """A sum without rounding, so that it does not depend on who adds what."""
    return str(sum((Fraction(float(v)) for v in values), Fraction(0)))


def along_space(job: Job, i: int, source: Any) -> str:
    """The first half: some times along space, to the store; sum of their squares."""
    start, stop = job.bounds[i], job.bounds[i + 1]
    if isinstance(source, Source):
        rows = source.read(start, stop)
    elif isinstance(source, list):
        rows = np.concatenate([np.concatenate(parts, axis=1) for parts in source])
    else:
        rows = np.asarray(source)
    nx = job.shape[1]
    if rows.dtype.kind == "c" or rows.shape != (stop - start, nx):
        raise ValueError(f"field: expected {stop - start} x {nx} real samples, found {rows.dtype} {rows.shape}")
    across = window(job.window_space, nx)
    taper = None if (across == 1.0).all() else across
    weights = None if job.window_time == "none" else window(job.window_time, job.shape[0])[start:stop]
    found = np.empty((stop - start, nx // 2 + 1), np.complex128)
    energies = np.empty(stop - start)
    from wavecascade import fft

    step = max(1, _CHUNK // (8 * nx))
    for at in range(0, stop - start, step):
        x = np.asarray(rows[at : at + step], np.float64)
        if taper is not None:
            x = x * taper
        if weights is not None:
            x = x * weights[at : at + step, None]
        energies[at : at + step] = pairwise_sum(x * x)
        found[at : at + step] = fft.r2c(x, 1)
    if not np.isfinite(energies).all():
        n = int(np.flatnonzero(~np.isfinite(energies))[0])
        raise ValueError(
            f"field: expected finite samples of moderate size, found others at time {start + n}; fill gaps first"
        )
    del rows
    job.opened("intermediate", "r+")[i, : stop - start, :] = found
    return exact(energies)


def along_time(job: Job, j: int) -> str:
    """The second half: some wavenumbers along time, squared, to the store; their sum."""
    nt, nx = job.shape
    k0, k1 = j * job.wavenumbers, min((j + 1) * job.wavenumbers, nx // 2 + 1)
    between = job.opened("intermediate", "r")
    records = np.empty((nt, k1 - k0), np.complex128)
    for i, (start, stop) in enumerate(zip(job.bounds, job.bounds[1:], strict=False)):
        records[start:stop] = between[i, : stop - start, k0:k1]
    nf = nt // 2 + 1
    spectrum = np.empty((nf, 2, k1 - k0))
    scale = np.where(np.arange(nf) * 2 % nt == 0, job.factor, 2.0 * job.factor)[:, None]
    for at in range(0, k1 - k0, _WIDTH):
        found = columns(records[:, at : at + _WIDTH], 0, real=False)
        power = np.square(found.real)
        power += np.square(found.imag)
        del found
        # Of exp(-i k x): towards -x as it is, towards +x at the opposite frequency.
        spectrum[:, 0, at : at + _WIDTH] = power[:nf] * scale
        spectrum[0, 1, at : at + _WIDTH] = power[0] * scale[0]
        spectrum[1:, 1, at : at + _WIDTH] = power[: nt - nf : -1] * scale[1:]
    del records
    if not np.isfinite(spectrum).all():
        raise ValueError("field: expected samples whose squares are finite, found a spectrum that is not")
    # k = 0 and the Nyquist wavenumber are there once.
    if k0 == 0:
        spectrum[:, 0, 0] = np.nan
    if nx % 2 == 0 and k1 == nx // 2 + 1:
        spectrum[:, 1, -1] = np.nan
    job.opened("spacetime_spectrum", "r+")[:, :, k0:k1] = spectrum
    sums = pairwise_sum(np.nan_to_num(spectrum, copy=False).reshape(1, nf, -1))
    return exact(sums[0])


@dataclass
class SpacetimePlan:
    """What :func:`plan_spacetime` found; ``print`` shows it, :meth:`run` does it."""

    job: Job
    axes: Axes
    source: Any
    scaling: str
    memory: int
    overhead: int
    at_once: int
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
        rows = max(b - a for a, b in zip(self.job.bounds, self.job.bounds[1:], strict=False))
        nt, nx = self.job.shape
        task = max(first_bytes(rows, nx), second_bytes(nt, self.job.wavenumbers))
        return self.overhead + self.at_once * task

    def __str__(self) -> str:
        nt, nx = self.job.shape
        first, second = self.blocks
        rows = max(b - a for a, b in zip(self.job.bounds, self.job.bounds[1:], strict=False))
        piece = 16 * rows * self.job.wavenumbers
        field = f"S(k, f) of {nt} times x {nx} sites: {shown(8 * nt * nx)} in double precision"
        lines = [
            field,
            f"  1. along x    {first} tasks of {rows} times         read {shown(self.bytes_read)}, "
            f"write {shown(self.bytes_between)} in {self.files} pieces of {shown(piece)}",
            f"  2. along t    {second} tasks of {self.job.wavenumbers} wavenumbers   "
            f"read {shown(self.bytes_between)}, write {shown(self.bytes_written)}",
            f"  moved         {shown(self.bytes_read + 2 * self.bytes_between + self.bytes_written)}",
            f"  memory        {shown(self.peak_bytes)} a worker at most, {shown(self.overhead)} of it Python's, "
            f"of {shown(self.memory)}",
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
        others = path.exists() and any(path.iterdir()) and not (path / "journal").exists()
        if others or (path.exists() and not path.is_dir()):
            raise ValueError(f"{path}: expected a new or an unfinished store, found something else")
        with Journal(path / "journal", self.identity).opened() as journal:
            if "finished" not in journal.done:
                if "created" not in journal.done:
                    self._create(path)
                    journal.add("created", version)
                self._half(journal, "x", self.blocks[0], "along x", pool, progress)
                self._half(journal, "t", self.blocks[1], "along t", pool, progress)
                self._finish(path, journal)
            shutil.rmtree(path / "intermediate", ignore_errors=True)
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
        import dask

        delayed: Any = dask.delayed
        ends = np.cumsum((0, *self.source.chunks[0]))
        rows = [n for n in range(len(ends) - 1) if start <= ends[n] < stop]
        parts = [[self.source.blocks[n, m].to_delayed().item() for m in range(self.source.numblocks[1])]
                 for n in rows]
        return None, (delayed(along_space)(self.job, i, parts),)

    def _second(self, j: int) -> tuple[Any, tuple[Any, ...]]:
        return along_time, (self.job, j)

    def _create(self, path: Path) -> None:
        import zarr

        for name in ("intermediate", "spacetime_spectrum", "frequency", "side", "wavenumber"):
            shutil.rmtree(path / name, ignore_errors=True)
        nt, nx = self.job.shape
        bins, width = nx // 2 + 1, self.job.wavenumbers
        rows = max(b - a for a, b in zip(self.job.bounds, self.job.bounds[1:], strict=False))
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
                f"{path}: expected the energy of the samples in the spectrum, found it {residual:.1e} apart; "
                "was the field written to meanwhile?"
            )
        zarr.open_group(path, mode="r+").attrs["parseval"] = residual
        journal.add("finished", residual)


def first_bytes(rows: int, nx: int) -> int:
    """Memory of a task of the first half."""
    return _FIRST * rows * nx + 8 * _CHUNK


def second_bytes(nt: int, width: int) -> int:
    """Memory of a task of the second half."""
    return nt * (_SECOND * width + _WIDTH_COST * min(max(width, 2), _WIDTH)) + 2 * _CHUNK


def _ready() -> int:
    """Loads what tasks need, and says how much memory this process takes."""
    import zarr

    import wavecascade.fft

    wavecascade.fft.r2c(np.zeros((8, 8)))
    del zarr
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _workers(pool: Any, memory: int | str | None, at_once: int | None) -> tuple[int, int, int]:
    """Memory of a worker, what it takes already, and its tasks at once."""
    limit = None if memory is None else size_of(memory)
    overhead, threads = _OVERHEAD, 1
    if hasattr(pool, "scheduler_info"):
        workers = pool.scheduler_info(n_workers=-1)["workers"].values()
        limits = [one["memory_limit"] for one in workers if one["memory_limit"]]
        if limits:
            limit = min([*limits, *([] if limit is None else [limit])])
        threads = max((one["nthreads"] for one in workers), default=1)
        try:
            overhead = max(pool.run(_ready).values(), default=_OVERHEAD)
        except OSError:
            overhead = _OVERHEAD
    if limit is None:
        raise ValueError("memory: expected what a worker may take, such as '2 GB', or workers with a limit")
    return limit, overhead, at_once or threads


def _source(field: Any) -> tuple[Any, Any]:
    """A path or an array of Zarr as a source with its array; others as they are."""
    if isinstance(field, (str, os.PathLike)):
        path = os.path.abspath(field)
        import zarr

        opened: Any = zarr.open(path, mode="r")
        if not hasattr(opened, "chunks"):
            arrays = [name for name, array in opened.arrays() if array.ndim == 2]
            if len(arrays) != 1:
                raise ValueError(
                    f"{path}: expected one array of two dimensions, found {', '.join(arrays) or 'none'}; "
                    "name the array's own path"
                )
            return Source(path, arrays[0], False), opened[arrays[0]]
        return Source(path, None, False), opened
    if hasattr(field, "store_path") and hasattr(field, "chunks"):
        root = getattr(field.store_path.store, "root", None)
        if root is None:
            raise ValueError("field: expected a store of Zarr on a file system, found another")
        return Source(os.path.abspath(Path(root, field.store_path.path)), None, False), field
    return None, field


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
    **options: Unpack[FieldOptions],
) -> SpacetimePlan:
    """Plan S(k, f) of a whole record that is larger than the memory of a worker.

    S(k, f) = 2 / (L T) |sum v(t, x) exp(i (k x - 2 pi f t)) dt dx|^2 / (2 pi), here as a density, as
    :func:`analyze` has it, to rounding. Blocks of times are transformed along x and written to ``store``,
    in pieces of few wavenumbers; then each block of wavenumbers is read and transformed along t. Nothing is
    rechunked, no worker sends samples to another, and the bits depend on neither blocks nor workers.

    Parameters
    ----------
    field
        Samples (time, site): the path of a store of Zarr, which workers read by themselves, a Dask array or
        a DataArray over one, or an array of NumPy. ``layout="site-time"`` turns an array round.
    store
        Directory of the result, which all workers reach. Finished blocks are kept there: a plan of the same
        field and store goes on where the last one ended.
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
    source, array = _source(field)
    given: dict[str, object] = dict(options)
    if source is not None and given.pop("layout", None) == "site-time":
        source = Source(source.path, source.array, True)
        array = np.broadcast_to(np.float64(0), array.shape[::-1])
    found = placed(array, given)
    nt, nx = map(int, found.samples.shape)
    if nt < 2 or nx < 2:
        raise ValueError(f"field: expected at least 2 times and 2 sites, found {nt} and {nx}")
    samples: Any = found.samples if source is None else source
    limit, overhead, threads = _workers(pool, memory, at_once)
    allowed = int((_SHARE * limit - overhead) / threads)

    held, _, _ = Journal.read(Path(store) / "journal")
    wanted = _blocks(samples, (nt, nx), allowed, limit)
    bounds, width = wanted
    if held is not None and "bounds" in held:
        # Blocks that were begun are kept, if they fit.
        bounds, width = tuple(held["bounds"]), held["wavenumbers"]
    rows = max(b - a for a, b in zip(bounds, bounds[1:], strict=False))
    needed = max(first_bytes(rows, nx), second_bytes(nt, width))
    if needed > max(allowed, 0):
        _refuse("the blocks that the store was begun with need", needed, threads, overhead, limit)

    weights = window(window_time, nt), window(window_space, nx)
    factor, total = _scale(scaling, weights, (nt, nx), found.axes)
    chunk = max(1, _CHUNK // (16 * width))
    listed = tuple(w if isinstance(w, str) else tuple(map(float, w)) for w in (window_time, window_space))
    job = Job(os.path.abspath(store), (nt, nx), bounds, width, chunk, *listed, factor)
    identity = {
        "schema": "wavecascade.spacetime/1",
        "version": version,
        "field": _identity(samples),
        "shape": [nt, nx],
        "axes": json.loads(json.dumps({k: v for k, v in asdict(found.axes).items() if k != "spectra"})),
        "scaling": scaling,
        "windows": [w if isinstance(w, str) else list(w) for w in listed],
        "bounds": list(bounds),
        "wavenumbers": width,
    }
    plan = SpacetimePlan(
        job, found.axes, samples, scaling, limit, overhead, threads, total, identity, _bytes_read(samples, bounds)
    )
    if show:
        print(plan)
    return plan


def _refuse(what: str, needed: int, threads: int, overhead: int, limit: int) -> None:
    more = (threads * needed + overhead) / _SHARE
    raise ValueError(
        f"memory: expected at least {shown(more)} a worker, found {shown(limit)}: {what} {shown(needed)} for each of "
        f"{threads} at once beside the {shown(overhead)} of Python; give more memory or fewer threads a worker"
    )


def _blocks(
    samples: Any, shape: tuple[int, int], allowed: int, limit: int
) -> tuple[tuple[int, ...], int]:
    """Bounds of the blocks of times, and wavenumbers of a block."""
    nt, nx = shape
    bins = nx // 2 + 1

    def refuse(what: str, needed: int) -> None:
        overhead = int(_SHARE * limit) - allowed
        more = (needed + overhead) / _SHARE
        raise ValueError(
            f"memory: expected at least {shown(more)} a worker, found {shown(limit)}: {what} {shown(needed)}, "
            f"and {shown(max(allowed, 0))} are left of {shown(_SHARE * limit)} beside Python"
        )

    if second_bytes(nt, 1) > allowed:
        refuse(f"the records of one wavenumber at {nt} times need", second_bytes(nt, 1))
    width = next(w for w in range(bins, 0, -1) if second_bytes(nt, w) <= allowed) if bins <= 64 else max(
        1, min(bins, (allowed - second_bytes(nt, 0) - nt * _WIDTH_COST * (_WIDTH - 2)) // (_SECOND * nt))
    )
    while width > 1 and second_bytes(nt, width) > allowed:
        width -= 1
    # Blocks of one size, as far as they go.
    width = -(-bins // -(-bins // width))
    rows = (allowed - first_bytes(0, nx)) // (_FIRST * nx)
    if rows < 1:
        refuse(f"the {nx} sites at one time need", first_bytes(1, nx))
    if hasattr(samples, "dask"):
        ends = [0]
        for n in samples.chunks[0]:
            if n > rows:
                raise ValueError(
                    f"field: expected chunks of at most {rows} times x all {nx} sites in {shown(allowed)}, found one "
                    f"of {n} times ({shown(first_bytes(n, nx))}); open the field with shorter chunks, name the "
                    "path of its store of Zarr, or give workers more memory"
                )
            if len(ends) > 1 and ends[-1] + n - ends[-2] <= rows:
                ends[-1] += n
            else:
                ends.append(ends[-1] + n)
        bounds = tuple(ends)
    else:
        if isinstance(samples, Source):
            array = samples.opened()
            chunk = array.chunks[1 if samples.is_turned else 0]
            decoded = int(np.prod(array.chunks)) * array.dtype.itemsize
            rows = (allowed - first_bytes(0, nx) - decoded) // (_FIRST * nx)
            if rows < 1:
                refuse("a chunk of the field with its samples at one time needs", decoded + first_bytes(1, nx))
            if rows >= chunk:
                rows -= rows % chunk
        rows = min(rows, nt)
        bounds = (*range(0, nt, rows), nt)
    piece = 16 * max(b - a for a, b in zip(bounds, bounds[1:], strict=False)) * width
    if len(bounds) > 2 and width < bins and piece < _LEAST_PIECE:
        raise ValueError(
            f"memory: expected more than {shown(limit)} a worker: the {shown(16 * nt * bins)} between both halves would "
            f"be in pieces of {piece} bytes, each a file"
        )
    return bounds, int(width)


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


def _identity(samples: Any) -> str:
    if isinstance(samples, Source):
        return f"{samples.path}/{samples.array or ''}, {samples.fingerprint()}"
    if hasattr(samples, "dask"):
        return f"dask {samples.name}"
    if isinstance(samples, np.memmap) and samples.filename is not None:
        return f"{samples.filename}, {os.stat(samples.filename).st_mtime_ns}"
    held = np.asarray(samples)
    digest = hashlib.blake2b(digest_size=16)
    step = max(1, _CHUNK // max(1, held[:1].nbytes))
    for at in range(0, len(held), step):
        digest.update(np.ascontiguousarray(held[at : at + step]))
    return f"{held.dtype} {digest.hexdigest()}"


def _bytes_read(samples: Any, bounds: tuple[int, ...]) -> int:
    if not isinstance(samples, Source):
        return int(samples.nbytes)
    # Every chunk that a block touches is read whole.
    array = samples.opened()
    n = 1 if samples.is_turned else 0
    chunk, row = array.chunks[n], array.nbytes // array.shape[n]
    touched = sum((b - 1) // chunk - a // chunk + 1 for a, b in zip(bounds, bounds[1:], strict=False))
    return int(min(touched * chunk, touched * chunk) * row)


def open_spacetime(store: str | os.PathLike[str]) -> Any:
    """S(k, f) of a finished store as a lazy ``xarray.DataArray`` (frequency, wavenumber_signed).

    In the store, ``spacetime_spectrum`` is (frequency, side, wavenumber): side -1 has the wavenumbers below
    0, +1 the others; k = 0 and, for even numbers of sites, the Nyquist wavenumber are on one side, NaN on the
    other. One-sided in f: bins are doubled but for 0 and, at even lengths, Nyquist.

    Raises
    ------
    ValueError
        For a store that is not finished.
    """
    import dask.array
    import xarray
    import zarr

    request, done, _ = Journal.read(Path(store) / "journal")
    if request is None or "finished" not in done:
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
    k: Any = group["wavenumber"][:]
    signed = np.concatenate([-k[1 : nx // 2 + 1][::-1], k[: nx - nx // 2]])
    frequency: Any = group["frequency"][:]
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
