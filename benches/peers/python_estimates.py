"""Estimates of the Python package beside SciPy, nitime, pybispectra, NumPy and PySPOD, arrays in
memory to arrays.

    pip install ./python scipy nitime pybispectra==1.3.2 pyspod==2.0.0
    python benches/peers/python_estimates.py [--rounds 5] [--core 1] [--out FILE.md]

Noise with a steep spectrum, one thread pinned to one core; round after round, each once a round,
and a figure is the median over rounds of the processor time, which other processes disturb less
than the time of a clock. What is compared:

coherence    all sites with the first, Hann segments of 1024, half overlapping. SciPy:
             `signal.coherence`. wavecascade beside it has phases, intervals and delays.
multitaper   seven tapers, NW = 4, adaptive weights, chi-square degrees of freedom, jackknife, of
             every site. nitime: `multi_taper_psd(adaptive=True, jackknife=True)`, on a few sites
             and scaled up. wavecascade beside it has intervals and the F-test.
bicoherence  of one site, and of all, each by itself; segments of 512, half overlapping. NumPy:
             products of all pairs at once, one realisation after the other, with indices made
             beforehand. pybispectra: `Bispectrum`, and with `Threenorm` for its bicoherence, from
             transforms made by NumPy. Peers of all sites: one, scaled up.
modes        SPOD, segments of 512, half overlapping. NumPy: segments, transforms, the method of
             snapshots with `linalg.eigh`, all modes of all frequencies. PySPOD writes its modes to
             files.
"""

import argparse
import contextlib
import functools
import io
import os
import platform
import statistics
import tempfile
import time

parser = argparse.ArgumentParser(
    description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
)
parser.add_argument("--rounds", type=int, default=5)
parser.add_argument("--core", type=int, default=1)
parser.add_argument("--times", type=int, default=16384)
parser.add_argument("--sites", type=int, default=300)
parser.add_argument("--peer-sites", type=int, default=10, help="sites of nitime, scaled up to all")
parser.add_argument("--out")
options = parser.parse_args()
os.sched_setaffinity(0, [options.core])
for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"

import nitime
import numpy as np
import scipy
from nitime.algorithms import multi_taper_psd
from scipy import signal

import wavecascade as wc

try:
    from pyspod.spod.standard import Standard
except ImportError:
    Standard = None
try:
    import pybispectra
except ImportError:
    pybispectra = None

SEGMENT = 512
HOP, LAST = SEGMENT // 2, (SEGMENT - 1) // 2
rng = np.random.default_rng(1)
noise = rng.standard_normal((options.times, options.sites))
field = signal.lfilter([1], [1, -0.9], noise, axis=0)
records = np.ascontiguousarray(field.T)
some = records[: options.peer_sites]
one_site = np.ascontiguousarray(field[:, 0])
periodic_hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(SEGMENT) / SEGMENT)
bins = np.arange(1, LAST + 1)
first, second = (index.ravel() for index in np.meshgrid(bins, bins))
# Neighbouring bins share power under the Hann window, so wavecascade has none below 2.
inside = (first >= second) & (second >= 2) & (first + second <= LAST)
first, second = first[inside], second[inside]


def transforms(values):
    """Of segments along the first axis: `(segment, bin, ...)`."""
    starts = range(0, options.times - SEGMENT + 1, HOP)
    segments = np.array([values[s : s + SEGMENT] for s in starts])
    window = periodic_hann.reshape((SEGMENT,) + (1,) * (values.ndim - 1))
    return np.fft.rfft((segments - segments.mean(axis=1, keepdims=True)) * window, axis=1)


def numpy_bicoherence():
    x = transforms(one_site)
    mean, pairs = np.zeros(len(first), complex), np.zeros(len(first))
    for one in x:
        product = one[first] * one[second]
        mean += product * one[first + second].conj()
        pairs += product.real**2 + product.imag**2
    powers = (abs(x) ** 2).sum(axis=0)
    return abs(mean) ** 2 / (pairs * powers[first + second]), np.angle(mean)


def pybispectra_moments(*kinds):
    x = transforms(one_site)[:, None, : LAST + 1]
    for kind in kinds:
        peer = kind(x, np.arange(LAST + 1, dtype=float), SEGMENT, verbose=False)
        peer.compute(indices=((0,), (0,), (0,)), n_jobs=1)


