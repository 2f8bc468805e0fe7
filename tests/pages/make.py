#!/usr/bin/env python3
"""Makes pages of fields that are hard to draw (amplitudes, shapes, units, gaps) and of the results of
every command that ends with a page.

Usage: make.py PROGRAM DIRECTORY
"""

import pathlib
import subprocess
import sys

import numpy as np

program, directory = (pathlib.Path(arg).resolve() for arg in sys.argv[1:])
directory.mkdir(parents=True, exist_ok=True)
root = pathlib.Path(__file__).resolve().parents[2]

t = np.arange(800)[:, None] * 1e-3
x = np.arange(40)[None, :] * 0.01
pulse = np.exp(-(((t - 0.1 - x / 2) / 0.01) ** 2)) * np.cos(400 * (t - x / 2))
noise = np.random.default_rng(1).normal
gaps = pulse.copy()
gaps[300:320, 5] = np.nan
gaps[:, 7] = np.nan
step = np.zeros((500, 30))
step[200:, :] = 1.0
SI = ["--dt", "1ms", "--dx", "1cm", "--unit", "m/s"]
FIELDS = {
    "si-1": (pulse, SI),
    "si-1mm": (1e-3 * pulse, SI),
    "si-1um": (1e-6 * pulse, SI),
    "faint": (1e-300 * pulse, []),
    "loud": (1e300 * pulse, []),
    "single-precision": (pulse.astype(np.float32), []),
    "constant": (np.ones((300, 20)), []),
    "empty": (np.zeros((300, 20)), []),
    "step": (step, []),
    "one-site": (pulse[:, :1], []),
    "one-time": (pulse[200:201, :], []),
    "two-samples": (pulse[200:202, :2], []),
    "gaps": (gaps, ["--gaps", "mask"]),
    "noise": (noise(size=(1000, 50)), []),
    "long": (noise(size=(200_000, 4)), ["--dt", "10us"]),
    "wide": (noise(size=(64, 4000)), ["--layout", "time-site"]),
    "offset": (1e6 + pulse, []),
    "sine": (np.sin(2 * np.pi * 50 * t - 60 * x), SI),
}


def run(*arguments):
    done = subprocess.run([program, *map(str, arguments)], cwd=directory, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, arguments))}: exit {done.returncode}\n{done.stderr}")


for name, (values, options) in FIELDS.items():
    np.save(directory / f"{name}.npy", values)
    run("analyze", f"{name}.npy", "--out", name, "--force", *options)
run("analyze", root / "examples/data/lattice_impact.npy", "--out", "lattice", "--force")
run("simulate", root / "examples/scenes/dimer.toml", "--out", "dimer.npz", "--force")
run("analyze", "dimer.npz", "--out", "dimer", "--force")
run("budget", "dimer.npz", "--out", "dimer-budget", "--force")
run("simulate", root / "examples/scenes/dimer.toml", "--stiffness-ratio", "2.4", "--out", "dispersive.npz", "--force")
run("compare", "dimer.npz", "dispersive.npz", "--out", "compared", "--force")
run("attenuate", "--ratios", "2.4,4.9272", "--bodies", "20", "--target", "0.5", "--out", "attenuated")
run("attenuate", "--against", "stiffness_ratio=1:40:9log", "--sites", "21", "--out", "transmitted")
run("sweep", "--vary", "stiffness_ratio=1:10:8", "--vary", "striker_velocity=0.5,1", "--sites", "20", "--samples", "65", "--end-time", "40", "--out", "swept")
run("localize", "--order", "1..4", "--direct", "--cells", "40", "--out", "localized", "--force")
run("localize", "--profile", "2", "--out", "wave", "--force")
run("localize", "--launch", "2", "--cells", "60", "--out", "launched", "--force")
run("simulate", root / "examples/scenes/fput.toml", "--end-time", "800", "--samples", "1024", "--out", "fput.npz", "--force")
run("triads", "fput.npz", "--out", "of-triads", "--force")
lattice = root / "examples/data/lattice_impact.npy"
for name, *words in [
    ("spectrum", "noise.npy"),
    ("spacetime", "noise.npy", "--along", "both"),
    ("coherence", "noise.npy"),
    ("bicoherence", "noise.npy", "--segment", "64"),
    ("transfer", "long.npy", "--transfer", "1", "--segment", "64"),
    ("modes", "noise.npy", "--segment", "64"),
    ("increments", "noise.npy"),
    ("slope", "noise.npy", "--band", "0.5:2.5"),
    ("ridges", lattice),
]:
    command = {"spacetime": "spectrum", "transfer": "bicoherence"}.get(name, name)
    run(command, *words, "--out", f"of-{name}", "--force")
print(f"{len(list(directory.glob('*/report.html')))} pages in {directory}")
