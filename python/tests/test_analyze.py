"""`analyze` against the program, xrft and closed forms, on arrays of all kinds."""

import copy
import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest
import xarray as xr

import wavecascade as wc
from conftest import LATTICE, same

pytestmark = pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")


def equal(one: xr.Dataset, other: xr.Dataset) -> None:
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"dt": "10us", "dx": 0.002, "space_unit": "m", "scaling": "density", "segment": 64},
        {"precision": "f32", "window_time": "hann", "detrend_time": "linear", "pad_space": 40},
        {"only": ["temporal", "short-time"], "short_time_sites": [2, 5], "sites": (1, 17)},
        {"layout": "site-time", "times": (3, None), "threads": 1},
        {"dispersion": "0.5*k", "direction_band": (0.1, 0.3)},
    ],
)
def test_val_program_every_array_has_the_same_bits(field, run, tmp_path, options):
    path = tmp_path / "field.npy"
    np.save(path, field)
    said = []
    for name, value in options.items():
        if isinstance(value, tuple):
            value = ":".join("" if end is None else str(end) for end in value)
        elif isinstance(value, list):
            value = ",".join(map(str, value))
        said.append(f"--{name.replace('_', '-')}={value}")
    with np.load(run("analyze", path, "--figures", "none", *said) / "spectra.npz") as archive:
        same(wc.analyze(field, **options), archive)
        same(wc.analyze(path, **options), archive)


def test_val_program_of_a_mapped_file(run):
    mapped = np.load(LATTICE, mmap_mode="r")
    with np.load(run("analyze", LATTICE, "--figures", "none") / "spectra.npz") as archive:
        same(wc.analyze(LATTICE), archive)
        del mapped


def test_arrays_of_any_layout_are_the_same_field(field):
    expected = wc.analyze(field, dt=0.1)
    wide = np.zeros((2 * 207, 3 * 31))
    wide[::2, ::3] = field
    packed = np.zeros(field.shape, [("other", "f4"), ("v", "f8")])
    packed["v"] = field
    frozen = field.copy()
    frozen.flags.writeable = False
    for array in [
        np.asfortranarray(field),
        wide[::2, ::3],
        field[::-1].copy()[::-1],
        field[:, ::-1].copy()[:, ::-1],
        field.astype(">f8"),
        packed["v"],
        frozen,
        np.ma.masked_array(field),
        field.T.copy().T,
    ]:
        equal(wc.analyze(array, dt=0.1), expected)
    equal(wc.analyze(field.T, dt=0.1, layout="site-time"), expected)


@pytest.mark.parametrize("dtype", ["f4", ">f4", "f2", "i2", ">i4", "u1", "i8", "?"])
def test_numbers_of_all_types_are_taken_as_they_are(field, dtype):
    array = np.abs(10 * field).astype(dtype)
    equal(wc.analyze(array), wc.analyze(array.astype(float)))


def test_no_copy_is_made_of_an_array():
    code = (
        "import resource, numpy as np, wavecascade as wc\n"
        "field = np.ones((4096, 4096)); field[::7] = 0.5\n"
        "peak = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "wc.analyze(field[:64, :64], only='spatial', maps=False)\n"
        "before = peak()\n"
        "wc.analyze(field, only='spatial', sites=(0, 2), maps=False, memory='32MB')\n"
        "print(peak() - before)"
    )
    said = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    # In KiB; a copy is 131072.
    assert int(said.stdout) < 65536


def test_gaps_of_masked_arrays_are_gaps(field):
    holes = np.zeros(field.shape, bool)
    holes[5, 3] = holes[100:104, 7] = True
    masked = np.ma.masked_array(field, holes)
    with pytest.raises(ValueError, match="expected finite samples, found 5 that are not") as raised:
        wc.analyze(masked)
    assert "`gaps=interpolate`" in raised.value.__notes__[0]
    gaps = np.where(holes, np.nan, field)
    equal(wc.analyze(masked, gaps="mask"), wc.analyze(gaps, gaps="mask"))


