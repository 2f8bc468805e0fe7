"""Writes tests/files/mat with SciPy 1.x and reads it back with SciPy into expected.json.

Run: pip install numpy scipy; python make_mat.py. Written with the versions in expected.json.
"""
import io, json, pathlib, struct, sys
import numpy as np
import scipy
from scipy.io import loadmat, savemat

here = pathlib.Path(__file__).parent / "files" / "mat"
here.mkdir(parents=True, exist_ok=True)
rng = np.random.default_rng(1)
classes = "f8 f4 i1 u1 i2 u2 i4 u4 i8 u8".split()
full = {f"x_{c}": (rng.standard_normal((3, 4)) * 100).astype(c) if c[0] != "u"
        else rng.integers(0, 200, (3, 4)).astype(c) for c in classes}
full["cube"] = rng.standard_normal((2, 3, 4))
full["special"] = np.array([[np.nan, np.inf, -0.0, 5e-324]])
full["empty"] = np.zeros((0, 3))
full["big"] = np.array([[2**64 - 1, 2**63]], "u8")
full["is_open"] = np.array([[True, False, True]])
full["z"] = np.array([[1 + 2j]])
full["title"] = "velocity in m/s"
full["rows"] = np.array(["abc", "xyz"])
full["data"] = {"vel": rng.standard_normal((4, 2)), "units": "m/s", "deep": {"dt": 0.25}}
full["runs"] = np.array([(1.5, np.arange(3.0)), (2.5, np.arange(4.0))], [("dt", "O"), ("vel", "O")])
cell = np.empty((1, 2), object)
cell[0, 0], cell[0, 1] = np.arange(6.0).reshape(2, 3), "text"
full["c"] = cell
full["s"] = scipy.sparse.csc_matrix(np.eye(3))


def swapped_types():
    """A big-endian file by hand, as MATLAB writes doubles that fit in smaller integers."""
    def element(kind, data):
        return struct.pack(">II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    def matrix(name, cls, kind, numbers, shape, flags=0):
        body = element(6, struct.pack(">II", flags << 8 | cls, 0))
        body += element(5, struct.pack(f">{len(shape)}i", *shape))
        body += struct.pack(">HH4s", len(name), 1, name) if len(name) <= 4 else element(1, name)
        return element(14, body + element(kind, numbers.astype(numbers.dtype.newbyteorder(">")).tobytes("F")))

    out = b"MATLAB 5.0 MAT-file, big-endian".ljust(124) + b"\x01\x00MI"
    numbers = np.arange(6).reshape(2, 3)
    out += matrix(b"byte", 6, 2, (40 * numbers).astype("u1"), (2, 3))
    out += matrix(b"short", 6, 3, (numbers - 300).astype("i2"), (2, 3))
    out += matrix(b"word", 7, 4, (numbers + 60000).astype("u2"), (2, 3))
    out += matrix(b"wide", 14, 5, (numbers - 70000).astype("i4"), (2, 3))
    out += matrix(b"same", 6, 9, numbers / 7, (2, 3))
    out += matrix(b"flag", 6, 2, (numbers % 2).astype("u1"), (2, 3), flags=2)
    return out


def version_4(big):
    out = b""
    order = ">" if big else "<"
    for digit, kind in enumerate("f8 f4 i4 i2 u2 u1".split()):
        numbers = (np.arange(6).reshape(2, 3) * 25.5).astype(order + kind)
        name = f"m_{kind}".encode() + b"\0"
        out += struct.pack(order + "5i", 1000 * big + 10 * digit, 2, 3, 0, len(name)) + name
        out += numbers.tobytes("F")
    return out


def hexed(array):
    array = np.asarray(array)
    return {"shape": list(array.shape), "type": array.dtype.newbyteorder("=").str[1:],
            "hex": np.ascontiguousarray(array, array.dtype.newbyteorder("<")).tobytes().hex()}


def walk(path, value, out):
    if isinstance(value, np.ndarray) and value.dtype.names:
        for i, one in enumerate(value.ravel("F"), 1):
            for name in value.dtype.names:
                walk(f"{path}.{name}" if value.size == 1 else f"{path}({i}).{name}", one[name], out)
    elif isinstance(value, np.ndarray) and value.dtype == object:
        for i, one in enumerate(value.ravel("F"), 1):
            walk(f"{path}{{{i}}}", one, out)
    elif scipy.sparse.issparse(value):
        out[path] = {"other": "a sparse matrix"}
    elif value.dtype.kind == "U":
        out[path] = {"text": value.tolist()}
    elif value.dtype.kind == "c":
        out[path] = {"other": "complex numbers"}
    else:
        out[path] = hexed(value)


files = {}
for name, options in {"v5.mat": {}, "v5_compressed.mat": {"do_compression": True}}.items():
    savemat(here / name, full, **options)
flat = {k: v for k, v in full.items()
        if k in ("x_f8", "x_f4", "x_i4", "x_i2", "x_u2", "x_u1", "special", "title", "rows", "z", "s")}
savemat(here / "v4.mat", flat, format="4")
(here / "v5_big.mat").write_bytes(swapped_types())
(here / "v4_big.mat").write_bytes(version_4(True))
(here / "v4_little.mat").write_bytes(version_4(False))
for name in "v5 v5_compressed v5_big v4 v4_big v4_little".split():
    out = {}
    stored = loadmat(here / f"{name}.mat")
    classes = loadmat(here / f"{name}.mat", mat_dtype=name.startswith("v5"))
    for key, value in classes.items():
        if not key.startswith("__"):
            # `mat_dtype` drops imaginary parts.
            walk(key, stored[key] if np.iscomplexobj(stored[key]) else value, out)
    files[f"{name}.mat"] = out
versions = {"python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__}
(here / "expected.json").write_text(json.dumps({"versions": versions, "files": files}, indent=1) + "\n")
