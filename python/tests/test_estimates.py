"""Estimates against the program, SciPy, nitime, xrft and NumPy."""

import inspect
import json
import re
import subprocess
import warnings
from unittest import mock

import numpy as np
import pytest
import xarray as xr

import wavecascade as wc
from conftest import same
from wavecascade._commands import estimates
from wavecascade._keywords import options as options_of

pytestmark = pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")

UNEVEN = np.cumsum(np.random.default_rng(3).uniform(0.5, 1.5, 101))


def said(options) -> list[str]:
    """Keywords as they are typed."""
    found = []
    for name, value in options.items():
        if isinstance(value, tuple) and not name.endswith("multitaper"):
            value = ":".join("" if end is None else str(end) for end in value)
        elif isinstance(value, (list, tuple)):
            value = ",".join(map(str, value))
        option = "--" + name.rstrip("_").replace("_", "-")
        found.append(option if value is True else f"{option}={value}")
    return found


CASES = [
    ("spectrum", {"dt": 0.5}),
    ("spectrum", {"multitaper": (4, 7), "significance": 0.1}),
    ("spectrum", {"multitaper": (3, 4), "equal_weights": True, "segment": 64, "threads": 1}),
    ("spectrum", {"along": "space", "periodogram": True, "dx": "2 mm"}),
    ("spectrum", {"along": "both", "segment": 64, "space_multitaper": (2, 3)}),
    ("coherence", {"reference": 3, "segment": 32, "overlap": 0.25, "window": "hamming"}),
    ("coherence", {"multitaper": (4, 7), "detrend": "linear"}),
    ("bicoherence", {"segment": 32, "along": (2, 9), "every": 3}),
    ("bicoherence", {"site": 2, "output": 5, "segment": 16, "every": 0}),
    (
        "bicoherence",
        {"site": 3, "transfer": 6, "segment": 16, "highest": 0.2, "resamplings": 20, "every": 0},
    ),
    ("modes", {"segment": 32, "frequencies": [0.1, 0.2], "modes": 2}),
    ("increments", {"separations": [1, 2, 4, 8], "lags": [1, 3], "band": (1, 8), "histograms": 2}),
    ("slope", {"band": (0.3, 2.5), "frames": 5, "dt": 0.1}),
    ("slope", {"along": "time", "band": (0.02, 0.4), "breaks": 0, "segment": 64}),
    ("flux", {"mass_per_length": 0.3, "bands": 4, "towards": "plus-x"}),
    ("flux", {"mass_per_length": [1.0, 0.5], "bands": 2}),
    ("ridges", {"segment": 64, "fit": "c*abs(k); c=1", "window_space": "none", "cut": "wavenumber"}),
]


@pytest.mark.parametrize(("command", "options"), CASES)
def test_val_program_every_array_and_the_summary(field, run, tmp_path, command, options):
    path = tmp_path / "field.npy"
    np.save(path, field)
    out = run(command, path, "--figures", "none", *said(options))
    function = getattr(wc, command)
    with np.load(out / f"{command}.npz") as archive:
        for given in (field, path):
            found = function(given, **options)
            same(found, archive)
            assert set(found.variables) == set(archive.files)
    summary = json.loads((out / "summary.json").read_text())
    for part, value in summary.items():
        if part in found.attrs and part != "provenance":
            attr = found.attrs[part]
            assert (json.loads(attr) if isinstance(value, (list, dict)) else attr) == value, part
    told = {part for part, value in summary.items() if value is not None} - set(found.variables)
    assert told - {"columns", "delays", "outputs", "speeds"} == set(found.attrs)
    # Files of NetCDF take all attributes.
    found.to_netcdf(tmp_path / "found.nc", engine="scipy")
    assert set(function(field.T, layout="site-time", **options).variables) == set(found.variables)


#: Where results go, and what is shown of them: nothing for functions.
OF_FILES = {
    "colormap",
    "db",
    "decades",
    "dpi",
    "figure-size",
    "figures",
    "force",
    "format",
    "help",
    "json",
}
OF_FILES |= {"max-time", "merge", "open", "out", "part", "plan", "quiet", "show", "style", "verbose"}


@pytest.mark.parametrize("command", ["analyze", "filter", *sorted({command for command, _ in CASES})])
def test_every_option_of_the_program_is_a_keyword(program, command):
    text = subprocess.run([program, command, "--help"], capture_output=True, text=True, check=True).stdout
    options = set(re.findall(r"^ +(?:-\w, )?--([a-z0-9-]+)", text, re.MULTILINE))
    assert len(options) > 20
    name = f"{command.title()}Options"
    own = getattr(estimates, name, None) or getattr(options_of, name)
    keywords = options_of.FieldOptions.__annotations__ | own.__annotations__
    known = {name.rstrip("_").replace("_", "-") for name in keywords}
    assert options - known <= OF_FILES


