#!/usr/bin/env python3
"""Writes random fields as NumPy and pandas write them, and beside each what these read back.

Usage: random_files.py DIRECTORY SEED COUNT

`NAME.f64` holds the values as little-endian doubles, times first. The list of names, each with its
number of times and of sites, goes to standard output.
"""

import pathlib
import sys
import warnings

import numpy as np

try:
    import pandas
except ImportError:
    pandas = None

directory, seed, count = pathlib.Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
# Random bits are now and then a NaN that warns; old formats and options warn too.
warnings.simplefilter("ignore")
rng = np.random.default_rng(seed)
KINDS = ["f8", "f4", "f2", "i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", "b1"]


def values(kind, shape):
    """Random bits: any value that the kind has."""
    size = np.dtype(kind).itemsize * int(np.prod(shape))
    drawn = rng.integers(0, 256, size, dtype=np.uint8)
    if kind == "b1":
        drawn &= 1
    return drawn.view(kind).reshape(shape)


def array(shape):
    kind = rng.choice(KINDS)
    made = values(kind, shape).astype(np.dtype(kind).newbyteorder(rng.choice(["<", ">"])))
    return np.asarray(made, order=rng.choice(["C", "F"]))


def npy(path, shape):
    with open(path, "wb") as file:
        version = [(1, 0), (2, 0), (3, 0), None][rng.integers(4)]
        np.lib.format.write_array(file, array(shape), version=version)
    return np.load(path)


def npz(path, shape):
    save = rng.choice([np.savez, np.savez_compressed])
    save(path, velocity=array(shape))
    return np.load(path)["velocity"]


def text(path, shape):
    """Numbers with any number of digits, and any exponent of doubles that are not subnormal."""
    made = rng.normal(size=shape) * 10.0 ** rng.integers(-290, 290, size=shape)
    digits = rng.integers(0, 18)
    delimiter = rng.choice([",", ";", "\t", " "])
    np.savetxt(path, made, fmt=f"%.{digits}e", delimiter=delimiter, newline=rng.choice(["\n", "\r\n"]))
    return np.loadtxt(path, delimiter=delimiter, ndmin=2)


def table(path, shape):
    """A table with names and with gaps, as pandas writes it."""
    frame = pandas.DataFrame(rng.normal(size=shape) * 10.0 ** rng.integers(-9, 9, size=shape))
    frame = frame.mask(rng.random(shape) < 0.1)
    # A row of nothing but gaps would be an empty line of one column.
    frame.iloc[:, 0] = rng.normal(size=shape[0])
    frame.columns = [f"site {n}" for n in range(shape[1])]
    separator = rng.choice([",", ";", "\t"])
    frame.to_csv(path, index=False, sep=separator, na_rep=rng.choice(["", "nan", "NaN"]))
    return pandas.read_csv(path, sep=separator, float_precision="round_trip").to_numpy()


writers = [(npy, "npy"), (npz, "npz"), (text, "csv")] + ([(table, "csv")] if pandas else [])
for n in range(count):
    write, extension = writers[rng.integers(len(writers))]
    shape = (int(rng.integers(2, 40)), int(rng.integers(2, 12)))
    name = f"{write.__name__}-{n}.{extension}"
    read = write(directory / name, shape).astype("<f8")
    read.tofile(directory / f"{name}.f64")
    print(name, *shape)
