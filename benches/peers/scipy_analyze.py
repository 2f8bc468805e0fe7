"""The spectra of `cascade analyze` with its defaults, as NumPy and SciPy compute them, timed.

From numpy.load to four arrays, named and scaled as in spectra.npz:

temporal_spectrum       (frequency, site)       |X|^2 dt^2, one-sided
spatial_spectrum        (time, wavenumber)      |X|^2 dx^2 / (2 pi), one-sided
spacetime_spectrum      (frequency, wavenumber) |X|^2 dt^2 dx^2 / (2 pi), one-sided in f,
                        wavenumbers of both signs, ascending, positive towards +x
kinetic_flux_surrogate  (time, wavenumber)      -d/dt sum_{|k'| <= k} E_K(k', t)

The field is (time, site); dt and dx come from the sidecar beside it, else they are 1.
Prints one line of JSON: seconds of each run and their median.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import time
import tomllib

import numpy
import scipy
import scipy.fft


def fold(spectrum, n, axis):
    """Counts both signs of every bin but 0 and, for even n, n / 2."""
    doubled = numpy.swapaxes(spectrum, 0, axis)[1 : (n + 1) // 2]
    doubled *= 2
    return spectrum


def power(transform):
    return transform.real**2 + transform.imag**2


def with_fft(v, dt, dx, wanted):
    """Bare transforms; the one along time is made once and serves two spectra."""
    n, m = v.shape
    spectra = {}
    if "time" in wanted or "spacetime" in wanted:
        along_time = scipy.fft.rfft(v, axis=0)
    if "time" in wanted:
        spectra["time"] = fold(power(along_time) * dt**2, n, 0)
    if "space" in wanted:
        along_space = scipy.fft.rfft(v, axis=1)
        spectra["space"] = fold(power(along_space) * (dx**2 / (2 * numpy.pi)), m, 1)
    if "spacetime" in wanted:
        both = scipy.fft.fft(along_time, axis=1, overwrite_x=True)
        spectra["spacetime"] = spacetime(both, n, m, dt, dx)
    return spectra


def with_signal(v, dt, dx, wanted):
    """scipy.signal.periodogram along each axis, rfftn over both."""
    n, m = v.shape
    spectra = {}
    if "time" in wanted:
        _, spectra["time"] = scipy.signal.periodogram(v, 1 / dt, detrend=False, axis=0)
        spectra["time"] *= n * dt
    if "space" in wanted:
        _, spectra["space"] = scipy.signal.periodogram(v, 2 * numpy.pi / dx, detrend=False, axis=1)
        spectra["space"] *= m * dx
    if "spacetime" in wanted:
        both = scipy.fft.rfftn(v, axes=(1, 0))
        spectra["spacetime"] = spacetime(both, n, m, dt, dx)
    return spectra


def spacetime(transform, n, m, dt, dx):
    toward_plus_x = -numpy.arange(-(m // 2), m - m // 2) % m
    spectrum = power(transform)[:, toward_plus_x]
    spectrum *= dt**2 * dx**2 / (2 * numpy.pi)
    return fold(spectrum, n, 0)


def flux(spatial, m, dt, dx):
    """Central differences in time, of second order at the ends too."""
    energy = numpy.cumsum(spatial * (0.5 * 2 * numpy.pi / (m * dx)), axis=1)
    return -numpy.gradient(energy, dt, axis=0, edge_order=2)


def load(path):
    sidecar = path.with_suffix(".toml")
    axes = tomllib.loads(sidecar.read_text()) if sidecar.exists() else {}
    v = numpy.load(path).astype(numpy.float64, copy=False)
    return v, axes.get("dt", 1.0), axes.get("dx", 1.0)


def analyze(path, method, out):
    v, dt, dx = load(path)
    spectra = method(v, dt, dx, ("time", "space", "spacetime"))
    arrays = {
        "temporal_spectrum": spectra["time"],
        "spatial_spectrum": spectra["space"],
        "spacetime_spectrum": spectra["spacetime"],
        "kinetic_flux_surrogate": flux(spectra["space"], v.shape[1], dt, dx),
    }
    if out is not None:
        numpy.savez(out, **arrays)


def timed(run, count):
    seconds = []
    for _ in range(count):
        start = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - start)
    return seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("field", type=pathlib.Path)
    parser.add_argument("--with", dest="method", choices=("fft", "signal"), default="fft")
    parser.add_argument("--only", choices=("time", "space", "spacetime"),
                        help="time one spectrum of a field in memory")
    parser.add_argument("--workers", type=int, default=1, help="threads of scipy.fft")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--process", action="store_true", help="time whole processes")
    parser.add_argument("--out", type=pathlib.Path, help="write the arrays to this .npz")
    asked = parser.parse_args()

    if asked.process:
        command = [sys.executable, __file__, asked.field, "--runs", "1"]
        command += ["--with", asked.method, "--workers", str(asked.workers)]
        command += ["--out", asked.out] if asked.out else []
        run = lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    else:
        method = {"fft": with_fft, "signal": with_signal}[asked.method]
        run = lambda: analyze(asked.field, method, asked.out)
        if asked.only:
            v, dt, dx = load(asked.field)
            run = lambda: method(v, dt, dx, (asked.only,))
    with scipy.fft.set_workers(asked.workers):
        seconds = timed(run, asked.runs)
    record = {
        "field": asked.field.name,
        "method": asked.method,
        "only": asked.only,
        "workers": asked.workers,
        "timed": "process" if asked.process else "call",
        "writes": asked.out is not None,
        "median_s": statistics.median(seconds),
        "runs_s": seconds,
        "python": sys.version.split()[0],
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
    }
    print(json.dumps(record))


main()
