"""Objects with axes of other packages: where installed themselves, and stand-ins with what is read."""

import json
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from test_analyze import equal

import wavecascade as wc

pytestmark = pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")

DATE = np.datetime64("2026-03-01T12:00:00", "ns")


@pytest.fixture
def plain(field):
    """What the program makes of the field with its axes."""
    return wc.analyze(field, dt="5 ms", dx=2, space_unit="m", unit="m/s")


@dataclass
class Coords:
    """As of DASCore: coordinates by their names, with units."""

    arrays: dict[str, Any]
    units: dict[str, Any]
    dim_map: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self):
        self.dim_map = {name: (name,) for name in self.arrays}

    def get_array(self, name):
        return self.arrays[name]

    def get_coord(self, name):
        return SimpleNamespace(units=self.units.get(name))


def patch(values):
    """A patch ``(distance, time)``."""
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    arrays = {"distance": 2.0 * np.arange(31), "time": DATE + 5_000_000 * np.arange(207)}
    coords = Coords(arrays, {"distance": unit.Quantity(1, "m"), "time": unit.Quantity(1, "s")})
    attrs = SimpleNamespace(data_units=unit.Quantity(1, "m/s"), data_type="velocity")
    return SimpleNamespace(dims=("distance", "time"), coords=coords, data=values.T, attrs=attrs)


def traces(values, **others):
    """A stream of obspy."""
    stats = {"starttime": "2026-03-01T12:00:00", "delta": 0.005, "npts": len(values)}
    every = [
        SimpleNamespace(
            data=values[:, j].copy(),
            id=f"XX.S{j:02}..HHZ",
            stats=SimpleNamespace(**{**stats, "distance": 2.0 * j, **others.get(f"of_{j}", {})}),
        )
        for j in range(values.shape[1])
    ]
    return SimpleNamespace(traces=every)


def test_a_patch_keeps_its_axes(field, plain):
    equal(wc.analyze(patch(field)), plain)
    dascore = pytest.importorskip("dascore")
    coords = {"distance": 2.0 * np.arange(31), "time": DATE + 5_000_000 * np.arange(207)}
    own = dascore.Patch(data=field.T, coords=coords, dims=("distance", "time"))
    own = own.set_units("m/s", distance="m", time="s")
    equal(wc.analyze(own), plain)
    # As DASCore writes it to xarray, with `data_units`.
    equal(wc.analyze(own.io.to_xarray(), space_unit="m"), plain)


def test_traces_keep_their_axes(field, plain):
    stream = traces(field)
    found = wc.analyze(stream, unit="m/s")
    equal(found.drop_vars("trace_id"), plain)
    assert list(found.trace_id.values[:2]) == ["XX.S00..HHZ", "XX.S01..HHZ"]
    assert found.trace_id.dims == ("position",)
    record = wc.spectrum(stream.traces[3], segment=64)
    assert record.attrs["independence"] and record.frequency.values[-1] == 100.0
    for name, value in (("delta", 0.004), ("npts", 3), ("starttime", "2026-03-01T12:00:01")):
        with pytest.raises(ValueError, match=f"traces of one {name}"):
            wc.analyze(traces(field, of_3={name: value}))
    obspy = pytest.importorskip("obspy")
    header = {"delta": 0.005, "starttime": obspy.UTCDateTime("2026-03-01T12:00:00")}
    own = obspy.Stream(
        [obspy.Trace(field[:, j].copy(), {**header, "distance": 2.0 * j}) for j in range(31)]
    )
    equal(wc.analyze(own, unit="m/s").drop_vars("trace_id"), plain)


def test_two_records_keep_their_axes(field):
    pandas = pytest.importorskip("pandas")
    one, two = (pandas.Series(field[:, j], 0.005 * np.arange(207)) for j in (3, 9))
    found = wc.coherence(one, two, segment=64)
    expected = wc.coherence(field[:, [3, 9]], dt=0.005, segment=64)
    np.testing.assert_array_equal(found.frequency, expected.frequency)
    np.testing.assert_array_equal(found.coherence, expected.coherence)
    stream = traces(field)
    again = wc.coherence(stream.traces[3], stream.traces[9], segment=64)
    np.testing.assert_array_equal(again.coherence, expected.coherence)
    two.index = two.index + 0.001
    with pytest.raises(ValueError, match="the same time as of the first record"):
        wc.coherence(one, two, segment=64)


