"""Workers of a pool: the memory that a task may take there, and warnings on their way to the client."""

from __future__ import annotations

import os
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from wavecascade._keywords.words import CascadeWarning
from wavecascade._large.store import shown, size_of

#: Share of a worker's memory that is used: Dask pauses workers from 0.8 on.
_SHARE = 0.75
#: What Python and the libraries take, where no worker can be asked.
_OVERHEAD = 220_000_000


@dataclass(frozen=True)
class WorkerMemory:
    """Memory of a worker: all of it, what Python takes, and tasks that share the rest."""

    limit: int
    overhead: int
    at_once: int

    @property
    def task(self) -> int:
        """What one task may take."""
        return max(0, int((_SHARE * self.limit - self.overhead) / self.at_once))

    def check(self, what: str, needed: int) -> None:
        """Refuses what does not fit."""
        if needed > self.task:
            more = (self.at_once * needed + self.overhead) / _SHARE
            raise ValueError(
                f"memory: expected at least {shown(more)} a worker, found {shown(self.limit)}: {what} "
                f"{shown(needed)} for each of {self.at_once} tasks at once, and Python takes "
                f"{shown(self.overhead)}; give workers more memory, or fewer threads"
            )

    @classmethod
    def of(cls, pool: Any, memory: int | str | None, at_once: int | None) -> WorkerMemory:
        """What a client's workers have, or what is stated."""
        limit = None if memory is None else size_of(memory)
        overhead, threads = _OVERHEAD, 1
        if hasattr(pool, "scheduler_info"):
            workers = pool.scheduler_info(n_workers=-1)["workers"].values()
            limits = [one["memory_limit"] for one in workers if one["memory_limit"]]
            if limits:
                limit = min([*limits, *([] if limit is None else [limit])])
            threads = max((one["nthreads"] for one in workers), default=1)
            try:
                overhead = max(pool.run(ready).values(), default=_OVERHEAD)
            except OSError:
                overhead = _OVERHEAD
        if limit is None:
            raise ValueError(
                "memory: expected what a worker may take, such as '2 GB', or workers with a limit"
            )
        return cls(limit, overhead, at_once or threads)

    @classmethod
    def here(cls) -> WorkerMemory | None:
        """That of the worker of Dask that runs this task, if it has a limit."""
        worker = _worker()
        limit = None if worker is None else worker.memory_manager.memory_limit
        if not limit:
            return None
        try:
            # Without what other tasks hold now.
            overhead = min(_resident(), _OVERHEAD)
        except OSError:
            overhead = _OVERHEAD
        return cls(limit, overhead, worker.state.nthreads)


@dataclass(frozen=True)
class Share:
    """What one task may take: bytes or a size, and threads; ``None`` leaves it to the library."""

    memory: str | None
    threads: int | None
    #: Whose memory is shared, and bytes of samples that the task holds beside it.
    worker: WorkerMemory | None
    samples: int

    @classmethod
    def of(cls, memory: str | None, threads: str | None, samples: int = 0) -> Share:
        """What is stated; else what a task has in a worker of Dask, beside so many bytes of samples."""
        # A thread of a worker is one core.
        cores = int(threads) if threads is not None else None if _worker() is None else 1
        worker = WorkerMemory.here() if memory is None else None
        if worker is None:
            return cls(memory, cores, None, samples)
        return cls(str(max(1, worker.task - samples)), cores, worker, samples)

    @contextmanager
    def explained(self) -> Iterator[None]:
        """Errors of memory in here say whose it is."""
        try:
            yield
        except MemoryError as error:
            if self.worker is None:
                raise
            beside = f"{shown(self.worker.overhead)} of Python"
            if self.samples > 0:
                beside += f" and {shown(self.samples)} of samples in each"
            raise MemoryError(
                f"{error}, in a worker of {shown(self.worker.limit)} that runs {self.worker.at_once} "
                f"tasks at once beside {beside}; give workers more memory or fewer threads, or take "
                "shorter segments or smaller chunks"
            ) from None


def _worker() -> Any:
    """The worker of Dask that runs this task."""
    distributed = sys.modules.get("distributed")
    if distributed is None:
        return None
    try:
        return distributed.get_worker()
    except ValueError:
        return None


def _resident() -> int:
    """Memory that this process takes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def ready() -> int:
    """Loads what tasks need, and says how much memory this process takes."""
    import zarr

    import wavecascade.fft

    wavecascade.fft.rfft(np.zeros((8, 8)), axis=0)
    del zarr
    return _resident()


#: Warnings that this process has issued, each of a computation.
_issued: set[tuple[str, str]] = set()
_issuing = threading.Lock()


def warn_once(message: str, computation: str) -> None:
    """Warns where the user sees it, however many tasks of a computation say the same.

    Dask hands what its own ``warn`` is given to the client, each time. So every process of workers warns
    once, and of what several of them say the filters of the client show one.
    """
    with _issuing:
        if (computation, message) in _issued:
            return
        worker = _worker()
        if worker is None or worker.address.startswith("inproc:"):
            warnings.warn(message, CascadeWarning, stacklevel=2)
        else:
            import distributed

            # The client shows it; it is not to appear in the output of the worker as well.
            warnings.filterwarnings(
                "ignore", category=CascadeWarning, module=__name__.replace(".", r"\.")
            )
            distributed.warn(message, CascadeWarning)
        _issued.add((computation, message))