def numpy_modes():
    """Eigenvalues and modes of all frequencies."""
    x = transforms(field)
    scale = 2 / (len(x) * (periodic_hann**2).sum())
    eigenvalues, modes = [], []
    for m in range(1, LAST + 1):
        snapshots = x[:, m]
        values, vectors = np.linalg.eigh(snapshots.conj() @ snapshots.T * scale)
        eigenvalues.append(values[::-1])
        modes.append((vectors.T @ snapshots)[::-1])
    return np.array(eigenvalues), modes


def pyspod_modes():
    """Beside it, three modes of all frequencies go to files, which it cannot leave out."""
    how = {"time_step": 1, "n_space_dims": 1, "n_variables": 1, "n_dft": SEGMENT, "overlap": 50}
    how |= {"mean_type": "blockwise", "n_modes_save": 3}
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        Standard(params={**how, "savedir": folder}).fit(data_list=[field[:, :, None]])


def wc_coherence():
    return wc.coherence(field, layout="time-site", segment=1024, threads=1)


def wc_multitaper():
    return wc.spectrum(field, layout="time-site", multitaper=(4, 7), threads=1)


def wc_bicoherence():
    record = one_site[:, None]
    return wc.bicoherence(record, layout="time-site", segment=SEGMENT, every=0, threads=1)


def wc_bicoherence_of_all():
    return wc.bicoherence(field, layout="time-site", segment=SEGMENT, threads=1)


def wc_modes():
    return wc.modes(field, layout="time-site", segment=SEGMENT, threads=1)


def scipy_coherence():
    return signal.coherence(records[:1], records, nperseg=1024, noverlap=512)


def nitime_multitaper():
    return [multi_taper_psd(r, NW=4, adaptive=True, jackknife=True) for r in some]


# What is timed is the same: to rounding, away from 0 and the Nyquist frequency.
found = wc_coherence()["coherence"].values[1:-1, 1:]
np.testing.assert_allclose(found, scipy_coherence()[1].T[1:-1, 1:], rtol=1e-9)
np.testing.assert_allclose(
    wc_bicoherence()["bicoherence"].values,
    numpy_bicoherence()[0][np.lexsort((first, second))],
    atol=1e-12,
)
found = wc_modes()["eigenvalues"].values[1:-1]
expected = numpy_modes()[0][:, : found.shape[1]]
np.testing.assert_allclose(found[:, :5], expected[:, :5], rtol=1e-9)

ratio = options.sites / len(some)
works = {
    "coherence": {"wavecascade": (wc_coherence, 1), "SciPy": (scipy_coherence, 1)},
    "multitaper": {"wavecascade": (wc_multitaper, 1), "nitime": (nitime_multitaper, ratio)},
    "bicoherence": {"wavecascade": (wc_bicoherence, 1), "NumPy": (numpy_bicoherence, 1)},
    "bicoherence of all sites": {
        "wavecascade": (wc_bicoherence_of_all, 1),
        "NumPy": (numpy_bicoherence, options.sites),
    },
    "modes": {"wavecascade": (wc_modes, 1), "NumPy": (numpy_modes, 1)},
}
if Standard is not None:
    works["modes"]["PySPOD"] = (pyspod_modes, 1)
if pybispectra is not None:
    kinds = {
        "pybispectra, bispectrum alone": [pybispectra.Bispectrum],
        "pybispectra": [pybispectra.Bispectrum, pybispectra.Threenorm],
    }
    for what, times_one in [("bicoherence", 1), ("bicoherence of all sites", options.sites)]:
        for who, of in kinds.items():
            works[what][who] = (functools.partial(pybispectra_moments, *of), times_one)
            # It compiles what it calls first.
            works[what][who][0]()

times = {(what, who): [] for what, peers in works.items() for who in peers}
for _ in range(options.rounds):
    for what, peers in works.items():
        for who, (work, scale) in peers.items():
            begin = time.process_time()
            work()
            times[what, who].append(scale * (time.process_time() - begin))

lines = [
    f"{options.times} samples, {options.sites} sites, one core; wavecascade {wc.__version__}, "
    f"NumPy {np.__version__}, SciPy {scipy.__version__}, nitime {nitime.__version__}, "
    f"Python {platform.python_version()}; load {os.getloadavg()[0]:.1f}; "
    f"processor time, median of {options.rounds} rounds",
    "",
    "| estimate | library | ms | times as long as wavecascade |",
    "|---|---|---|---|",
]
for (what, who), seconds in times.items():
    own = statistics.median(times[what, "wavecascade"])
    took = statistics.median(seconds)
    lines.append(f"| {what} | {who} | {1e3 * took:.1f} | {took / own:.2f} |")
text = "\n".join(lines) + "\n"
print(text)
if options.out:
    with open(options.out, "w", encoding="utf-8") as file:
        file.write(text)
