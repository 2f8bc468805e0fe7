"""Long work in a directory: which tasks are done, over workers that may be lost."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from wavecascade._keywords.words import Progress, observed

Task = tuple[str, Callable[..., Any], tuple[Any, ...]]

_UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "t": 10**12}
_UNITS |= {"ki": 2**10, "mi": 2**20, "gi": 2**30, "ti": 2**40}


def size_of(text: int | float | str) -> int:
    """A number of bytes, such as ``"450 MB"`` or ``"2GiB"``."""
    if not isinstance(text, str):
        return int(text)
    match = re.fullmatch(r"\s*([0-9.]+)\s*([kmgt]?i?)b?\s*", text.lower())
    if match is None or match[2] not in _UNITS:
        raise ValueError(f"memory: expected a size such as '450 MB' or '2 GiB', found {text!r}")
    return int(float(match[1]) * _UNITS[match[2]])


def shown(size: float) -> str:
    """A number of bytes in words."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.4g} TB"


class Journal:
    """Lines of JSON: what is done, then one line for each finished task."""

    def __init__(self, path: Path, request: Mapping[str, Any]) -> None:
        self.path = path
        self.request = dict(request)
        self.done: dict[str, Any] = {}
        self._file: Any = None

    @staticmethod
    def read(path: Path) -> tuple[dict[str, Any] | None, dict[str, Any], int]:
        """The request, the results of finished tasks, and the length of the whole lines."""
        if not path.exists():
            return None, {}, 0
        data = path.read_bytes()
        # A kill may leave half of a line.
        whole = data[: data.rfind(b"\n") + 1]
        lines = [json.loads(line) for line in whole.splitlines()]
        if not lines:
            return None, {}, 0
        return lines[0], dict(lines[1:]), len(whole)

    @contextmanager
    def opened(self) -> Iterator[Journal]:
        """Locked for this process, which a kill releases."""
        import fcntl

        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("ab") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise RuntimeError(
                    f"{self.path}: expected a store that nobody fills, found another process at work"
                ) from None
            request, self.done, length = self.read(self.path)
            file.truncate(length)
            self._file = file
            if request is None:
                self._line(self.request)
            elif request != self.request:
                raise ValueError(differing(self.path.parent, request, self.request))
            try:
                yield self
            finally:
                self._file = None

    def _line(self, value: Any) -> None:
        self._file.write(json.dumps(value).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def add(self, name: str, result: Any) -> None:
        """Keep a finished task."""
        self.done[name] = result
        self._line([name, result])


def differing(path: Path, held: Mapping[str, Any], asked: Mapping[str, Any]) -> str:
    """Why a store cannot be resumed."""
    keys = [key for key in {**held, **asked} if held.get(key) != asked.get(key)]
    key = keys[0] if keys else "format"
    return (
        f"{path}: expected the same work to resume, found {key} = {held.get(key)!r} there and "
        f"{asked.get(key)!r} here; name another store, or remove this one"
    )


def run_each(
    tasks: list[Task],
    taken: Callable[[str, Any], None],
    pool: Any = None,
    stage: str = "",
    progress: Progress = None,
) -> None:
    """Run tasks and take their results as they come.

    ``pool`` is a ``distributed.Client``, an executor of ``concurrent.futures``, or ``None`` for this
    process. A task of a lost worker runs again elsewhere. A task may be a Dask graph, named by its
    function ``None``.
    """
    told = observed(progress)

    def took(name: str, result: Any, done: int) -> None:
        taken(name, result)
        if told is not None:
            told(stage, done, len(tasks))

    if pool is None:
        for done, (name, function, arguments) in enumerate(tasks):
            took(name, called(function, arguments), done + 1)
    elif hasattr(pool, "scheduler_info"):
        _on_dask(tasks, took, pool)
    else:
        _on_executor(tasks, took, pool)


def called(function: Callable[..., Any] | None, arguments: tuple[Any, ...]) -> Any:
    """The result of a task in this process."""
    if function is None:
        return arguments[0].compute(scheduler="synchronous")
    return function(*arguments)


def _on_dask(tasks: list[Task], took: Callable[[str, Any, int], None], client: Any) -> None:
    import distributed

    def started(task: Task) -> Any:
        name, function, arguments = task
        if function is None:
            return name, client.compute(arguments[0], retries=3)
        return name, client.submit(function, *arguments, pure=False, retries=3)

    waiting = iter(tasks)
    names: dict[Any, str] = {}
    # So many that no thread waits for this process.
    ahead = 2 * max(1, sum(client.nthreads().values()))
    as_completed: Any = distributed.as_completed
    collected = as_completed([], with_results=True)

    def start_one() -> None:
        task = next(waiting, None)
        if task is not None:
            name, future = started(task)
            names[future.key] = name
            collected.add(future)

    try:
        for _ in range(ahead):
            start_one()
        done = 0
        for future, result in collected:
            done += 1
            took(names.pop(future.key), result, done)
            future.release()
            start_one()
    except BaseException:
        client.cancel(list(collected.futures))
        raise


def _on_executor(tasks: list[Task], took: Callable[[str, Any, int], None], pool: Any) -> None:
    from concurrent.futures import FIRST_COMPLETED, Future, wait

    waiting = iter(tasks)
    running: dict[Future[Any], str] = {}
    done = 0
    ahead = 2 * (getattr(pool, "_max_workers", None) or os.cpu_count() or 1)

    def start_one() -> None:
        task = next(waiting, None)
        if task is not None:
            running[pool.submit(called, *task[1:])] = task[0]

    try:
        for _ in range(ahead):
            start_one()
        while running:
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                done += 1
                took(running.pop(future), future.result(), done)
                start_one()
    except BaseException:
        for future in running:
            future.cancel()
        raise
