"""Transforms against SciPy's, of all lengths, axes, types and layouts."""

import numpy as np
import pytest

import wavecascade as wc

scipy_fft = pytest.importorskip("scipy.fft")

SHAPES = [(16,), (15,), (1,), (17, 5), (8, 6), (30, 1), (1, 9), (6, 7, 8), (9, 1, 4), (2, 3, 4, 5)]


def close(found, expected, scale=1.0):
    assert found.shape == expected.shape and found.dtype == expected.dtype
    eps = np.finfo(expected.dtype).eps
    np.testing.assert_allclose(found, expected, rtol=0, atol=16 * eps * (np.abs(expected).max() + scale))


def arrays(shape, dtype):
    rng = np.random.default_rng(7)
    array = rng.standard_normal(shape)
    if np.dtype(dtype).kind == "c":
        array = array + 1j * rng.standard_normal(shape)
    array = array.astype(dtype)
    yield array
    yield np.asfortranarray(array)
    yield array[tuple(slice(None, None, -1) for _ in shape)]
    wide = np.repeat(array, 2, axis=-1)
    yield wide[..., ::2]


@pytest.mark.parametrize("dtype", ["f8", "f4"])
@pytest.mark.parametrize("norm", [None, "ortho", "forward"])
@pytest.mark.parametrize("shape", SHAPES)
def test_val_scipy_rfft_and_irfft(shape, norm, dtype):
    for array in arrays(shape, dtype):
        for axis in range(-1, len(shape)):
            for workers in (None, 2):
                found = wc.fft.rfft(array, axis=axis, norm=norm, workers=workers)
                expected = scipy_fft.rfft(array, axis=axis, norm=norm)
                close(found, expected)
            back = wc.fft.irfft(expected, shape[axis], axis, norm)
            close(back, scipy_fft.irfft(expected, shape[axis], axis, norm))


@pytest.mark.parametrize("dtype", ["c16", "c8"])
@pytest.mark.parametrize("shape", SHAPES)
def test_val_scipy_fft_and_ifft(shape, dtype):
    for array in arrays(shape, dtype):
        for axis in range(-1, len(shape)):
            for norm in (None, "ortho", "forward"):
                close(wc.fft.fft(array, axis=axis, norm=norm), scipy_fft.fft(array, axis=axis, norm=norm))
                close(
                    wc.fft.ifft(array, axis=axis, norm=norm), scipy_fft.ifft(array, axis=axis, norm=norm)
                )


@pytest.mark.parametrize("n", [1, 5, 6, 20])
def test_val_scipy_other_lengths(n):
    for array in arrays((7, 6), "f8"):
        for axis in (0, 1):
            close(wc.fft.rfft(array, n, axis), scipy_fft.rfft(array, n, axis))
            close(wc.fft.irfft(array, n, axis), scipy_fft.irfft(array, n, axis))
            close(wc.fft.fft(array, n, axis), scipy_fft.fft(array, n, axis))


@pytest.mark.parametrize("dtype", ["i4", ">f8", ">f4", "f2", "?"])
def test_val_scipy_other_types(dtype):
    array = (100 * np.random.default_rng(3).standard_normal((12, 5))).astype(dtype)
    close(wc.fft.rfft(array, axis=0), scipy_fft.rfft(array, axis=0))


def test_the_first_axis_is_the_default_of_r2c_and_c2r():
    array = np.random.default_rng(4).standard_normal((12, 5))
    close(wc.fft.r2c(array), scipy_fft.rfft(array, axis=0))
    close(wc.fft.c2r(wc.fft.r2c(array)), array)
    assert wc.fft.r2c(np.zeros((12, 0))).shape == (7, 0)


def test_bits_do_not_depend_on_workers():
    array = np.random.default_rng(5).standard_normal((1000, 37))
    for axis in (0, 1):
        one = wc.fft.rfft(array, axis=axis)
        assert one.tobytes() == wc.fft.rfft(array, axis=axis, workers=-1).tobytes()
        assert one.tobytes() == wc.fft.rfft(array, axis=axis, workers=3).tobytes()


def test_a_backend_of_scipy():
    array = np.random.default_rng(6).standard_normal((12, 5))
    with scipy_fft.set_backend(wc.fft.backend, only=True):
        assert scipy_fft.rfft(array, axis=0).tobytes() == wc.fft.rfft(array, axis=0).tobytes()
    with scipy_fft.set_backend(wc.fft.backend):
        # What is not here is SciPy's.
        close(scipy_fft.rfft2(array), np.fft.rfft2(array))
        assert scipy_fft.rfft(array.astype(np.longdouble)).dtype == np.clongdouble


def test_errors():
    array = np.zeros((4, 5))
    with pytest.raises(ValueError, match="axis"):
        wc.fft.rfft(array, axis=2)
    with pytest.raises(ValueError, match="n: expected at least 1"):
        wc.fft.rfft(array, 0)
    with pytest.raises(ValueError, match="norm"):
        wc.fft.rfft(array, norm="other")
    with pytest.raises(ValueError, match="workers"):
        wc.fft.rfft(array, workers=0)
    with pytest.raises(TypeError, match="real"):
        wc.fft.rfft(array.astype(complex))
    with pytest.raises(ValueError, match="axis"):
        wc.fft.rfft(1.0)
    with pytest.raises(ValueError):
        wc.fft.rfft(np.zeros((0, 3)), axis=0)
