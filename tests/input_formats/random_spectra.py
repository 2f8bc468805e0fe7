#!/usr/bin/env python3
"""Writes random fields, or compares spectra of them with sums in NumPy's long double.

Usage: random_spectra.py make DIRECTORY SEED COUNT
       random_spectra.py compare DIRECTORY

`make` lists the names of the fields with their layouts and shapes. `compare` reads the results
`NAME.result` with unit steps, `energy` as the scaling, and prints the largest difference of a temporal and of a space-time
spectrum, relative to its peak. Transforms are sums over all samples, term by term: no algorithm is
shared with the program.
"""

import json
import pathlib
import sys

import numpy as np

LONG = np.longdouble
# The double next to pi, and the rest.
PI = LONG(3.141592653589793116) + LONG(1.2246467991473532e-16)


def make(directory, seed, count):
    rng = np.random.default_rng(seed)
    for n in range(count):
        times, sites = int(rng.integers(1, 201)), int(rng.integers(1, 21))
        field = rng.normal(size=(times, sites)) * 10.0 ** rng.uniform(-300, 300)
        layout = rng.choice(["time-site", "site-time"])
        np.save(directory / f"{n}-{layout}.npy", field if layout == "time-site" else field.T)
        print(f"{n}-{layout}", layout, f"{times} x {sites}")


def transform(field, sign):
    """Sums over the first axis of real and imaginary parts."""
    count = field[0].shape[0]
    # Products are reduced as integers, so that angles are exact but for one rounding.
    angle = 2 * PI * (np.outer(np.arange(count), np.arange(count)) % count).astype(LONG) / count
    c, s = np.cos(angle), sign * np.sin(angle)
    return c @ field[0] - s @ field[1], s @ field[0] + c @ field[1]


def folded(power, times):
    """One-sided along the first axis."""
    power = power[: times // 2 + 1].copy()
    power[1 : (times + 1) // 2] *= 2
    return power


def compare(directory):
    largest = {"temporal_spectrum": 0.0, "spacetime_spectrum": 0.0}
    for path in directory.glob("*.result"):
        archive = np.load(path / "spectra.npz")
        summary = json.loads((path / "summary.json").read_text())
        field = np.load(path.with_suffix(".npy"))
        field = field if path.stem.endswith("time-site") else field.T
        times, sites = field.shape
        # Squares of 1e300 are stored in the square of this unit.
        field = field.astype(LONG) / LONG(summary["accuracy"]["amplitude_unit"])
        real, imaginary = transform((field, np.zeros_like(field)), -1)
        expected = {"temporal_spectrum": folded(real**2 + imaginary**2, times)}
        real, imaginary = (part.T for part in transform((real.T, imaginary.T), 1))
        # Wavenumbers ascend.
        power = np.fft.fftshift(real**2 + imaginary**2, axes=1) / (2 * PI)
        expected["spacetime_spectrum"] = folded(power, times)
        for name, of in expected.items():
            found = archive[name]
            assert found.shape == of.shape, f"{path.stem}: {found.shape}, not {of.shape}"
            error = float(np.max(np.abs(found.astype(LONG) - of)) / np.max(of))
            # A NaN, too, is the largest.
            largest[name] = error if not error <= largest[name] else largest[name]
    print(*(f"{value:.2e}" for value in largest.values()))


if __name__ == "__main__":
    directory = pathlib.Path(sys.argv[2])
    if sys.argv[1] == "make":
        make(directory, int(sys.argv[3]), int(sys.argv[4]))
    else:
        compare(directory)
