#!/usr/bin/env python3
"""A field larger than the memory allowed: time and peak memory of `cascade analyze`.

    cargo build --release
    target/peers/bin/python benches/large_field.py --gib 1 --memory 300MB

Makes a field of white noise of 256 sites (kept as target/large_field.npy), analyses it with all
results and no figures, and prints wall time, peak resident memory and bytes of field a second.
Needs NumPy (benches/peers/install.sh) and about five times the field's size on disk.
"""

import argparse
import os
import pathlib
import shutil
import subprocess
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
SITES = 256
ROWS = 1 << 16


def make(path, gib):
    times = int(gib * 2**30 / 8 / SITES)
    field = np.lib.format.open_memmap(path, mode="w+", dtype="<f8", shape=(times, SITES))
    noise = np.random.default_rng(1)
    for start in range(0, times, ROWS):
        rows = min(ROWS, times - start)
        field[start : start + rows] = noise.standard_normal((rows, SITES))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gib", type=float, default=1.0)
    parser.add_argument("--memory", default="300MB")
    parser.add_argument("--make", type=pathlib.Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.make:
        return make(asked.make, asked.gib)
    field = ROOT / "target" / "large_field.npy"
    out = ROOT / "target" / "large_field"
    # By a process of its own: a child's peak memory counts from that of its parent.
    subprocess.run([sys.executable, __file__, "--make", field, "--gib", str(asked.gib)], check=True)
    command = [ROOT / "target/release/cascade", "analyze", field, "--out", out]
    command += ["--memory", asked.memory, "--figures", "none", "--quiet"]
    start = time.monotonic()
    child = subprocess.Popen(command)
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - start
    peak, size = usage.ru_maxrss * 1024, field.stat().st_size
    print(f"field {size / 1e6:.0f} MB, allowed {asked.memory}, exit status {status}")
    print(f"peak {peak / 1e6:.0f} MB, {seconds:.1f} s, {size / seconds / 1e6:.0f} MB of field a second")
    field.unlink()
    shutil.rmtree(out)


if __name__ == "__main__":
    main()
