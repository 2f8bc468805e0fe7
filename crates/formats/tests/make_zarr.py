"""Writes the fixtures of Zarr stores, and what zarr-python and xarray read from them.

zarr 3.1.6, numcodecs 0.16.6, xarray 2026.9.0, numpy 2.4.6: `python make_zarr.py` in this folder.
"""
import json, os, shutil, warnings
import numcodecs, numpy as np, xarray, zarr
from zarr import codecs

warnings.simplefilter("ignore")
here = os.path.join(os.path.dirname(os.path.abspath(__file__)), "files", "zarr")
shutil.rmtree(here, ignore_errors=True)
os.makedirs(here)
random = np.random.default_rng(5)
expected = {}
path = lambda name: os.path.join(here, name)

def hexed(values):
    """Hex digits of the numbers, the lowest byte first."""
    values = np.ascontiguousarray(values)
    if values.dtype.kind in "Mm":
        values = values.astype("i8")
    return values.astype(values.dtype.newbyteorder("<")).tobytes().hex()

def keep(name):
    """What zarr-python reads: type, shape, names of the dimensions, bytes."""
    root = zarr.open(path(name), mode="r")
    arrays = [("/" + name.split(".")[0], root)] if isinstance(root, zarr.Array) else \
        [("/" + key, array) for key, array in root.members(max_depth=None) if isinstance(array, zarr.Array)]
    expected[name] = {}
    for key, array in arrays:
        if array.dtype.kind not in "biufMm":
            continue
        v3 = array.metadata.zarr_format == 3
        names = array.metadata.dimension_names if v3 else array.attrs.get("_ARRAY_DIMENSIONS")
        kind = "i" if array.dtype.kind in "Mm" else array.dtype.kind
        expected[name][key] = {
            "type": f"{kind}{array.dtype.itemsize}",
            "shape": array.shape, "dimensions": list(names or [None] * array.ndim),
            "hex": hexed(array[...])}

def store(name, version):
    return zarr.open_group(path(name), mode="w", zarr_format=version)

v = lambda *shape: random.standard_normal(shape)
def add(group, name, data, chunks, dims=None, **more):
    if group.metadata.zarr_format == 3:
        more["dimension_names"] = dims
    elif dims:
        more["attributes"] = {"_ARRAY_DIMENSIONS": dims, **more.get("attributes", {})}
    order = more.pop("order", None)
    if order:
        more["order"] = order
    array = group.create_array(name, shape=data.shape, dtype=data.dtype, chunks=chunks, **more)
    array[...] = data
    return array

# Version 2: compressors, orders, byte orders, separators, filters.
g = store("v2.zarr", 2)
g.attrs["title"] = "a title"
blosc = lambda kind: numcodecs.Blosc(cname=kind, clevel=5, shuffle=numcodecs.Blosc.SHUFFLE)
for kind in ["lz4", "zstd", "zlib", "snappy", "blosclz", "lz4hc"]:
    if kind in numcodecs.blosc.list_compressors():
        add(g, f"blosc_{kind}", v(7, 6), (4, 6), ["time", "x"], compressors=blosc(kind))
add(g, "blosc_bits", v(7, 6).astype("f4"), (4, 6), compressors=numcodecs.Blosc(shuffle=numcodecs.Blosc.BITSHUFFLE))
add(g, "gzip", v(7, 6), (4, 6), compressors=numcodecs.GZip(5))
add(g, "zlib", v(7, 6), (3, 4), compressors=numcodecs.Zlib(5))
add(g, "zstd", v(7, 6), (4, 6), compressors=numcodecs.Zstd(5))
add(g, "raw", v(7, 6), (4, 6), compressors=None)
add(g, "fortran", v(7, 6), (4, 6), order="F")
add(g, "big", v(7, 6).astype(">f8"), (4, 6))
add(g, "big_short", random.integers(-99, 99, (5,)).astype(">i2"), (2,), compressors=None)
add(g, "nested_keys", v(7, 6), (4, 6), chunk_key_encoding={"name": "v2", "separator": "/"})
add(g, "shuffled", v(7, 6), (4, 6), filters=[numcodecs.Shuffle(8)], compressors=numcodecs.Zlib(5))
add(g, "bz2", v(4, 3), (4, 3), compressors=numcodecs.BZ2())
add(g, "delta", random.integers(0, 9, (12,)), (5,), filters=[numcodecs.Delta("i8")])
add(g, "complex", v(3) + 1j * v(3), (3,))
add(g, "texts", np.array(["a", "bc"]), (2,))
add(g, "when", np.array(["2026-01-01T00:00:00.5", "NaT"], "M8[ms]"), (2,))
add(g, "lasts", np.array([5, 7], "m8[us]"), (2,))
for dtype in ["bool", "i1", "u1", "u2", "i4", "u4", "i8", "u8", "f2", "f4"]:
    add(g, f"of_{dtype}", random.integers(0, 2 if dtype == "bool" else 100, (5,)).astype(dtype), (5,))
