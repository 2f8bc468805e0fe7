#!/usr/bin/env python3
"""A field larger than the memory allowed: time, peak memory and accuracy of `cascade analyze`.

    cargo build --release
    target/peers/bin/python benches/large_field.py --gib 1 --memory 300MB
    target/peers/bin/python benches/large_field.py --gib 12 --sites 4096 --memory 2GiB \
        --only temporal,spatial,spacetime

Makes a field of white noise (target/large_field.npy), analyses it without figures, with
all results or `--only` some, and prints wall time, peak resident memory, bytes of field a second, the
time of reading the file once and of writing a file as large as the results, and how far one
record's and the last profile's spectra are from SciPy's. Needs NumPy and SciPy
(benches/peers/install.sh) and about four times the field's size on disk.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time
import zipfile

import numpy as np
import scipy.fft

ROOT = pathlib.Path(__file__).resolve().parent.parent
ROWS = 1 << 12


def make(path, gib, sites):
    times = int(gib * 2**30 / 8 / sites)
    field = np.lib.format.open_memmap(path, mode="w+", dtype="<f8", shape=(times, sites))
    noise = np.random.default_rng(1)
    for start in range(0, times, ROWS):
        rows = min(ROWS, times - start)
        field[start : start + rows] = noise.standard_normal((rows, sites))


def read_once(path):
    buffer = bytearray(8 << 20)
    start = time.monotonic()
    with open(path, "rb", buffering=0) as file:
        while file.readinto(buffer):
            pass
    return time.monotonic() - start


def write_once(path, size):
    buffer = memoryview(os.urandom(8 << 20))
    start = time.monotonic()
    with open(path, "wb", buffering=0) as file:
        while size:
            size -= file.write(buffer[: min(size, len(buffer))])
    seconds = time.monotonic() - start
    path.unlink()
    return seconds


def member(path, name):
    """An array of an archive without compression, mapped."""
    with zipfile.ZipFile(path) as archive, open(path, "rb") as file:
        file.seek(archive.getinfo(name + ".npy").header_offset)
        header = file.read(30)
        file.seek(int.from_bytes(header[26:28], "little") + int.from_bytes(header[28:30], "little"), 1)
        np.lib.format.read_magic(file)
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)
        return np.memmap(path, dtype, "r", file.tell(), shape)


def compare(path, archive, only):
    field = np.load(path, mmap_mode="r")
    asked = only.split(",") if only else ["temporal", "spatial", "spacetime"]

    def apart(found, transform, axis_length, per_bin=1.0):
        power = np.abs(transform) ** 2 * per_bin
        power[1 : len(power) - (axis_length % 2 == 0)] *= 2
        return np.max(np.abs(found - power)) / np.max(power)

    if "temporal" in asked:
        found = member(archive, "temporal_spectrum")[:, 100]
        print(f"temporal spectrum of site 100: {apart(found, scipy.fft.rfft(field[:, 100]), len(field)):.1e}")
    if "spatial" in asked:
        found = member(archive, "spatial_spectrum")[-1]
        print(f"spatial spectrum of the last time: {apart(found, scipy.fft.rfft(field[-1]), field.shape[1], 0.5 / np.pi):.1e}")
    if "spacetime" in asked:
        # One wavenumber, k = 0: the spectrum of the sum over sites.
        total = np.zeros(len(field))
        for start in range(0, len(field), ROWS):
            total[start : start + ROWS] = field[start : start + ROWS].sum(axis=1)
        found = member(archive, "spacetime_spectrum")[:, field.shape[1] // 2]
        print(f"space-time spectrum at k = 0: {apart(found, scipy.fft.rfft(total), len(field), 0.5 / np.pi):.1e}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gib", type=float, default=1.0)
    parser.add_argument("--sites", type=int, default=256)
    parser.add_argument("--memory", default="300MB")
    parser.add_argument("--only", help="results, separated by commas; all by default")
    parser.add_argument("--make", type=pathlib.Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.make:
        return make(asked.make, asked.gib, asked.sites)
    field = ROOT / "target" / "large_field.npy"
    out = ROOT / "target" / "large_field"
    # By a process of its own: a child's peak memory counts from that of its parent.
    subprocess.run([sys.executable, __file__, "--make", field, "--gib", str(asked.gib), "--sites", str(asked.sites)], check=True)
    command = [ROOT / "target/release/cascade", "analyze", field, "--out", out]
    command += ["--memory", asked.memory, "--figures", "none", "--quiet"]
    for result in asked.only.split(",") if asked.only else []:
        command += ["--only", result]
    reading = read_once(field)
    start = time.monotonic()
    child = subprocess.Popen(command)
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - start
    peak, size = usage.ru_maxrss * 1024, field.stat().st_size
    print(f"field {size / 1e6:.0f} MB, {asked.sites} sites, allowed {asked.memory}, exit status {status}")
    print(f"peak {peak / 1e6:.0f} MB, {seconds:.1f} s, {size / seconds / 1e6:.0f} MB of field a second")
    print(f"reading the file once: {reading:.1f} s, {size / reading / 1e6:.0f} MB a second")
    if status == 0:
        compare(field, out / "spectra.npz", asked.only)
    results = sum(path.stat().st_size for path in out.glob("*"))
    field.unlink()
    shutil.rmtree(out, ignore_errors=True)
    if status == 0:
        writing = write_once(field, results)
        print(f"writing a file as large as the results: {writing:.1f} s, {results / writing / 1e6:.0f} MB a second")


if __name__ == "__main__":
    main()
