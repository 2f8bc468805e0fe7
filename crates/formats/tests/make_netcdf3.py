"""Writes tests/files/netcdf3 with netCDF4 and SciPy and reads it back with netCDF4 into expected.json.

Run: pip install numpy scipy netCDF4; python make_netcdf3.py. Versions are in expected.json.
"""
import json, pathlib, sys
import netCDF4
import numpy as np
import scipy
from scipy.io import netcdf_file

here = pathlib.Path(__file__).parent / "files" / "netcdf3"
here.mkdir(parents=True, exist_ok=True)


def fill(data, create, kinds):
    rng = np.random.default_rng(2)
    for kind in kinds:
        # Three values of one or two bytes a record are padded.
        create(f"fixed_{kind}", kind, ("y", "x"))[:] = (rng.random((2, 3)) * 100).astype(kind)
        create(f"record_{kind}", kind, ("time", "x"))[0:4] = (rng.random((4, 3)) * 100).astype(kind)
    x = create("x", "f8", ("x",))
    x[:] = [0.0, 0.5, 1.0]
    x.units = "m"
    time = create("time", "f4", ("time",))
    time[0:4] = np.arange(4) / 10
    v = create("v", "i2", ("time", "y", "x"))
    v[0:4] = rng.integers(-99, 99, (4, 2, 3))
    v.units, v.long_name = "m/s", "velocity"
    v.scale_factor, v.add_offset = np.float64(0.01), np.float64(3.0)
    v.valid_range = np.array([-99, 99], "i2")
    if not isinstance(data, netcdf_file):
        # SciPy places a scalar after the records, which netCDF4 refuses.
        create("scalar", "f8", ())[...] = np.pi
    create("label", "S1", ("x",))[:] = np.array([b"a", b"b", b"c"])
    data.title = "a test"


def single(data, create):
    """One variable of records alone, whose records of three bytes are not padded."""
    create("only", "i1", ("time", "x"))[0:4] = np.arange(12).reshape(4, 3).astype("i1")


def write(name, format):
    make_only = "single" in name
    kinds = ["i1", "i2", "i4", "f4", "f8"]
    kinds += ["u1", "u2", "u4", "i8", "u8"] if format == "NETCDF3_64BIT_DATA" else []
    if format == "scipy":
        data = netcdf_file(here / name, "w", version=1)
        kinds = kinds[:5]
    else:
        data = netCDF4.Dataset(here / name, "w", format=format)
        data.set_auto_maskandscale(False)
    for dimension, length in {"time": None, "y": 2, "x": 3}.items():
        data.createDimension(dimension, length)

    def create(variable, kind, dimensions):
        made = data.createVariable(variable, kind, dimensions)
        if format != "scipy":
            made.set_auto_maskandscale(False)
        return made

    single(data, create) if make_only else fill(data, create, kinds)
    data.close()


files = {}
for name, format in {
    "classic.nc": "NETCDF3_CLASSIC", "offset.nc": "NETCDF3_64BIT_OFFSET",
    "data.nc": "NETCDF3_64BIT_DATA", "scipy.nc": "scipy",
    "single.nc": "NETCDF3_CLASSIC", "single_scipy.nc": "scipy",
}.items():
    write(name, format)
    out = {}
    with netCDF4.Dataset(here / name) as data:
        data.set_auto_maskandscale(False)
        data.set_auto_chartostring(False)
        for key, variable in data.variables.items():
            array = np.asarray(variable[...])
            if array.dtype.kind == "S":
                out[key] = {"other": "text"}
                continue
            little = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"))
            out[key] = {"shape": list(array.shape), "type": array.dtype.newbyteorder("=").str[1:],
                        "hex": little.tobytes().hex()}
    files[name] = out
versions = {"python": sys.version.split()[0], "numpy": np.__version__,
            "scipy": scipy.__version__, "netCDF4": netCDF4.__version__}
(here / "expected.json").write_text(json.dumps({"versions": versions, "files": files}, indent=1) + "\n")
