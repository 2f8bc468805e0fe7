"""Options as objects of other packages, and what errors advise."""

import datetime

import numpy as np
import pytest
import xarray as xr
from test_analyze import equal

import wavecascade as wc

pytestmark = pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")


def test_quantities_and_durations_are_options(field):
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    expected = wc.analyze(field, dt="5 us", dx="2 mm")
    for dt in (5 * unit.us, 5 * unit.microsecond):
        equal(wc.analyze(field, dt=dt, dx=2 * unit.mm), expected)
    for dt in (np.timedelta64(5, "us"), datetime.timedelta(microseconds=5)):
        found = wc.analyze(field, dt=dt, dx="2 mm")
        assert found.attrs["dt"] == 5e-6 and found.frequency.attrs["units"] == "Hz"
    band = (20 * unit.kHz, 60 * unit.kHz)
    found = wc.filter(field, dt="5 us", frequency=band)
    np.testing.assert_array_equal(found, wc.filter(field, dt="5 us", frequency=(2e4, 6e4)))
    scene = {"sites": 5, "units": "si", "material": "quartz", "end_time": "10 us"}
    scene |= {"angle": 30.0, "length": "18 mm"}
    run = wc.simulate(scene, radius=9 * unit.mm, striker_velocity=1.5 * unit.m / unit.s)
    again = wc.simulate(scene, radius="9 mm", striker_velocity="1.5 m/s")
    np.testing.assert_array_equal(run.velocity, again.velocity)


def test_windows_as_scipy_names_them(field):
    signal = pytest.importorskip("scipy.signal")
    for window, name in [
        (("kaiser", 8), "kaiser:8"),
        (("tukey", 0.3), "tukey:0.3"),
        ("blackmanharris", "blackman-harris"),
        ("boxcar", "none"),
    ]:
        equal(wc.analyze(field, window_time=window), wc.analyze(field, window_time=name))
    found = wc.spectrum(field, segment=64, overlap=32, window=("kaiser", 8), detrend="none")
    _, expected = signal.welch(field, 1.0, ("kaiser", 8), 64, 32, axis=0, detrend=False)
    np.testing.assert_allclose(found.spectrum, expected, rtol=1e-10, atol=1e-14)
    with pytest.raises(ValueError, match="window: expected a name"):
        wc.spectrum(field, window=(8, "kaiser"))
    # Its samples, of any window.
    parzen = signal.get_window("parzen", 64)
    found = wc.spectrum(field, segment=64, overlap=32, window=parzen, detrend="none")
    _, expected = signal.welch(field, 1.0, parzen, 64, 32, axis=0, detrend=False)
    np.testing.assert_allclose(found.spectrum, expected, rtol=1e-10, atol=1e-14)
    hann = signal.get_window("hann", 207).tolist()
    given, named = (wc.analyze(field, window_time=one).temporal_spectrum for one in (hann, "hann"))
    np.testing.assert_allclose(given, named, rtol=1e-12, atol=1e-14 * float(named.max()))
    with pytest.raises(ValueError, match="window") as raised:
        wc.spectrum(field, segment=32, window=parzen)
    assert len(str(raised.value)) < 200


def test_filtering_keeps_the_field(field):
    date = np.datetime64("2026-03-01T12:00", "ns") + 5_000_000 * np.arange(207)
    coords = {"x": ("x", 2.0 * np.arange(31), {"units": "mm"}), "time": date}
    coords["depth"] = ("x", np.arange(31.0))
    da = xr.DataArray(field.T, coords, ("x", "time"), "v_z", {"units": "m s-1", "made_by": "us"})
    found = da.cascade.filter(frequency=(20, 60))
    assert found.dims == da.dims and found.name == "v_z"
    xr.testing.assert_identical(found.coords.to_dataset(), da.coords.to_dataset())
    assert {key: found.attrs[key] for key in da.attrs} == da.attrs
    rest = da - found
    xr.testing.assert_identical(rest.coords.to_dataset(), da.coords.to_dataset())
    plain = wc.filter(field, dt="5 ms", frequency=(20, 60))
    np.testing.assert_array_equal(found.values.T, plain)
    np.testing.assert_array_equal(rest, da.values - found.values)
    record = da.isel(x=3).cascade.filter(frequency=(20, 60))
    assert record.dims == ("time",) and record.depth == 3.0


def test_errors_advise_what_is_taken(field):
    holes = field.copy()
    holes[5, 3] = np.nan
    with pytest.raises(ValueError, match="finite") as raised:
        wc.filter(holes, frequency=(0.1, 0.2))
    assert not any("gaps" in note for note in getattr(raised.value, "__notes__", []))
    with pytest.raises(ValueError, match="finite") as raised:
        wc.analyze(holes)
    assert any("gaps" in note for note in raised.value.__notes__)


def test_errors_are_short(field):
    for options in (
        {"short_time_times": list(np.linspace(0, 1e6, 20000))},
        {"sites": "1:" + "2" * 30000},
        {"segment": "9" * 5000},
        {"window_time": "hann" * 5000},
    ):
        with pytest.raises((ValueError, TypeError)) as raised:
            wc.analyze(field, **options)
        notes = "".join(getattr(raised.value, "__notes__", []))
        assert len(str(raised.value)) + len(notes) <= 2000


def test_a_store_of_zarr_is_opened_by_xarray(tmp_path):
    xr = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    xr.Dataset({"velocity": (("time", "x"), np.zeros((20, 4)))}).to_zarr(tmp_path / "field.zarr")
    for function in (wc.open, wc.analyze):
        with pytest.raises(OSError, match="Zarr") as error:
            function(tmp_path / "field.zarr")
        assert "xarray.open_zarr(path)" in error.value.__notes__[-1]