def equal(one, other):
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


@pytest.mark.parametrize(
    ("command", "options"),
    [
        ("coherence", {"multitaper": (4, 7)}),
        ("increments", {}),
        ("bicoherence", {"transfer": 4, "segment": 16}),
    ],
)
def test_val_program_shots_are_a_list_or_a_dimension(field, run, tmp_path, command, options):
    shots = [field, field[::-1], field[:, ::-1]]
    paths = [tmp_path / f"shot{i}.npy" for i in range(3)]
    for path, shot in zip(paths, shots, strict=True):
        np.save(path, shot)
    function = getattr(wc, command)
    found = function(shots, **options)
    with np.load(run(command, *paths, "--figures", "none", *said(options)) / f"{command}.npz") as archive:
        same(found, archive)
    stacked = np.stack(shots)
    equal(function(stacked, **options), found)
    equal(function(paths, **options), found)
    equal(function(tmp_path / "shot*.npy", **options), found)
    da = xr.DataArray(stacked, dims=("shot", "time", "x"))
    equal(function(da, **options), found)
    other = da.rename(shot="blow").transpose("x", "time", "blow")
    equal(function(other, shot_dim="blow", **options), found)
    with pytest.raises(ValueError, match="shot_dim: expected one of"):
        function(da, shot_dim="other", **options)


def test_two_records_are_two_sites(field):
    one, two = field[:, 3], field[:, 6]
    both = np.stack([one, two], axis=1)
    equal(wc.coherence(one, two, segment=32), wc.coherence(both, reference=0, segment=32))
    options = {"segment": 16, "every": 0, "transfer": 1, "resamplings": 20}
    equal(wc.bicoherence(one, two, **options), wc.bicoherence(both, site=0, output=1, **options))
    # Shots in front, and labels.
    shots = np.stack([one, two]), np.stack([two, one])
    expected = wc.coherence([both, both[:, ::-1]], segment=32)
    equal(wc.coherence(*shots, segment=32), expected)
    equal(wc.coherence([one, two], [two, one], segment=32), expected)
    da = xr.DataArray(field, {"time": 0.5 * np.arange(207.0), "x": 2.0 * np.arange(31)}, ("time", "x"))
    found = wc.coherence(da.isel(x=3), da.isel(x=6), segment=32)
    np.testing.assert_array_equal(found.position, [6, 12])
    assert found.coherence.values.tobytes() == wc.coherence(both, segment=32).coherence.values.tobytes()
    with pytest.raises(ValueError, match="other: expected two records of one dimension"):
        wc.coherence(one, two[:5])
    with pytest.raises(ValueError, match="other: expected a record like the first"):
        wc.coherence(da.isel(x=3), da.isel(x=6, time=slice(5)))
    with pytest.raises(ValueError, match="other: expected the same time"):
        wc.coherence(da.isel(x=3), da.isel(x=6).assign_coords(time=np.arange(207.0)))
    with pytest.raises(ValueError, match="other: expected as many records"):
        wc.coherence([one, two], [one])
    with pytest.raises(ValueError, match="reference: expected none beside two records"):
        wc.coherence(one, two, reference=1)


def test_coordinates_and_units(field):
    da = xr.DataArray(
        field,
        {
            "time": ("time", 0.5 * np.arange(207), {"units": "s"}),
            "x": ("x", 2.0 * np.arange(31), {"units": "mm"}),
        },
        ("time", "x"),
        "velocity",
        {"units": "m/s"},
    )
    found = da.cascade.coherence(segment=32)
    assert found.coherence.dims == ("frequency", "position")
    assert found.phase_velocity.dims == ("speed_frequency",)
    units = {"frequency": "Hz", "position": "mm", "spectrum": "(m/s)²/Hz", "delay": "s", "phase": "rad"}
    units |= {"wavenumber": "rad/mm", "phase_velocity": "mm/s"}
    assert {name: found[name].attrs["units"] for name in units} == units
    np.testing.assert_array_equal(found.position, da.x)
    found = da.cascade.spectrum(along="space")
    assert found.spectrum.dims == ("wavenumber", "time") and found.low.attrs["units"] == "(m/s)²/(rad/mm)"
    found = da.cascade.modes(segment=32)
    assert found.mode_real.dims == ("mode_frequency", "kept_mode", "position")
    assert found.eigenvalues.attrs["units"] == "(m/s)² mm/Hz"
    found = da.cascade.increments(separations=[1, 2])
    assert found.space_structure.dims == ("space_scale", "order")
    assert found.space_third.attrs["units"] == "(m/s)³"
    found = da.cascade.slope(band=(0.1, 1))
    assert found.frame_gradient.dims == ("frame_time",)
    found = da.cascade.bicoherence(segment=32, every=10)
    assert found.bicoherence.dims == ("triple",) and found.along_summed.dims == (
        "frequency",
        "along_site",
    )
    assert da.cascade.bicoherence(transfer=1, segment=16).transfer_pair_re.dims == ("transfer_pair",)
    found = da.cascade.ridges(segment=64)
    assert found.frequency.dims == ("point",) and found.group_velocity.attrs["units"] == "mm/s"
    assert da.cascade.coherence.__doc__ == wc.coherence.__doc__