def test_coordinates_and_units_come_from_a_dataarray(field):
    t = 5e-6 * np.arange(207)
    da = xr.DataArray(
        field.T,
        {"x": ("x", 2.0 * np.arange(31), {"units": "mm"}), "time": ("time", t, {"units": "s"})},
        ("x", "time"),
        "velocity",
        {"units": "m/s"},
    )
    found = da.cascade.analyze()
    expected = wc.analyze(field, dt=5e-6, dx=2, time_unit="s", space_unit="mm", unit="m/s")
    equal(found, expected)
    assert found.frequency.attrs["units"] == "Hz"
    assert found.wavenumber.attrs["units"] == "rad/mm"
    assert found.temporal_spectrum.dims == ("frequency", "position")
    assert found.spacetime_spectrum.dims == ("frequency", "wavenumber_signed")
    assert abs(found.attrs["parseval_time"]) < 1e-14
    assert found.attrs["scaling"] == "energy"
    assert "spacetime_spectrum" in found._repr_html_()
    # Dates, in any order of the dimensions.
    dated = da.assign_coords(time=np.datetime64("2026-11-25T12:00", "ns") + (5000 * np.arange(207)))
    equal(wc.analyze(dated), expected)


def test_units_of_pint_are_units(field):
    pint = pytest.importorskip("pint")
    quantity = pint.UnitRegistry().Quantity(field, "mm/s")
    found = wc.analyze(quantity, dt="1 ms")
    equal(found, wc.analyze(field, dt="1 ms", unit="mm/s"))
    assert found.temporal_spectrum.attrs["units"] == "(mm/s)² s/Hz"


def test_val_xrft_spectrum_of_odd_lengths(field):
    xrft = pytest.importorskip("xrft")
    da = xr.DataArray(field, {"time": 0.5 * np.arange(207), "x": 0.25 * np.arange(31)}, ("time", "x"))
    found = wc.analyze(da, only="temporal", scaling="density")
    expected = xrft.power_spectrum(da, dim="time", real_dim="time", scaling="density")
    # One-sided, as here; all bins but 0 stand for two.
    power = found.temporal_spectrum.values
    np.testing.assert_allclose(power, expected.values, rtol=1e-12, atol=1e-14 * power.max())


def test_val_scipy_welch(field):
    signal = pytest.importorskip("scipy.signal")
    found = wc.analyze(
        field, dt=0.5, only="temporal", scaling="density", segment=64, window_time="hann", overlap=32
    )
    f, expected = signal.welch(field, 2.0, "hann", 64, 32, axis=0, detrend=False)
    np.testing.assert_allclose(found.frequency, f, rtol=1e-14)
    power = found.temporal_spectrum.values
    np.testing.assert_allclose(power, expected, rtol=1e-11, atol=1e-14 * power.max())


def test_errors_are_those_of_the_program(field, tmp_path):
    with pytest.raises(ValueError, match=r"^dt: |'dt <STEP>'"):
        wc.analyze(field, dt=-1)
    with pytest.raises(ValueError, match="segment: expected"):
        wc.analyze(field, segment=1000)
    with pytest.raises(ValueError, match="found 0 dimensions|one or two dimensions"):
        wc.analyze(np.float64(3.0))
    with pytest.raises(ValueError, match="expected real numbers, found complex128"):
        wc.analyze(np.zeros((2, 3), complex))
    with pytest.raises(TypeError, match="segmnet"):
        wc.analyze(field, segmnet=3)
    with pytest.raises(ValueError, match="variable: expected a file"):
        wc.analyze(field, variable="v")
    with pytest.raises(FileNotFoundError, match="missing.npy"):
        wc.analyze(tmp_path / "missing.npy")
    damaged = tmp_path / "damaged.npy"
    damaged.write_bytes(b"\x93NUMPY\x01\x00v\x00")
    with pytest.raises(OSError, match="damaged.npy"):
        wc.analyze(damaged)
    uneven = xr.DataArray(field, {"time": np.arange(207.0) ** 2}, ("time", "x"))
    with pytest.raises(ValueError, match="time"):
        wc.analyze(uneven)
    assert wc.analyze(uneven, dt=1).sizes["frequency"] == 104


def test_doubts_are_warnings():
    rng = np.random.default_rng(8)
    with pytest.warns(wc.CascadeWarning, match="layout"):
        found = wc.analyze(rng.standard_normal((16, 300)))
    assert "layout" in found.attrs["warnings"]


