"""Writes the HDF5 fixtures and what h5py reads from them.

Versions: h5py 3.16.0, netCDF4 1.7.5.1, h5netcdf 1.8.2, xarray 2026.9.0. Run: python make_hdf5.py
"""

import json
import os

import h5py
import numpy as np
import xarray as xr

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "hdf5")
os.makedirs(HERE, exist_ok=True)
rng = np.random.default_rng(7)


def at(name):
    path = os.path.join(HERE, name)
    if os.path.exists(path):
        os.remove(path)
    return path


with h5py.File(at("plain.h5"), "w") as f:
    f.attrs["title"] = "a test"
    f.attrs["rate"] = 2.5
    f["contiguous"] = rng.standard_normal((5, 7)).astype("f4")
    f["contiguous"].attrs["units"] = "m/s"
    f["contiguous"].attrs["names"] = ["a", "b"]
    f["contiguous"].attrs["numbers"] = np.array([1, 2, 3], "i4")
    f["big_endian"] = rng.integers(-30000, 30000, (4, 3)).astype(">i2")
    f["half"] = np.array([1.5, -(2**-24), 65504, np.inf, 0.1], "f2")
    f["flags"] = np.array([[True, False], [False, True]])
    f["scalar"] = np.float64(-1.25)
    f["wide"] = np.array([2**63 + 5, 7], "u8")
    f["text"] = "some text"
    f["complex"] = np.array([1 + 2j])
    f["pairs"] = np.array([(1, 2.0)], dtype=[("a", "i4"), ("b", "f8")])
    f["reference"] = np.array([f["wide"].ref], dtype=h5py.ref_dtype)
    f["colours"] = np.array([0, 1], dtype=h5py.enum_dtype({"RED": 0, "BLUE": 1}, "i1"))
    f["empty"] = h5py.Empty("f4")
    f.create_dataset("unwritten", (3, 2), "f4", fillvalue=-9.5)
    f.create_dataset("no_rows", (0, 2), "f4")
    g = f.create_group("zone/b")
    g.attrs["place"] = "lab"
    data = rng.standard_normal((11, 9, 3))
    g.create_dataset(
        "chunked", data=data, chunks=(4, 5, 2), compression="gzip", shuffle=True, fletcher32=True
    )
    g.create_dataset("big_chunks", data=data[:, :, 0].astype(">f4"), chunks=(3, 4))
    g.create_dataset("big_half", data=data[:, :, 1].astype(">f2"), chunks=(3, 4))
    holes = g.create_dataset("holes", (10, 10), "i4", chunks=(4, 4), fillvalue=-7)
    holes[2:3, 5:9] = 3
    foreign = g.create_dataset("foreign_fill", (4, 4), "f4", chunks=(2, 2))
    foreign[0] = 1
    foreign.attrs["_FillValue"] = -9.0
    g["loop"] = f["zone"]
    g["again"] = f["contiguous"]
    g["soft"] = h5py.SoftLink("/contiguous")
    g["elsewhere"] = h5py.ExternalLink("other.h5", "/x")
    layout = h5py.VirtualLayout((2, 7), "f4")
    layout[0] = h5py.VirtualSource(f["contiguous"])[0]
    f.create_virtual_dataset("virtual", layout)
    f.create_dataset("outside", (2,), "f4", external=[("raw.bin", 0, 8)])
    waves = np.round(np.sin(np.arange(2000) * 0.1), 2).reshape(100, 20)
    f.create_dataset("lzf", data=waves, chunks=(30, 20), compression="lzf", shuffle=True)
    f.create_dataset("packed", data=np.arange(8.0), chunks=(4,), compression="gzip")
    space = h5py.h5s.create_simple((2,))
    odd = h5py.h5t.IEEE_F32LE.copy()
    odd.set_ebias(120)
    h5py.h5d.create(f.id, b"odd_float", odd, space)
    odd = h5py.h5t.STD_I32LE.copy()
    odd.set_precision(24)
    h5py.h5d.create(f.id, b"odd_integer", odd, space)
os.path.exists("raw.bin") and os.remove("raw.bin")

# The number of a filter that is not read, in place of that of gzip.
with open(os.path.join(HERE, "plain.h5"), "r+b") as f:
    content = f.read()
    pipeline = b"\x01\x01\x00\x00\x00\x00\x00\x00\x01\x00\x08\x00\x01\x00\x01\x00deflate\x00"
    assert content.count(pipeline) == 1
    f.seek(content.index(pipeline) + 8)
    f.write((32015).to_bytes(2, "little"))