def test_without_units_there_are_none(field):
    found = wc.slope(field, band=(0.3, 2.5))
    assert "units" not in found.wavenumber.attrs and "units" not in found.frame_gradient.attrs
    assert found.compensated.attrs["long_name"] == "compensated"


def test_doubts_are_warnings():
    rng = np.random.default_rng(8)
    pulse = np.zeros((512, 4))
    pulse[100:110] = rng.standard_normal((10, 4))
    for command in ("spectrum", "coherence", "modes", "increments", "bicoherence"):
        with pytest.warns(wc.CascadeWarning, match="transient"):
            getattr(wc, command)(pulse)
    with pytest.warns(wc.CascadeWarning, match="layout"):
        wc.modes(rng.standard_normal((16, 300)))


def test_errors_are_those_of_the_program(field, tmp_path):
    with pytest.raises(ValueError, match="transfer: expected a site from 0 to 30, found 40"):
        wc.bicoherence(field, segment=32, transfer=40)
    with pytest.raises(ValueError, match="required arguments were not provided: band"):
        wc.slope(field)
    with pytest.raises(ValueError, match="segment"):
        wc.spectrum(field, segment=1000)
    with pytest.raises(TypeError, match="referense"):
        wc.coherence(field, referense=3)
    with pytest.raises(TypeError, match="reference"):
        wc.spectrum(field, reference=3)
    with pytest.raises(FileNotFoundError, match="missing.npy"):
        wc.modes(tmp_path / "missing.npy")
    with pytest.raises(ValueError, match="cannot be used with"):
        wc.spectrum(field, periodogram=True, segment=8)


def test_progress_is_told_and_its_exception_cancels(field):
    def stop(stage, done, total):
        raise KeyboardInterrupt

    for work in (
        lambda: wc.modes(field, progress=stop),
        lambda: wc.filter(field, frequency=(0, 1), progress=stop),
    ):
        with pytest.raises(KeyboardInterrupt):
            work()


SHAPES = [(333, 5), (257, 7), (512, 3)]


