#!/usr/bin/env python3
"""Reading a field of 500 MB beside h5py and npTDMS, in one run.

Usage: run.py [FOLDER]

Needs Linux, cargo, and the Python packages h5py, npTDMS and numpy. Writes field_contiguous.h5, field_gzip.h5 and
field.tdms (16384 x 8192 samples in single precision, noise of 12 bits) to FOLDER, which they need 1.5 GB of, and
reads each by `read_field.rs` and by its peer, round after round, with the pages in memory. A
time is that of opening the file and summing all samples; `cascade` on one thread and on all. Prints medians and,
for machines that do other work, the least times.
"""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import h5py
import nptdms
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
TIMES, SITES = 16384, 8192
# Rounds, and readings in each, of which the fastest counts.
ROUNDS, READINGS = 5, 3


def write(folder):
    rng = np.random.default_rng(1)
    values = (rng.integers(-2048, 2048, (TIMES, SITES)) / 1024).astype(np.float32)
    for name, how in [("contiguous", {}), ("gzip", {"chunks": (256, 512), "compression": "gzip", "compression_opts": 4})]:
        with h5py.File(folder / f"field_{name}.h5", "w") as file:
            file.create_dataset("velocity", data=values, **how)
    with nptdms.TdmsWriter(folder / "field.tdms") as file:
        file.write_segment([nptdms.ChannelObject("velocity", f"{j:04}", values[:, j]) for j in range(SITES)])


def by_h5py(path):
    with h5py.File(path) as file:
        return file["velocity"][...].sum(dtype=np.float64)


def by_nptdms(path):
    with nptdms.TdmsFile.open(path) as file:
        return sum(channel[:].sum(dtype=np.float64) for channel in file["velocity"].channels())


def of_cascade(program, path, threads):
    environment = os.environ | {"RAYON_NUM_THREADS": str(threads)}
    said = subprocess.run([program, path], env=environment, check=True, capture_output=True, text=True).stdout
    rows = [line.split() for line in said.splitlines()]
    return min(float(row[0]) for row in rows[:READINGS]), float(rows[0][1])


def of_peer(read, path):
    times = []
    for _ in range(READINGS):
        begun = time.perf_counter()
        found = read(path)
        times.append(time.perf_counter() - begun)
    return min(times), found


def main():
    subprocess.run(["cargo", "build", "--release", "--example", "read_field"], cwd=ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release/examples/read_field"
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else tempfile.mkdtemp())
    if not (folder / "field.tdms").exists():
        write(folder)
    print(f"{TIMES} x {SITES} f32, {4 * TIMES * SITES / 1e6:.0f} MB, {os.cpu_count()} cores")
    for name, peer, read in [
        ("field_contiguous.h5", "h5py", by_h5py),
        ("field_gzip.h5", "h5py", by_h5py),
        ("field.tdms", "npTDMS", by_nptdms),
    ]:
        path, times = folder / name, {peer: [], "1 thread": [], "all": []}
        for _ in range(ROUNDS):
            seconds, expected = of_peer(read, path)
            times[peer].append(seconds)
            for label, threads in [("1 thread", 1), ("all", os.cpu_count())]:
                seconds, found = of_cascade(program, path, threads)
                times[label].append(seconds)
                assert abs(found - expected) < 1e-9 * TIMES * SITES, (found, expected)
        medians = {label: statistics.median(of) for label, of in times.items()}
        least = {label: min(of) for label, of in times.items()}
        said = ", ".join(f"{label} {medians[label]:.3f} s ({least[label]:.3f})" for label in times)
        ratios = " ".join(f"{of[peer] / of['1 thread']:.2f} {of[peer] / of['all']:.2f}" for of in (medians, least))
        print(f"{name}: {said}; {peer} over 1 thread and all, medians and least: {ratios}", flush=True)


main()