with h5py.File(at("latest.h5"), "w", libver="latest") as f:
    rows = rng.standard_normal((9, 4))
    f.create_dataset(
        "extensible", data=rows, chunks=(2, 3), maxshape=(None, 4), compression="gzip"
    )
    counts = rng.integers(0, 99, (9, 4)).astype("u2")
    f.create_dataset("tree", data=counts, chunks=(2, 3), maxshape=(None, None))
    f.create_dataset("fixed", data=rows.astype("f4"), chunks=(2, 3))
    f.create_dataset("single", data=rows[:3], chunks=(3, 4), compression="gzip")
    f["plain"] = np.arange(6, dtype="i8").reshape(2, 3)
    many = f.create_group("many")
    for i in range(20):
        many[f"v{i:02}"] = np.int8(i)
    dcpl = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    dcpl.set_layout(h5py.h5d.COMPACT)
    space = h5py.h5s.create_simple((2, 2))
    compact = h5py.h5d.create(f.id, b"compact", h5py.h5t.IEEE_F64BE, space, dcpl)
    compact.write(h5py.h5s.ALL, h5py.h5s.ALL, np.array([[1.0, 2.0], [3.0, 4.5]]))

with h5py.File(at("scales.h5"), "w") as f:
    f["v"] = rng.standard_normal((4, 3))
    f["t"] = np.arange(4) * 0.5
    f["t"].attrs["units"] = "s"
    f["x"] = np.array([0.0, 1.0, 3.0])
    f["t"].make_scale("time")
    f["x"].make_scale()
    f["v"].dims[0].attach_scale(f["t"])
    f["v"].dims[1].attach_scale(f["x"])
    f["labelled"] = np.zeros((2, 2))
    f["labelled"].dims[1].label = "pitch"

u = rng.standard_normal((5, 4, 2)).astype("f4")
start = np.datetime64("2001-02-03T04:05:06", "ns")
ds = xr.Dataset(
    {
        "u": (("time", "x", "level"), u, {"units": "m s-1", "long_name": "velocity"}),
        "packed": (("time", "x"), np.array([[0.5, np.nan, 1.0, 1.5]] * 5)),
    },
    coords={
        "time": start + np.arange(5) * np.timedelta64(250, "ms"),
        "x": np.array([0.0, 0.1, 0.2, 0.3]),
    },
)
packing = {"dtype": "i2", "scale_factor": 0.5, "add_offset": 1.0, "_FillValue": -999}
encoding = {"packed": {**packing, "zlib": True}}
ds.to_netcdf(at("xarray.nc"), engine="netcdf4", encoding=encoding)
ds.to_netcdf(at("h5netcdf.nc"), engine="h5netcdf", encoding=encoding)

with h5py.File(at("matlab73.mat"), "w", userblock_size=512) as f:
    f["v"] = rng.standard_normal((3, 6))
    f["v"].attrs["MATLAB_class"] = np.bytes_("double")
    f.create_dataset(
        "packed", data=rng.standard_normal((8, 6)), chunks=(4, 6), compression="gzip"
    )
    f["name"] = np.array([[118, 49]], "u2").T
    f["name"].attrs["MATLAB_class"] = np.bytes_("char")
with open(os.path.join(HERE, "matlab73.mat"), "r+b") as f:
    f.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")

OTHER = {"virtual", "outside", "odd_float", "odd_integer", "colours", "name",
         "zone/b/foreign_fill"}
expected = {}


def hexed(values):
    """Bytes of the numbers, the lowest first."""
    return np.ascontiguousarray(values).astype(values.dtype.newbyteorder("<")).tobytes().hex()


for name in sorted(os.listdir(HERE)):
    if name == "expected.json":
        continue
    arrays = expected[name] = {}

    def visit(path, found, name=name):
        if (name, path) == ("plain.h5", "packed"):
            return
        if not isinstance(found, h5py.Dataset) or found.shape is None or path in OTHER:
            return
        if found.dtype.kind not in "iufb":
            return
        if found.attrs.get("NAME", b"").startswith(b"This is a netCDF dimension"):
            return
        arrays["/" + path] = {
            "shape": list(found.shape),
            "type": found.dtype.kind + str(found.dtype.itemsize),
            "hex": hexed(np.asarray(found[()])),
        }

    with h5py.File(os.path.join(HERE, name)) as f:
        f.visititems(visit)

with open(os.path.join(HERE, "expected.json"), "w") as f:
    json.dump(expected, f, indent=0, sort_keys=True)
    f.write("\n")
