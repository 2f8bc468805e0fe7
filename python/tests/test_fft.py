"""Transforms against SciPy's, of all lengths, axes, types and layouts."""

import numpy as np
import pytest

import wavecascade as wc

scipy_fft = pytest.importorskip("scipy.fft")

SHAPES = [(16,), (15,), (1,), (17, 5), (8, 6), (30, 1), (1, 9), (6, 7, 8), (9, 1, 4), (2, 3, 4, 5)]


def layouts(shape, dtype):
    array = (100 * np.random.default_rng(7).standard_normal(shape)).astype(dtype)
    yield array
    yield np.asfortranarray(array)
    yield array[tuple(slice(None, None, -1) for _ in shape)]
    yield np.repeat(array, 2, axis=-1)[..., ::2]


@pytest.mark.parametrize("dtype", ["f8", "f4", "i4", ">f8", ">f4", "f2", "?"])
@pytest.mark.parametrize("shape", SHAPES)
def test_val_scipy_rfft(shape, dtype):
    for array in layouts(shape, dtype):
        for axis in range(-1, len(shape)):
            expected = scipy_fft.rfft(array, axis=axis)
            for workers in (1, 2):
                found = wc.fft.rfft(array, axis=axis, workers=workers)
                assert found.dtype == expected.dtype
                atol = 16 * np.finfo(expected.dtype).eps * (np.abs(expected).max() + 100)
                np.testing.assert_allclose(found, expected, rtol=0, atol=atol)


def test_bits_do_not_depend_on_workers():
    array = np.random.default_rng(5).standard_normal((1000, 37))
    for axis in (0, 1):
        one = wc.fft.rfft(array, axis=axis)
        for workers in (-1, 3):
            assert one.tobytes() == wc.fft.rfft(array, axis=axis, workers=workers).tobytes()


def test_arrays_without_samples_and_errors():
    array = np.zeros((4, 5))
    assert wc.fft.rfft(np.zeros((12, 0)), axis=0).shape == (7, 0)
    for a, axis, error in ((array, 2, "axis"), (1.0, 0, "axis"), (np.zeros((0, 3)), 0, "samples")):
        with pytest.raises(ValueError, match=error):
            wc.fft.rfft(a, axis=axis)
    with pytest.raises(ValueError, match="workers"):
        wc.fft.rfft(array, axis=0, workers=0)
    for a in (array.astype(complex), np.array(["text"])):
        with pytest.raises(TypeError, match="real"):
            wc.fft.rfft(a, axis=0)
