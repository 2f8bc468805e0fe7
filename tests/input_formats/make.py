"""Writes numpy.txt: one file a line, its name and its bytes in hexadecimal."""

import io

import numpy as np

lines = []


def add(name, write):
    buffer = io.BytesIO()
    write(buffer)
    lines.append(f"{name} {buffer.getvalue().hex()}")


def field(dtype):
    index = np.arange(15).reshape(5, 3)
    if dtype == "b1":
        return index % 2 == 1
    return index if dtype[0] == "u" else index - 7


for dtype in "f8 f4 f2 i1 i2 i4 i8 u1 u2 u4 u8 b1".split():
    for order in "<>":
        for fortran in (False, True):
            array = np.array(field(dtype), dtype=order + dtype, order="CF"[fortran])
            name = f"{dtype}-{'little' if order == '<' else 'big'}-{'CF'[fortran]}"
            add(name, lambda f: np.save(f, array))

for version in (1, 2, 3):
    array = field("f8").astype("<f8")
    add(f"version-{version}", lambda f: np.lib.format.write_array(f, array, (version, 0)))

add("record", lambda f: np.save(f, np.arange(4.0)))
add("halves", lambda f: np.save(f, np.array(
    [0.0, -0.0, 1.0, -2.5, 65504.0, 6e-8, 6.1e-5, np.inf, -np.inf, np.nan], dtype="<f2")))
run = {
    "time": 0.5 + 0.25 * np.arange(5),
    "velocity": field("f8").astype(float),
    "displacement": field("f8") * 2.0,
    "mass": np.ones(3),
}
add("run-stored", lambda f: np.savez(f, **run))
add("run-deflated", lambda f: np.savez_compressed(f, **run))
add("placed", lambda f: np.savez(f, v=field("f8").astype(float), position=np.array([2.0, 4.0, 6.0])))
add("two", lambda f: np.savez(f, a=field("f8"), b=field("f4"), n=np.array(3)))

with open("numpy.txt", "w") as out:
    out.write(f"# Written by make.py with NumPy {np.__version__}.\n")
    out.write("\n".join(lines) + "\n")
