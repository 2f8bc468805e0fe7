"""Fourier transforms along one axis of an array: a drop-in for those of ``scipy.fft``.

Columns (any axis but the last of a C-ordered array) are transformed many at once, without a transpose.
Numbers of 32 bits stay so. ``scipy.fft.set_backend(wavecascade.fft.backend)`` has SciPy's functions call
these; what is not here, SciPy does itself.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from wavecascade import _native

__all__ = ["backend", "c2c", "c2r", "fft", "ifft", "irfft", "r2c", "rfft"]

Norm = Literal["backward", "ortho", "forward"] | None
Array = npt.NDArray[Any]

#: By what results are multiplied, forward and back: 0 nothing, 1 by 1 / n, 2 by 1 / sqrt(n).
_FORWARD = {None: 0, "backward": 0, "ortho": 2, "forward": 1}
_INVERSE = {None: 1, "backward": 1, "ortho": 2, "forward": 0}

#: Real and complex numbers, of 64 and of 32 bits.
_TYPES = {
    "f": (np.dtype(np.float64), np.dtype(np.float32)),
    "c": (np.dtype(np.complex128), np.dtype(np.complex64)),
}


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
    if n < 1:
        raise ValueError(f"n: expected at least 1, found {n}")
    if have == n:
        return a
    if have > n:
        return a[(slice(None),) * axis + (slice(n),)]
    shape = list(a.shape)
    shape[axis] = n
    padded = np.zeros(shape, a.dtype)
    padded[(slice(None),) * axis + (slice(have),)] = a
    return padded


def _numbers(a: npt.ArrayLike, kind: str) -> Array:
    """Aligned real or complex numbers, of 32 bits where they are no longer."""
    a = np.asarray(a)
    if a.dtype in _TYPES[kind] and a.flags.aligned:
        return a
    if a.dtype.kind == "c" and kind == "f":
        raise TypeError(f"x: expected real numbers, found {a.dtype}")
    bits = 8 * a.dtype.itemsize // (2 if a.dtype.kind == "c" else 1)
    return np.require(a, _TYPES[kind][a.dtype.kind in "fc" and bits <= 32], "A")


def _nothing(a: Array, axis: int, n: int, kind: str) -> Array:
    """The result of no numbers, which is none."""
    shape = (*a.shape[:axis], n, *a.shape[axis + 1 :])
    return np.empty(shape, _TYPES[kind][a.dtype.itemsize == 4 * (1 + (a.dtype.kind == "c"))])


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
    a = _numbers(a, "f")
    axis = _axis(a, axis)
    length = a.shape[axis] if n is None else n
    a = _fitted(a, length, axis)
    if not a.size:
        return _nothing(a, axis, length // 2 + 1, "c")
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
    a = _numbers(a, "c")
    axis = _axis(a, axis)
    length = 2 * (a.shape[axis] - 1) if n is None else n
    a = _fitted(a, length // 2 + 1 if length > 0 else length, axis)
    if not a.size:
        return _nothing(a, axis, length, "f")
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
    a = _numbers(a, "c")
    axis = _axis(a, axis)
    length = a.shape[axis] if n is None else n
    a = _fitted(a, length, axis)
    if not a.size:
        return _nothing(a, axis, length, "c")
    norms = _INVERSE if inverse else _FORWARD
    return _native.c2c(a, not inverse, axis, _norm(norm, norms), _workers(workers))


class _LikeScipy(Protocol):
    def __call__(
        self,
        x: npt.ArrayLike,
        n: int | None = None,
        axis: int = -1,
        norm: Norm = None,
        overwrite_x: bool = False,
        workers: int | None = None,
        *,
        plan: None = None,
    ) -> Array: ...


def _like_scipy(name: str, transform: Callable[..., Array], **fixed: bool) -> _LikeScipy:
    """A transform under the name and with the arguments that it has in ``scipy.fft``."""

    def function(
        x: npt.ArrayLike,
        n: int | None = None,
        axis: int = -1,
        norm: Norm = None,
        overwrite_x: bool = False,
        workers: int | None = None,
        *,
        plan: None = None,
    ) -> Array:
        return transform(x, axis, n, norm, workers, **fixed)

    function.__name__ = function.__qualname__ = name
    function.__doc__ = (
        f"As ``scipy.fft.{name}``; see :func:`{transform.__name__}`. Nothing is overwritten."
    )
    return function


rfft = _like_scipy("rfft", r2c)
irfft = _like_scipy("irfft", c2r)
fft = _like_scipy("fft", c2c)
ifft = _like_scipy("ifft", c2c, inverse=True)


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
