"""Fourier transforms along one axis of an array: a drop-in for those of ``scipy.fft``.

Columns (any axis but the last of a C-ordered array) are transformed many at once, without a transpose.
Numbers of 32 bits stay so. ``scipy.fft.set_backend(wavecascade.fft.backend)`` has SciPy's functions call
these; what is not here, SciPy does itself.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from wavecascade import _native

__all__ = ["backend", "c2c", "c2r", "fft", "ifft", "irfft", "r2c", "rfft"]

Norm = Literal["backward", "ortho", "forward"] | None
Array = npt.NDArray[Any]

#: By what results are multiplied, forward and back: 0 nothing, 1 by 1 / n, 2 by 1 / sqrt(n).
_FORWARD = {None: 0, "backward": 0, "ortho": 2, "forward": 1}
_INVERSE = {None: 1, "backward": 1, "ortho": 2, "forward": 0}

_REAL = {np.dtype(np.float64), np.dtype(np.float32)}
_COMPLEX = {np.dtype(np.complex128), np.dtype(np.complex64)}


def _norm(norm: Norm, norms: dict[Any, int]) -> int:
    try:
        return norms[norm]
    except (KeyError, TypeError):
        raise ValueError(f"norm: expected 'backward', 'ortho' or 'forward', found {norm!r}") from None


def _workers(workers: int | None) -> int:
    if workers is None:
        return 1
    cores = os.cpu_count() or 1
    count = workers + 1 + cores if workers < 0 else workers
    if count <= 0:
        raise ValueError(f"workers: expected a number but 0, from -{cores} on, found {workers}")
    return count


def _axis(a: Array, axis: int) -> int:
    if not -a.ndim <= axis < a.ndim:
        raise ValueError(f"axis: expected one of {a.ndim}, found {axis}")
    return axis % a.ndim


def _fitted(a: Array, n: int, axis: int) -> Array:
    """The first ``n`` samples along ``axis``, zeros behind them."""
    have = a.shape[axis]
    if have == n:
        return a
    if n < 1:
        raise ValueError(f"n: expected at least 1, found {n}")
    if have > n:
        return a[(slice(None),) * axis + (slice(n),)]
    shape = list(a.shape)
    shape[axis] = n
    padded = np.zeros(shape, a.dtype)
    padded[(slice(None),) * axis + (slice(have),)] = a
    return padded


def _nothing(a: Array, axis: int, n: int, kind: str) -> Array | None:
    """The result of no numbers, which is none."""
    if n < 1:
        raise ValueError(f"n: expected at least 1, found {n}")
    if a.size:
        return None
    shape = list(a.shape)
    shape[axis] = n
    single = a.dtype in (np.dtype(np.float32), np.dtype(np.complex64))
    return np.empty(
        shape, {"c": (np.complex128, np.complex64), "f": (np.float64, np.float32)}[kind][single]
    )


def _real(a: npt.ArrayLike) -> Array:
    a = np.asarray(a)
    if a.dtype in _REAL and a.flags.aligned:
        return a
    if a.dtype.kind == "c":
        raise TypeError(f"x: expected real numbers, found {a.dtype}")
    is_single = a.dtype.kind == "f" and a.dtype.itemsize <= 4
    return np.require(a, np.float32 if is_single else np.float64, "A")


def _complex(a: npt.ArrayLike) -> Array:
    a = np.asarray(a)
    if a.dtype in _COMPLEX and a.flags.aligned:
        return a
    is_single = (a.dtype.kind == "f" and a.dtype.itemsize <= 4) or (
        a.dtype.kind == "c" and a.dtype.itemsize <= 8
    )
    return np.require(a, np.complex64 if is_single else np.complex128, "A")


def r2c(
    a: npt.ArrayLike,
    axis: int = 0,
    n: int | None = None,
    norm: Norm = None,
    workers: int | None = None,
) -> Array:
    """X_m = sum_n a_n exp(-2 pi i m n / N), m = 0 .. N / 2, along ``axis``.

    Parameters
    ----------
    a
        Real numbers of any strides.
    axis
        Axis of the transform, the first by default.
    n
        Samples that are transformed: fewer than there are, or with zeros behind them.
    norm
        As for ``scipy.fft``: results as they are (``"backward"``), over the root of N (``"ortho"``), or
        over N (``"forward"``).
    workers
        Threads, 1 by default; -1 stands for all. The bits do not depend on it.

    Returns
    -------
    numpy.ndarray
        N / 2 + 1 complex numbers along ``axis``, of 32 bits each for input of 32 bits.

    Raises
    ------
    ValueError, TypeError
        For an axis, a length or a type that does not fit.
    """
    a = _real(a)
    axis = _axis(a, axis)
    length = a.shape[axis] if n is None else n
    a = _fitted(a, length, axis)
    none = _nothing(a, axis, length // 2 + 1 if length else 0, "c")
    if none is not None:
        return none
    return _native.r2c(a, axis, _norm(norm, _FORWARD), _workers(workers))


def c2r(
    a: npt.ArrayLike,
    axis: int = 0,
    n: int | None = None,
    norm: Norm = None,
    workers: int | None = None,
) -> Array:
    """a_n = 1 / N sum_m X_m exp(2 pi i m n / N) over m of both signs, along ``axis``.

    The inverse of :func:`r2c`, with the same parameters and errors. ``n`` is the number of samples of
    the result, 2 (bins - 1) by default. Imaginary parts of bin 0 and of the Nyquist frequency do not
    count.
    """
    a = _complex(a)
    axis = _axis(a, axis)
    length = 2 * (a.shape[axis] - 1) if n is None else n
    if length < 1:
        raise ValueError(f"n: expected at least 1, found {length}")
    a = _fitted(a, length // 2 + 1, axis)
    none = _nothing(a, axis, length, "f")
    if none is not None:
        return none
    return _native.c2r(a, length, axis, _norm(norm, _INVERSE), _workers(workers))


def c2c(
    a: npt.ArrayLike,
    axis: int = 0,
    n: int | None = None,
    norm: Norm = None,
    workers: int | None = None,
    inverse: bool = False,
) -> Array:
    """X_m = sum_n a_n exp(-2 pi i m n / N), m = 0 .. N - 1, along ``axis``.

    With ``inverse`` the kernel is exp(2 pi i m n / N), and by default results are over N. Parameters
    and errors are those of :func:`r2c`.
    """
    a = _complex(a)
    axis = _axis(a, axis)
    length = a.shape[axis] if n is None else n
    a = _fitted(a, length, axis)
    none = _nothing(a, axis, length, "c")
    if none is not None:
        return none
    norms = _INVERSE if inverse else _FORWARD
    return _native.c2c(a, not inverse, axis, _norm(norm, norms), _workers(workers))


def rfft(
    x: npt.ArrayLike,
    n: int | None = None,
    axis: int = -1,
    norm: Norm = None,
    overwrite_x: bool = False,
    workers: int | None = None,
    *,
    plan: None = None,
) -> Array:
    """As ``scipy.fft.rfft``; see :func:`r2c`. Nothing is overwritten."""
    return r2c(x, axis, n, norm, workers)


def irfft(
    x: npt.ArrayLike,
    n: int | None = None,
    axis: int = -1,
    norm: Norm = None,
    overwrite_x: bool = False,
    workers: int | None = None,
    *,
    plan: None = None,
) -> Array:
    """As ``scipy.fft.irfft``; see :func:`c2r`. Nothing is overwritten."""
    return c2r(x, axis, n, norm, workers)


def fft(
    x: npt.ArrayLike,
    n: int | None = None,
    axis: int = -1,
    norm: Norm = None,
    overwrite_x: bool = False,
    workers: int | None = None,
    *,
    plan: None = None,
) -> Array:
    """As ``scipy.fft.fft``; see :func:`c2c`. Nothing is overwritten."""
    return c2c(x, axis, n, norm, workers)


def ifft(
    x: npt.ArrayLike,
    n: int | None = None,
    axis: int = -1,
    norm: Norm = None,
    overwrite_x: bool = False,
    workers: int | None = None,
    *,
    plan: None = None,
) -> Array:
    """As ``scipy.fft.ifft``; see :func:`c2c`. Nothing is overwritten."""
    return c2c(x, axis, n, norm, workers, inverse=True)


class _Backend:
    """The functions above as a backend of ``scipy.fft``."""

    __ua_domain__ = "numpy.scipy.fft"

    @staticmethod
    def __ua_function__(method: Callable[..., Any], args: Any, kwargs: Any) -> Any:
        known = {"rfft": rfft, "irfft": irfft, "fft": fft, "ifft": ifft}
        function = known.get(method.__name__)
        if function is None:
            return NotImplemented
        array = args[0] if args else kwargs.get("x")
        if np.asarray(array).dtype.char in "gGO":
            return NotImplemented
        return function(*args, **kwargs)


#: For ``scipy.fft.set_backend`` and ``scipy.fft.set_global_backend``.
backend = _Backend
