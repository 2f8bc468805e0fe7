"""Keywords as the words of a command line, which the native half gives to the program's parser."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

Progress = bool | Callable[[str, int, int], object] | None

#: Options that are given once for each of several values.
_REPEATED = frozenset({"at", "select", "dispersion", "fit", "vary", "defect"})
#: Options whose two values are the ends of a range.
_RANGES = frozenset(
    {
        "along",
        "band",
        "band_edge",
        "direction_band",
        "frequency",
        "lag_band",
        "select",
        "show_frequency",
        "show_space",
        "show_time",
        "show_wavenumber",
        "sites",
        "speed",
        "times",
        "wavenumber",
        "window_samples",
        "window_sites",
    }
)


class CascadeWarning(UserWarning):
    """A reason for doubt in a result, with what to do about it."""


def one_word(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if hasattr(value, "item") and getattr(value, "ndim", None) == 0:
        return one_word(value.item())
    if isinstance(value, float):
        return repr(value)
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def range_word(value: Any) -> str:
    """Two ends as one word."""
    if isinstance(value, slice):
        if value.step not in (None, 1):
            raise ValueError(f"expected a slice without a step, found {value!r}")
        ends = (value.start, value.stop)
    else:
        ends = tuple(value)
    if len(ends) != 2:
        raise ValueError(f"expected two ends, found {value!r}")
    return ":".join("" if end is None else one_word(end) for end in ends)


def words(
    command: str,
    options: Mapping[str, object],
    allowed: Collection[str],
    positional: Iterable[str] = (),
    keys: Collection[str] = (),
) -> list[str]:
    """The words of ``command`` with ``options``; ``keys`` are those of scenes."""
    said = [command]
    for name, value in options.items():
        if name not in allowed and name not in keys:
            raise TypeError(f"{command}() got an unexpected keyword argument {name!r}")
        if value is None:
            continue
        option = "--" + name.rstrip("_").replace("_", "-")
        if isinstance(value, bool) and name not in keys:
            said += [option] if value else []
        elif isinstance(value, Mapping):
            for axis, part in value.items():
                is_range = isinstance(part, (slice, tuple, list))
                text = range_word(part) if is_range and name == "select" else _listed(part)
                said.append(f"{option}={axis}={text}")
        elif name in _RANGES and isinstance(value, (slice, tuple, list)):
            said.append(f"{option}={range_word(value)}")
        elif isinstance(value, str) or not isinstance(value, Iterable):
            said.append(f"{option}={one_word(value)}")
        elif name in _REPEATED:
            said += [f"{option}={_table(one)}" for one in value]
        else:
            said.append(f"{option}={_listed(value)}")
    return said + list(positional)


def _table(value: Any) -> str:
    if isinstance(value, Mapping):
        return ",".join(f"{key}={one_word(one)}" for key, one in value.items())
    return one_word(value)


def _listed(value: Any) -> str:
    if isinstance(value, range) and value.step == 1 and len(value):
        return f"{value.start}..{value.stop - 1}"
    if isinstance(value, str) or not isinstance(value, Iterable):
        return one_word(value)
    return ",".join(one_word(one) for one in value)


class _Bar:
    """Progress in a bar of tqdm, one for each stage."""

    def __init__(self) -> None:
        from tqdm.auto import tqdm

        self._make = tqdm
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, total: int) -> None:
        if stage != self._stage:
            self.close()
            self._stage = stage
            self._bar = self._make(total=total, desc=stage, leave=False)
        self._bar.update(min(done, total) - self._bar.n)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


def observed(progress: Progress) -> Callable[[str, int, int], object] | None:
    """What is called with stage, done and total: the caller's function, or a bar for ``True``."""
    if progress is True:
        return _Bar()
    if progress is None or progress is False:
        return None
    told = progress

    def clamped(stage: str, done: int, total: int) -> object:
        # Passes that share a stage may do more than was foreseen.
        return told(stage, min(done, total), total)

    return clamped
