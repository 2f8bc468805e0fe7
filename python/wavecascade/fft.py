"""The Fourier transform of real samples along one axis of an array."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import numpy.typing as npt

from wavecascade import _native

__all__ = ["rfft"]


def rfft(a: npt.ArrayLike, *, axis: int, workers: int = 1) -> npt.NDArray[np.complexfloating]:
    """X_m = sum_n a_n exp(-2 pi i m n / N), m = 0 .. N / 2, along ``axis``.

    Columns (along any axis but the last of an array in C order) are transformed many at once.

    Parameters
    ----------
    a
        Real numbers of any strides.
    axis
        Axis of the transform.
    workers
        Threads; -1 stands for all. The bits do not depend on it.

    Returns
    -------
    numpy.ndarray
        N / 2 + 1 complex numbers along ``axis``, of 32 bits each for input of 32 bits.

    Raises
    ------
    ValueError, TypeError
        For an axis or a type that does not fit, or an axis without samples.
    """
    samples = _real(np.asarray(a))
    if not -samples.ndim <= axis < samples.ndim:
        raise ValueError(f"axis: expected one of {samples.ndim}, found {axis}")
    axis %= samples.ndim
    length = samples.shape[axis]
    if not length:
        raise ValueError(f"a: expected samples along axis {axis}, found none")
    if not samples.size:
        shape = (*samples.shape[:axis], length // 2 + 1, *samples.shape[axis + 1 :])
        return np.empty(shape, np.result_type(samples, np.complex64))
    cores = os.cpu_count() or 1
    threads = workers + 1 + cores if workers < 0 else workers
    if threads <= 0:
        raise ValueError(f"workers: expected a number but 0, from -{cores} on, found {workers}")
    if samples.flags.f_contiguous and not samples.flags.c_contiguous:
        # Transposed it is in C order.
        return rfft(samples.T, axis=samples.ndim - 1 - axis, workers=workers).T
    shape = samples.shape
    # Of a copy where strides are others.
    flat = np.ascontiguousarray(samples).reshape(int(np.prod(shape[:axis])), length, -1)
    return _native.rfft(flat, threads).reshape(*shape[:axis], -1, *shape[axis + 1 :])


def _real(a: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Aligned numbers in the order of this machine, of 32 bits where they have no more."""
    if a.dtype.kind not in "fiub":
        raise TypeError(f"a: expected real numbers, found {a.dtype}")
    is_short = a.dtype.kind == "f" and a.dtype.itemsize <= 4
    return np.require(a, np.float32 if is_short else np.float64, "A")
