"""Datasets whose arrays tasks compute."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from wavecascade._arrays.results import dataset


def lazy_array(parts: Sequence[tuple[int, Any]], name: str, like: Any) -> Any:
    """The array ``name`` of tasks, each with its length along the last axis; else as ``like``."""
    import dask.array

    dask_array: Any = dask.array
    blocks = [
        dask_array.from_delayed(result[name], (*like.shape[:-1], n), like.dtype) for n, result in parts
    ]
    return dask_array.concatenate(blocks, axis=-1)


def lazy_dataset(
    arrays: list[tuple[Any, ...]], attrs: Mapping[str, Any], result: Any, scalars: Iterable[str]
) -> Any:
    """These arrays, and beside them scalars of the result of a task."""
    import dask.array

    dask_array: Any = dask.array
    out = dataset({"attributes": {}, "arrays": arrays}, attrs)
    for name in scalars:
        single = dask_array.from_delayed(result[name], (), np.float64)
        out[name] = single if isinstance(out, dict) else ((), single)
    return out