def test_tables_keep_their_axes(field, plain):
    pandas = pytest.importorskip("pandas")
    places = [f"{2 * j} m" for j in range(31)]
    dated = pandas.DataFrame(field, DATE + 5_000_000 * np.arange(207), places)
    equal(wc.analyze(dated, unit="m/s"), plain)
    numbers = pandas.DataFrame(field, 0.005 * np.arange(207), 2.0 * np.arange(31))
    numbers.index.name = "t [s]"
    equal(wc.analyze(numbers, unit="m/s", space_unit="m"), plain)
    # As it is read from a table of text.
    read = pandas.DataFrame(field, columns=[f"channel {j}" for j in range(31)])
    read.insert(0, "time (s)", 0.005 * np.arange(207))
    equal(wc.analyze(read, unit="m/s", dx=2, space_unit="m"), plain)
    # What counts from 0 says nothing.
    equal(wc.analyze(pandas.DataFrame(field)), wc.analyze(field))
    with pytest.raises(ValueError, match="columns of numbers, found name"):
        wc.analyze(read.assign(name="a"))


def test_other_objects_with_axes_are_refused(field):
    for other in (
        SimpleNamespace(columns=["a"], schema={}),
        SimpleNamespace(times=[1, 2], info={}),
        SimpleNamespace(coords={}, dims=("x",)),
    ):
        with pytest.raises(
            TypeError, match=r"axes are not read.*xarray.DataArray\(values, coords, dims\)"
        ):
            wc.analyze(other)
    values = xr.Variable(("x", "time"), field.T)
    equal(wc.analyze(values), wc.analyze(field))


def test_unknown_names_are_doubted_as_those_of_numpy():
    wide = np.random.default_rng(8).standard_normal((16, 300))
    found = {}
    for array in (wide, xr.DataArray(wide, dims=("a", "b"))):
        with pytest.warns(wc.CascadeWarning, match="layout") as warned:
            wc.analyze(array)
        found[type(array)] = [str(one.message) for one in warned if "layout" in str(one.message)]
    assert len({tuple(texts) for texts in found.values()}) == 1
    import warnings

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        wc.analyze(xr.DataArray(wide, dims=("a", "b")), layout="time-site")
    assert not any("layout" in str(one.message) for one in caught)


def test_units_of_the_cf_conventions(field, plain):
    time = ("time", 5_000_000 * np.arange(207) + 7, {"units": "nanoseconds since 2026-03-01 12:00"})
    coords = {"time": time, "x": ("x", 2.0 * np.arange(31), {"units": "metres"})}
    da = xr.DataArray(field, coords, ("time", "x"), "velocity", {"units": "m s-1"})
    found = wc.analyze(da)
    equal(found, plain)
    for name in ("temporal_spectrum", "frequency", "wavenumber"):
        assert found[name].attrs["units"] == plain[name].attrs["units"]
    days = da.assign_coords(time=("time", np.arange(207) / 24, {"units": "days since 2026-03-01"}))
    assert abs(wc.analyze(days).attrs["dt"] - 1) < 1e-9
    # pint-xarray and MetPy write long names.
    equal(wc.analyze(da.assign_attrs(units="meter / second")), plain)


def test_dates_of_all_kinds(field, plain):
    pandas = pytest.importorskip("pandas")
    steps = pandas.date_range("2026-03-01 12:00", periods=207, freq="5ms")
    dates = {
        "zone": steps.tz_localize("Europe/Zurich"),
        "periods": pandas.period_range("2026-03-01 12:00", periods=207, freq="5ms"),
        "durations": steps - steps[0],
    }
    for name, dated in dates.items():
        da = xr.DataArray(field, {"time": dated, "x": 2.0 * np.arange(31)}, ("time", "x"), "velocity")
        found = wc.analyze(da, unit="m/s", space_unit="m")
        assert found.attrs["dt"] == 0.005, name
        equal(found, plain)
        equal(
            wc.analyze(pandas.DataFrame(field, dated, 2.0 * np.arange(31)), unit="m/s", space_unit="m"),
            plain,
        )
    cftime = pytest.importorskip("cftime")
    days = cftime.num2date(np.arange(207), "days since 2026-02-27", calendar="360_day")
    found = wc.analyze(xr.DataArray(field, {"time": days}, ("time", "x")))
    assert found.attrs["dt"] == 86400.0