@pytest.mark.parametrize("shape", SHAPES)
def test_val_nitime_multitaper_with_adaptive_weights(shape):
    pytest.importorskip("nitime")
    from nitime import utils
    from scipy import signal

    values = np.random.default_rng(shape[0]).standard_normal(shape)
    found = wc.spectrum(values, dt=0.25, layout="time-site", multitaper=(4, 7))
    count = shape[0]
    tapers, ratios = signal.windows.dpss(count, 4, 7, return_ratios=True)
    fold = np.where(2 * np.arange(count // 2 + 1) % count == 0, 1, 2)
    for j in range(shape[1]):
        transforms = np.fft.fft(tapers * (values[:, j] - values[:, j].mean()))
        # It ends its iteration where the error depends on the scale of the samples: made to go on.
        with warnings.catch_warnings(), mock.patch("numpy.percentile", lambda *_: 1.0):
            warnings.simplefilter("ignore")
            weights, _ = utils.adaptive_weights(transforms, ratios, sides="twosided", max_iter=2000)
        powers = (weights**2 * abs(transforms) ** 2).sum(axis=0) / (weights**2).sum(axis=0)
        expected = powers[: count // 2 + 1] * 0.25 * fold
        np.testing.assert_allclose(found["spectrum"][:, j], expected, rtol=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("window", ["hann", "hamming"])
def test_val_scipy_welch_and_coherence(shape, window):
    signal = pytest.importorskip("scipy.signal")
    values = np.random.default_rng(shape[0]).standard_normal(shape)
    values[:, 1:] += 0.7 * values[:, :1]
    options = {"dt": 0.5, "layout": "time-site", "segment": 63, "overlap": 20, "window": window}
    with_scipy = {"window": window, "nperseg": 63, "noverlap": 20, "axis": 0, "detrend": "constant"}
    found = wc.spectrum(values, **options)
    f, expected = signal.welch(values, 2.0, **with_scipy)
    np.testing.assert_allclose(found.frequency, f, rtol=1e-14)
    np.testing.assert_allclose(found["spectrum"], expected, rtol=1e-11, atol=1e-13)
    found = wc.coherence(values, reference=0, **options)
    _, expected = signal.coherence(values[:, :1], values, 2.0, **with_scipy)
    np.testing.assert_allclose(found.coherence[1:, 1:], expected[1:, 1:], rtol=1e-11, atol=1e-13)
    _, cross = signal.csd(values[:, :1], values, 2.0, **with_scipy)
    np.testing.assert_allclose(np.exp(1j * found.phase[1:]), np.exp(1j * np.angle(cross[1:])), atol=1e-9)


@pytest.mark.parametrize("shape", [(31, 27), (40, 9), (15, 64)])
def test_val_xrft_space_time_spectrum(shape):
    xrft = pytest.importorskip("xrft")
    values = np.random.default_rng(6).standard_normal(shape)
    coords = {"time": 0.5 * np.arange(shape[0]), "x": 0.25 * np.arange(shape[1])}
    da = xr.DataArray(values, coords, ("time", "x"))
    found = wc.analyze(da, only="spacetime", scaling="density").spacetime_spectrum
    expected = xrft.power_spectrum(da, dim=["time", "x"], real_dim="time", scaling="density")
    # Cycles per length there, rad here; and exp(-i k x) there, exp(i k x) here.
    n, width = shape[1], 0.25 * shape[1]
    theirs = np.rint(expected.freq_x.values * width).astype(int) % n
    ours = np.rint(-found.wavenumber_signed.values / (2 * np.pi) * width).astype(int) % n
    ordered = expected.transpose("freq_time", "freq_x").values[:, np.argsort(theirs)][:, ours] / (
        2 * np.pi
    )
    np.testing.assert_allclose(found, ordered, rtol=1e-11, atol=1e-14 * ordered.max())


def segments(values, length):
    """Transforms of half overlapping Hann segments: `(segment, bin, site)`."""
    starts = range(0, len(values) - length + 1, length - length // 2)
    parts = np.array([values[s : s + length] for s in starts])
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    return np.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * window[:, None], axis=1), window


@pytest.mark.parametrize(("shape", "length"), [((333, 5), 31), ((257, 40), 32)])
def test_val_numpy_modes(shape, length):
    values = np.random.default_rng(9).standard_normal(shape)
    found = wc.modes(values, dt=0.5, dx=0.25, layout="time-site", segment=length, frequencies=[0.5])
    x, window = segments(values, length)
    for m in range(1, (length + 1) // 2):
        cross = 2 * 0.5 * np.einsum("si,sj->ij", x[:, m], x[:, m].conj()) / len(x) / (window**2).sum()
        expected = 0.25 * np.linalg.eigvalsh(cross)[::-1][: found.sizes["mode"]]
        np.testing.assert_allclose(found.eigenvalues[m], expected, rtol=1e-9, atol=1e-13)
        np.testing.assert_allclose(found.total[m], 0.25 * np.trace(cross).real, rtol=1e-11)
    phi = (found.mode_real + 1j * found.mode_imag).values[0]
    np.testing.assert_allclose(0.25 * phi @ phi.conj().T, np.eye(len(phi)), atol=1e-9)


@pytest.mark.parametrize("length", [31, 32])
def test_val_numpy_bicoherence(length):
    values = np.random.default_rng(10).standard_normal((333, 2)) ** 3
    found = wc.bicoherence(values, layout="time-site", segment=length, every=0)
    x = segments(values, length)[0][:, :, 0]
    one, two = (np.rint(found[name].values * length).astype(int) for name in ("first", "second"))
    product = x[:, one] * x[:, two]
    mean = (product * x[:, one + two].conj()).mean(axis=0)
    below = (abs(product) ** 2).mean(axis=0) * (abs(x[:, one + two]) ** 2).mean(axis=0)
    np.testing.assert_allclose(found["bicoherence"], abs(mean) ** 2 / below, atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * found.biphase), mean / abs(mean), atol=1e-9)


@pytest.mark.parametrize("name", ["analyze", *sorted({command for command, _ in CASES})])
def test_help_names_every_parameter(name):
    function = getattr(wc, name)
    head, *sections = re.split(r"\n\n(\w+)\n-+\n", inspect.getdoc(function))
    assert head and sections[::2] == ["Parameters", "Returns", "Raises"]
    listed = [line.lstrip("*") for line in sections[1].splitlines() if not line.startswith(" ")]
    assert listed == list(inspect.signature(function).parameters)
    assert sections[5].split()[0] == "ValueError" and "\nOSError\n" in sections[5]


def test_dask_arrays_are_fields(field):
    dask = pytest.importorskip("dask.array")
    da = xr.DataArray(dask.from_array(field, chunks=50), dims=("time", "x"))
    equal(wc.modes(da, segment=32), wc.modes(field, segment=32))
