"""Keywords as the words of a command line, which the native half gives to the program's parser."""

from __future__ import annotations

import datetime
import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import numpy as np

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


#: Windows under the names that they have in SciPy.
_WINDOWS = {
    "blackmanharris": "blackman-harris",
    "blackman_harris": "blackman-harris",
    "boxcar": "none",
    "flattop": "flat-top",
    "hanning": "hann",
    "rectangular": "none",
}


def unit_text(unit: object) -> str | None:
    """A unit as text: of pint without spaces and factors, of DASCore a quantity of size one."""
    if unit is None:
        return None
    if hasattr(unit, "magnitude") and hasattr(unit, "units"):
        if unit.magnitude != 1:
            raise ValueError(f"units: expected a unit, found {unit}; scale the samples by it")
        unit = unit.units
    text = f"{unit:~}" if hasattr(unit, "dimensionality") else str(unit)
    text = re.sub(r"^1(\.0*)?\s+(?=[^\d\s/])", "", text.strip())
    text = re.sub(r"\s*\*\*\s*", "^", text)
    return re.sub(r"\s*([/*])\s*", r"\1", text).replace("*", " ") or None


def measured(value: Any) -> tuple[Any, str] | None:
    """A number and its unit, of quantities of pint and astropy and of durations."""
    if isinstance(value, np.timedelta64):
        return value / np.timedelta64(1, "s"), "s"
    if isinstance(value, datetime.timedelta):
        return value / datetime.timedelta(seconds=1), "s"
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        return value.magnitude, unit_text(value.units) or ""
    if hasattr(value, "value") and hasattr(value, "unit"):
        return value.value, unit_text(value.unit) or ""
    return None


def window_word(value: Any) -> str:
    """A window by its name, or by name and parameter as in SciPy: ``("kaiser", 8)``."""
    if isinstance(value, str):
        return _WINDOWS.get(value.lower(), value)
    if np.ndim(value) == 1 and all(isinstance(one, (int, float, np.number)) for one in value):
        return "samples:" + ",".join(map(one_word, np.asarray(value, float).tolist()))
    if not (isinstance(value, (tuple, list)) and len(value) == 2 and isinstance(value[0], str)):
        raise ValueError(
            f'window: expected a name, a name with its parameter, as ("kaiser", 8), or the samples of a '
            f"segment, found {type(value).__name__}"
        )
    return f"{window_word(value[0])}:{one_word(value[1])}"


def one_word(value: object) -> str:
    measure = measured(value)
    if measure is not None:
        number, unit = measure
        return f"{one_word(float(number))} {unit}".rstrip()
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
        elif "window" in name and name not in _RANGES and name != "front_window":
            said.append(f"{option}={window_word(value)}")
        elif isinstance(value, Mapping):
            for axis, part in value.items():
                is_range = isinstance(part, (slice, tuple, list))
                text = range_word(part) if is_range and name == "select" else _listed(part)
                said.append(f"{option}={axis}={text}")
        elif name in _RANGES and isinstance(value, (slice, tuple, list)):
            said.append(f"{option}={range_word(value)}")
        elif isinstance(value, str) or not isinstance(value, Iterable) or measured(value):
            said.append(f"{option}={one_word(value)}")
        elif name == "laws":
            said.append(f"{option}=[{', '.join(json.dumps(one_word(one)) for one in value)}]")
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
    if isinstance(value, str) or not isinstance(value, Iterable) or measured(value):
        return one_word(value)
    return ",".join(one_word(one) for one in value)


class _Bar:
    """Progress in a bar of tqdm, one for each stage."""

    def __init__(self) -> None:
        try:
            from tqdm.auto import tqdm
        except ModuleNotFoundError as error:
            raise ModuleNotFoundError(
                "progress=True draws bars of tqdm, which is not installed: `pip install tqdm`, or give "
                "a function of (stage, done, total)"
            ) from error

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