def test_further_dimensions_are_mapped_over(field):
    coords = {"time": 0.5 * np.arange(207), "event": ("event", [7, 9, 11], {"long_name": "event"})}
    both = np.stack([field, field[::-1], 2 * field])
    da = xr.DataArray(both, coords, ("event", "time", "x"), "velocity")
    found = da.transpose("time", "event", "x").cascade.analyze()
    assert found.temporal_spectrum.dims[0] == "event"
    assert list(found.event) == [7, 9, 11] and found.event.attrs == {"long_name": "event"}
    for i in range(3):
        one = wc.analyze(da.isel(event=i, drop=True))
        np.testing.assert_array_equal(found.spacetime_spectrum[i], one.spacetime_spectrum)
        # What differs is a variable, what does not an attribute.
        for name, value in one.attrs.items():
            if name in found.attrs:
                assert found.attrs[name] == value, name
            else:
                told = json.dumps(value) if isinstance(value, list) else value
                assert found[name].values[i] == told, name
    assert found.attrs["dt"] == 0.5 and "answer" in found.variables
    several = xr.Dataset({"v": da, "w": 2 * da})
    chosen = wc.analyze(several, variable="w").temporal_spectrum
    np.testing.assert_allclose(chosen, 4 * found.temporal_spectrum, rtol=1e-12, atol=1e-12)
    # Shots are realisations, not places.
    shots = da.expand_dims(shot=2).cascade.spectrum()
    one = wc.spectrum([field, field], dt=0.5)
    np.testing.assert_array_equal(shots.spectrum.isel(event=0), one.spectrum)
    assert wc.analyze(both, dt=0.5).sizes["batch_1"] == 3
    filtered = da.cascade.filter(frequency=(0.1, 0.5))
    assert filtered.dims == da.dims
    np.testing.assert_allclose(filtered[2], 2 * filtered[0], rtol=0, atol=1e-13)


def test_further_coordinates_stay(field):
    coords = {
        "time": 0.5 * np.arange(207),
        "x": 2.0 * np.arange(31),
        "depth": ("x", 10.0 - np.arange(31), {"units": "m"}),
        "station": ("x", [f"S{j}" for j in range(31)]),
        "temperature": ("time", np.arange(207.0)),
        "run": 4,
    }
    da = xr.DataArray(field, coords, ("time", "x"), "velocity")
    found = wc.analyze(da)
    assert found.depth.dims == ("position",) and found.depth.attrs == {"units": "m"}
    assert found.station[3] == "S3" and found.run == 4
    np.testing.assert_array_equal(found.temperature, da.temperature)
    part = wc.analyze(da, sites=(4, 20), only="temporal")
    assert list(part.station.values) == [f"S{j}" for j in range(4, 20)]
    assert wc.spectrum(da).station[5] == "S5"


def test_val_tables_of_two_levels_and_nullable_columns(field):
    pd = pytest.importorskip("pandas")
    table = pd.DataFrame(field, index=pd.Index(0.005 * np.arange(len(field)), name="time"))
    known = wc.spectrum(table)
    for other in (table.stack(), table.astype("Float64")):
        assert np.array_equal(known.spectrum, wc.spectrum(other).spectrum, equal_nan=True)


@pytest.mark.parametrize(
    ("what", "error", "found"),
    [
        (lambda: wc.spectrum(None), TypeError, "found builtins.NoneType"),
        (lambda: wc.spectrum({"a": np.ones((64, 4))}), TypeError, "found builtins.dict"),
        (
            lambda: wc.spectrum(
                xr.DataArray(np.ones((64, 4), "i2"), dims=("time", "x"), attrs={"scale_factor": 0.1})
            ),
            ValueError,
            "found int16 packed by scale_factor; unpack them with xarray.decode_cf",
        ),
        (
            lambda: wc.simulate([1], sites=12),
            TypeError,
            "scene: expected keys as.*found list",
        ),
        (lambda: wc.compare(np.ones((64, 4)), np.ones((64, 4))), TypeError, "scene: .*found ndarray"),
    ],
)
def test_regress_what_is_no_field_or_scene(what, error, found):
    with pytest.raises(error, match=found):
        what()