add(g.create_group("inner"), "deep", v(3, 2), (2, 2))
unwritten = g.create_array("unwritten", shape=(5, 4), chunks=(2, 2), dtype="f4", fill_value=-7.5)
unwritten[0:2, 0:2] = 1.25
keep("v2.zarr")

# Version 3: shards, codecs, names of dimensions.
g = store("v3.zarr", 3)
g.attrs["title"] = "a title"
add(g, "plain", v(7, 6), (3, 4), ["time", "x"])
add(g, "raw", v(7, 6), (4, 6), [None, "x"], compressors=None)
add(g, "gzip", v(7, 6), (4, 6), compressors=codecs.GzipCodec(level=5))
add(g, "blosc", v(7, 6), (4, 6), compressors=codecs.BloscCodec(cname="lz4", typesize=8, shuffle="shuffle"))
add(g, "crc", v(7, 6), (4, 6), compressors=[codecs.ZstdCodec(level=3), codecs.Crc32cCodec()])
add(g, "big", v(7, 6), (4, 6), compressors=None, serializer=codecs.BytesCodec(endian="big"))
add(g, "transposed", v(4, 6, 5), (3, 4, 2), filters=[codecs.TransposeCodec(order=(2, 0, 1))])
add(g, "sharded", v(13, 10), (2, 5), ["time", "x"], shards=(6, 10))
add(g, "sharded_raw", v(13, 10).astype("f4"), (2, 5), shards=(6, 10), compressors=None)
part = g.create_array("sharded_in_part", shape=(8, 4), chunks=(2, 2), shards=(4, 4), dtype="f8", fill_value=np.nan)
part[4:6, 0:2] = v(2, 2)
add(g, "scalar", np.array(2.5), ())
add(g, "slashes", v(4), (2,), chunk_key_encoding={"name": "default", "separator": "."})
add(g, "when", np.array(["2026-01-01T00:00:00.5", "2026-01-02"], "M8[ns]"), (2,))
add(g, "complex", (v(3) + 1j * v(3)).astype("c8"), (3,))
texts = g.create_array("texts", shape=(2,), chunks=(2,), dtype=str)
texts[...] = np.array(["a", "bc"])
for dtype in ["bool", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f2", "f4"]:
    add(g, f"of_{dtype}", random.integers(0, 2 if dtype == "bool" else 100, (5,)).astype(dtype), (5,))
add(g.create_group("inner"), "deep", v(3, 2), (2, 2))
unwritten = g.create_array("unwritten", shape=(5, 4), chunks=(2, 2), dtype="i2", fill_value=-7)
unwritten[2:4, 2:4] = 12
keep("v3.zarr")

zarr.create_array(path("alone.zarr"), data=v(5, 4), chunks=(2, 2))
keep("alone.zarr")

# As xarray encodes: packed, gaps, times, scalars, coordinates; what it decodes.
n, m = 9, 6
field = v(n, m)
field[2, 3] = np.nan
packed = field.copy()
data = xarray.Dataset(
    {"velocity": (("time", "x"), field, {"units": "m/s", "long_name": "velocity of the beads"}),
     "packed": (("time", "x"), packed, {"units": "m/s"}),
     "counts": (("time", "x"), random.integers(1, 9, (n, m)).astype("f4")),
     "level": ((), 3.5)},
    {"time": ("time", np.datetime64("2026-03-01T12:00", "ns") + np.arange(n) * np.timedelta64(250, "us")),
     "x": ("x", 0.5 + 0.125 * np.arange(m), {"units": "m"}),
     "name": ("x", [f"s{i}" for i in range(m)])},
    {"title": "a field", "valid": float("nan"), "list": [1, 2.5]})
data["counts"][1, 1] = np.nan
for version in [2, 3]:
    name = f"xarray{version}.zarr"
    encoding = {"packed": {"dtype": "i2", "scale_factor": 0.001, "add_offset": 0.25, "_FillValue": -32768},
                "counts": {"_FillValue": np.float32(-1.0)},
                "velocity": {"chunks": (4, 3)}}
    data.to_zarr(path(name), mode="w", zarr_format=version, encoding=encoding, consolidated=True)
    keep(name)
    opened = xarray.open_zarr(path(name))
    # Units and fills are in `readers/facts.txt`.
    for key in ["velocity", "packed", "counts"]:
        expected[name]["/" + key]["decoded"] = hexed(opened[key].values.astype("f8"))

# Zeros that xarray takes for gaps, since the store says that they fill; without names it does not open it.
g = store("zeros2.zarr", 2)
add(g, "v", np.array([[0.0, 1.0], [2.0, 0.0]]), (2, 2), ["t", "x"], fill_value=0.0)
keep("zeros2.zarr")
gaps = np.isnan(xarray.open_zarr(path("zeros2.zarr"), consolidated=False)["v"].values)
assert gaps.sum() == 2
add(g, "nameless", np.array([[0.0, 1.0], [2.0, 0.0]]), (2, 2), fill_value=0.0)

with open(path("expected.json"), "w") as f:
    json.dump(expected, f)
