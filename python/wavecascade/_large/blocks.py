"""Where a plan reads from, and the blocks that fit the memory of a worker."""

from __future__ import annotations

import hashlib
import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from wavecascade._large.halves import CHUNK, FIRST, SECOND, Source, first_bytes, second_bytes
from wavecascade._large.store import shown
from wavecascade._large.workers import WorkerMemory

#: What is enough for a task, if its pieces are not below the second.
_ENOUGH, _GOOD_PIECE = 192_000_000, 1 << 20
#: Below, a store has more files than any file system likes.
_LEAST_PIECE = 4096


def source_of(field: Any) -> tuple[Any, Any]:
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
            return Source(path, arrays[0], False), _labelled(path, arrays[0], opened[arrays[0]])
        return Source(path, None, False), opened
    if hasattr(field, "store_path") and hasattr(field, "chunks"):
        root = getattr(field.store_path.store, "root", None)
        if root is None:
            raise ValueError("field: expected a store of Zarr on a file system, found another")
        return Source(os.path.abspath(Path(root, field.store_path.path)), None, False), field
    return None, field


def _labelled(path: str, name: str, array: Any) -> Any:
    """The array with the coordinates that stand beside it, where its dimensions have names."""
    scaled = [key for key in ("scale_factor", "add_offset") if key in array.attrs]
    if scaled:
        raise ValueError(
            f"{path}: expected samples as they are, found {name} with {scaled[0]}; open it with xarray, "
            "and give the DataArray"
        )
    dims = getattr(array.metadata, "dimension_names", None) or array.attrs.get("_ARRAY_DIMENSIONS")
    if not dims or None in dims:
        return array
    import xarray

    return xarray.open_zarr(path, consolidated=False)[name]


def blocks(source: Any, shape: tuple[int, int], worker: WorkerMemory) -> tuple[tuple[int, ...], int]:
    """Bounds of the blocks of times, and wavenumbers of a block.

    They are as small as gives pieces that are read at a good speed: larger ones take memory alone.

    Raises
    ------
    ValueError
        Where one wavenumber, one time, or one chunk is too much.
    """
    nt, nx = shape
    worker.check(f"the records of one wavenumber at {nt} times need", second_bytes(nt, 1))
    worker.check(f"the {nx} sites at one time need", first_bytes(1, nx))
    decoded, chunk = 0, 1
    if hasattr(source, "dask"):
        longest = max(source.chunks[0])
        worker.check(
            f"a chunk of {longest} times x all {nx} sites (open the field with shorter chunks, or name "
            "the path of its store of Zarr) needs",
            first_bytes(longest, nx),
        )
        least = first_bytes(longest, nx)
    else:
        if isinstance(source, Source):
            array = source.opened()
            chunk = array.chunks[1 if source.is_turned else 0]
            decoded = int(np.prod(array.chunks)) * array.dtype.itemsize
        least = decoded + first_bytes(1, nx)
        worker.check("a chunk of the field, and its samples at one time, need", least)
    least = max(least, second_bytes(nt, 1))
    task = min(worker.task, max(least, _ENOUGH))
    while True:
        width = _width(shape, task)
        rows = (task - first_bytes(0, nx) - decoded) // (FIRST * nx)
        if hasattr(source, "dask"):
            bounds = _joined(source.chunks[0], rows)
        else:
            rows = min(rows - rows % chunk if rows >= chunk else rows, nt)
            bounds = (*range(0, nt, rows), nt)
        piece = 16 * longest_of(bounds) * width
        is_whole = len(bounds) == 2 or width == nx // 2 + 1
        if is_whole or piece >= _GOOD_PIECE or task == worker.task:
            break
        task = min(worker.task, 2 * task)
    if not is_whole and piece < _LEAST_PIECE:
        raise ValueError(
            f"memory: expected more than {shown(worker.limit)} a worker: "
            f"{shown(16 * nt * (nx // 2 + 1))} between both halves would be in pieces of {piece} bytes, "
            "each a file"
        )
    return bounds, width


def _width(shape: tuple[int, int], task: int) -> int:
    """The wavenumbers of a block that a task may take, all blocks alike but for the last."""
    nt, bins = shape[0], shape[1] // 2 + 1
    width = int(max(1, min(bins, (task - second_bytes(nt, 0)) // (SECOND * nt))))
    while width > 1 and second_bytes(nt, width) > task:
        width -= 1
    return -(-bins // -(-bins // width))


def _joined(chunks: tuple[int, ...], rows: int) -> tuple[int, ...]:
    """Bounds of blocks of whole chunks."""
    ends = [0]
    for n in chunks:
        if len(ends) > 1 and ends[-1] + n - ends[-2] <= rows:
            ends[-1] += n
        else:
            ends.append(ends[-1] + n)
    return tuple(ends)


def longest_of(bounds: tuple[int, ...]) -> int:
    """Times of the longest block."""
    return max(b - a for a, b in pairwise(bounds))


def identity_of(samples: Any) -> str:
    if isinstance(samples, Source):
        return f"{samples.path}/{samples.array or ''}, {samples.fingerprint()}"
    if hasattr(samples, "dask"):
        return f"dask {samples.name}"
    if isinstance(samples, np.memmap) and samples.filename is not None:
        return f"{samples.filename}, {os.stat(samples.filename).st_mtime_ns}"
    held = np.asarray(samples)
    digest = hashlib.blake2b(digest_size=16)
    step = max(1, CHUNK // max(1, held[:1].nbytes))
    for at in range(0, len(held), step):
        digest.update(np.ascontiguousarray(held[at : at + step]).tobytes())
    return f"{held.dtype} {digest.hexdigest()}"


def bytes_read(samples: Any, bounds: tuple[int, ...]) -> int:
    if not isinstance(samples, Source):
        return int(samples.nbytes)
    # Every chunk that a block touches is read whole.
    array = samples.opened()
    n = 1 if samples.is_turned else 0
    chunk, row = array.chunks[n], array.nbytes // array.shape[n]
    touched = sum((b - 1) // chunk - a // chunk + 1 for a, b in pairwise(bounds))
    return int(min(touched * chunk, len(bounds) * array.shape[n]) * row)
