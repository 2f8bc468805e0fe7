import os
from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "Page",
    "Partial",
    "Run",
    "Samples",
    "combine",
    "filter",
    "found",
    "inspected",
    "is_run_file",
    "join",
    "open",
    "outline",
    "partial",
    "planned",
    "program",
    "report",
    "rfft",
    "scene_keys",
    "simulate",
    "sweep",
    "version",
]

version: str

_Array = npt.NDArray[Any]
_Coordinates = tuple[list[float], float, str | None, float | None]
_Progress = Callable[[str, int, int], object] | None

@final
class Samples:
    def __new__(
        cls,
        array: _Array,
        *,
        name: str,
        quantity: str | None = None,
        unit: str | None = None,
        time: _Coordinates | None = None,
        space: _Coordinates | None = None,
        axis_names: tuple[str | None, str | None] = ...,
        start: str | None = None,
        is_layout_known: bool = False,
        struck: int | None = None,
        scene: tuple[str, float] | None = None,
    ) -> Samples: ...

_Source = Samples | Sequence[str | os.PathLike[str]]

@final
class Page:
    def __deepcopy__(self, _memo: object) -> Page: ...
    def __reduce__(self) -> tuple[type[None], tuple[()]]: ...

@final
class Run:
    def __new__(cls, arrays: dict[str, npt.NDArray[np.float64]], texts: dict[str, str]) -> Run: ...
    @property
    def scene(self) -> str: ...

@final
class Partial:
    def __new__(cls, about: str, sums: npt.NDArray[np.float64]) -> Partial: ...
    @property
    def nbytes(self) -> int: ...
    @property
    def segments(self) -> tuple[int, int]: ...
    @property
    def estimate(self) -> str: ...
    def save(self, path: str | os.PathLike[str]) -> None: ...
    @staticmethod
    def load(path: str | os.PathLike[str]) -> Partial: ...
    def __reduce__(self) -> tuple[type[Partial], tuple[str, npt.NDArray[np.float64]]]: ...
    def __sizeof__(self) -> int: ...

def planned(source: _Source, words: list[str]) -> str: ...
def inspected(words: list[str]) -> str: ...
def report(page: Page) -> str: ...
def open(source: _Source, words: list[str]) -> dict[str, Any]: ...
def filter(source: _Source, words: list[str], progress: _Progress = None) -> dict[str, Any]: ...
def found(
    words: list[str],
    progress: _Progress = None,
    sources: Sequence[_Source] = ...,
    scene: str | None = None,
    runs: Sequence[Run | None] = ...,
    maps: bool = True,
) -> dict[str, Any]: ...
def partial(
    sources: Sequence[_Source],
    words: list[str],
    place: tuple[int, int] | None = None,
    progress: _Progress = None,
) -> Partial: ...
def combine(
    partials: Sequence[Partial], memory: str | None = None, threads: int | None = None
) -> dict[str, Any]: ...
def join(partials: Sequence[Partial], memory: str | None = None) -> Partial: ...
def outline(
    source: _Source, words: list[str], times: int
) -> tuple[dict[str, Any], tuple[int, int, int]]: ...
def simulate(text: str | None, words: list[str], progress: _Progress = None) -> dict[str, Any]: ...
def is_run_file(path: str) -> bool: ...
def sweep(
    text: str | None, words: list[str], progress: _Progress = None
) -> tuple[str, str, str, Page]: ...
def rfft(a: _Array, workers: int) -> npt.NDArray[np.complexfloating]: ...
def program(words: Sequence[str | os.PathLike[str]]) -> int: ...
def scene_keys() -> list[str]: ...