def test_progress_is_told_and_its_exception_cancels(field):
    told = []
    wc.analyze(field, progress=lambda *stage: told.append(stage))
    assert told and all(done <= total for _, done, total in told)

    def stop(stage, done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        wc.analyze(field, progress=stop)


def test_a_bar_of_tqdm(field, capsys):
    pytest.importorskip("tqdm")
    wc.analyze(field, progress=True)


def test_ctrl_c_cancels():
    code = (
        "import numpy as np, os, signal, threading, time, wavecascade as wc\n"
        "field = np.random.default_rng(1).standard_normal((4096, 2048))\n"
        # Again, since Python drops an interrupt that a destructor raises.
        "def press():\n"
        "    while True: time.sleep(0.5); os.kill(os.getpid(), signal.SIGINT)\n"
        "threading.Thread(target=press, daemon=True).start()\n"
        "try:\n"
        "    while True: wc.analyze(field, maps=False)\n"
        "except KeyboardInterrupt:\n"
        "    signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "    print('cancelled', flush=True)\n"
        "    os._exit(0)\n"
    )
    said = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True, timeout=120
    )
    assert said.stdout == "cancelled\n", said.stderr


def test_threads_have_the_same_bits_and_the_interpreter_goes_on(field):
    expected = wc.analyze(field, maps=False)
    found = [None] * 4
    counted = 0

    def work(i):
        found[i] = wc.analyze(field, maps=False, threads=1 + i % 2)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    [thread.start() for thread in threads]
    while any(thread.is_alive() for thread in threads):
        counted += 1
    [thread.join() for thread in threads]
    assert counted > 0
    for one in found:
        equal(one, expected)


def test_the_page_of_an_analysis(field, tmp_path):
    found = wc.analyze(field, dt=0.1)
    for one in (found, found.copy(), copy.deepcopy(found)):
        one.cascade.report(tmp_path / "out.html")
        page = (tmp_path / "out.html").read_text()
        assert page.startswith("<!DOCTYPE html>") and "S(k, f)" in page
    travelled = pickle.loads(pickle.dumps(found))
    equal(travelled, found)
    with pytest.raises(ValueError, match="expected what a function of wavecascade returned"):
        wc.report(travelled, tmp_path / "out.html")


def test_without_xarray_there_are_dictionaries(field):
    code = (
        "import sys; sys.modules['xarray'] = None\n"
        "import importlib.util as u; find = u.find_spec\n"
        "u.find_spec = lambda name, *a: None if name == 'xarray' else find(name, *a)\n"
        "import numpy as np, wavecascade as wc\n"
        "found = wc.analyze(np.eye(32), dt=0.5)\n"
        "print(type(found).__name__, found['temporal_spectrum'].shape, found['attrs']['dt'])\n"
    )
    said = subprocess.run([sys.executable, "-W", "ignore", "-c", code], capture_output=True, text=True)
    assert said.stdout == "dict (17, 32) 0.5\n", said.stderr


@pytest.mark.parametrize("which", ["temporal", "spatial"])
def test_spectra_of_dask_arrays_are_lazy_and_the_same(field, which):
    dask = pytest.importorskip("dask.array")
    spectrum = getattr(wc, f"{which}_spectrum")
    da = xr.DataArray(field, {"time": 0.5 * np.arange(207)}, ("time", "x"), "velocity")
    lazy = spectrum(da.copy(data=dask.from_array(field, chunks=(50, 7))), window_time="none")
    assert hasattr(lazy.data, "dask")
    eager = spectrum(da)
    assert lazy.dims == eager.dims and lazy.attrs == eager.attrs
    assert lazy.compute().values.tobytes() == eager.values.tobytes()
    for name in eager.coords:
        np.testing.assert_array_equal(lazy.coords[name], eager.coords[name])


def test_dask_arrays_are_fields(field):
    dask = pytest.importorskip("dask.array")
    equal(wc.analyze(dask.from_array(field, chunks=50)), wc.analyze(field))


def test_val_construction_arrays_that_changed_have_no_page(field, tmp_path):
    found = wc.analyze(field, dt=0.1)
    page = tmp_path / "out.html"
    found.cascade.report(page)
    cut = found.isel(time=slice(0, 5))
    with pytest.raises(ValueError, match="they were changed"):
        cut.cascade.report(page)
    assert page.exists()
