#!/usr/bin/env python3
"""Times of the estimates of `cascade` beside nitime, SciPy, pybispectra, NumPy and PySPOD, on the same field.

    cargo build --release --bin cascade
    cargo build --release --example estimates
    pip install numpy scipy nitime pybispectra==1.3.2 pyspod==2.0.0
    python3 benches/peers/estimates.py target/release/cascade [--example target/release/examples/estimates]
        [--times 16384] [--sites 300] [--rounds 5] [--threads 1] [--core 1] [--out FILE.md]

The field is noise with a steep spectrum, in a temporary folder. All run round after round, each once a round; a figure
is the median over rounds. With one thread all are pinned to one core, and times are processor times of user and
system, which other processes disturb less than the time of a clock; with more they are times of a clock. Timed:

multitaper   nitime: adaptive weights, chi-square degrees of freedom and jackknife variance of every site,
             `multi_taper_psd(NW=4, adaptive=True, jackknife=True)`, of some sites, scaled up; cascade: the same with
             intervals, F-test and files, `spectrum --multitaper 4,7`
coherence    SciPy: `coherence` of all sites with the first, Hann segments of 1024, half overlapping; cascade: the
             same with phases, delays and files, `coherence --segment 1024`
bicoherence  of every site by itself, segments of 512, half overlapping. pybispectra: `Bispectrum` of one site from
             transforms by NumPy, scaled up to all, alone and with `Threenorm` for its bicoherence. NumPy: products of all
             pairs at once, one realisation after the other, with indices made beforehand, of one site, scaled up. cascade:
             with significance and files, `bicoherence --segment 512`
modes        SPOD, segments of 512 and of 1024, half overlapping. PySPOD writes three modes of all frequencies; cascade:
             all eigenvalues with intervals, three modes of the frequency with the largest, `modes --segment 512`

The times of cascade are those of the whole command: start, hash of the input, reading, writing. The peers, and the
example, are timed from the array in memory to the result.
"""

import argparse
import contextlib
import io
import os
import pathlib
import platform
import resource
import statistics
import subprocess
import tempfile
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("cascade")
parser.add_argument("--example", help="the program that times the same in memory")
parser.add_argument("--times", type=int, default=16384)
parser.add_argument("--sites", type=int, default=300)
parser.add_argument("--rounds", type=int, default=5)
parser.add_argument("--threads", type=int, default=1)
parser.add_argument("--core", type=int, default=1)
parser.add_argument("--peer-sites", type=int, default=2, help="nitime on this many sites, scaled up to all")
parser.add_argument("--out")
typed = parser.parse_args()
if typed.threads == 1:
    os.sched_setaffinity(0, [typed.core])
for variable in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = str(typed.threads)

import numpy as np
import pybispectra
from nitime.algorithms import multi_taper_psd
from pyspod.spod.standard import Standard
from scipy import signal

SEGMENT = 512
LAST = (SEGMENT - 1) // 2
random = np.random.default_rng(1)
field = signal.lfilter([1], [1, -0.9], random.standard_normal((typed.times, typed.sites)), axis=0)
records = np.ascontiguousarray(field.T)
some = records[: typed.peer_sites]
hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(SEGMENT) / SEGMENT)
bins = np.arange(1, LAST + 1)
first, second = (index.ravel() for index in np.meshgrid(bins, bins))
# As cascade: neighbouring bins share power under the Hann window, so none below 2.
inside = (first >= second) & (second >= 2) & (first + second <= LAST)
first, second = first[inside], second[inside]


def transforms():
    starts = range(0, typed.times - SEGMENT + 1, SEGMENT // 2)
    segments = np.array([records[0, s : s + SEGMENT] for s in starts])
    return np.fft.rfft((segments - segments.mean(axis=1, keepdims=True)) * hann)


def numpy_bicoherence():
    x = transforms()
    mean, pairs = np.zeros(len(first), complex), np.zeros(len(first))
    for one in x:
        product = one[first] * one[second]
        mean += product * one[first + second].conj()
        pairs += product.real**2 + product.imag**2
    powers = (abs(x) ** 2).sum(axis=0)
    return abs(mean) ** 2 / (pairs * powers[first + second]), np.angle(mean)


def of_pybispectra(*kinds):
    x = transforms()[:, None, : LAST + 1]
    for kind in kinds:
        peer = kind(x, np.arange(LAST + 1, dtype=float), SEGMENT, verbose=False)
        peer.compute(indices=((0,), (0,), (0,)), n_jobs=1)


def of_pyspod(segment):
    how = {"time_step": 1, "n_space_dims": 1, "n_variables": 1, "n_dft": segment, "overlap": 50}
    how |= {"mean_type": "blockwise", "n_modes_save": 3}
    with tempfile.TemporaryDirectory() as to, contextlib.redirect_stdout(io.StringIO()):
        Standard(params={**how, "savedir": to}).fit(data_list=[field[:, :, None]])


def clock():
    """Of this process and of its children."""
    if typed.threads > 1:
        return time.perf_counter()
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(used.ru_utime + used.ru_stime for used in both)


temporary = tempfile.TemporaryDirectory()
folder = pathlib.Path(temporary.name)
np.save(folder / "field.npy", field)


def cascade(command, *words):
    shared = ["--figures", "none", "--quiet", "--force", "--layout", "time-site", "--threads", str(typed.threads)]
    words = [typed.cascade, command, folder / "field.npy", *words, *shared, "--out", folder / command]
    return lambda: subprocess.run(words, check=True)


# What is timed, and what it is multiplied by.
works = {
    "multitaper": {
        "cascade": (cascade("spectrum", "--multitaper", "4,7"), 1),
        "nitime": (
            lambda: [multi_taper_psd(r, NW=4, adaptive=True, jackknife=True) for r in some],
            typed.sites / len(some),
        ),
    },
    "coherence": {
        "cascade": (cascade("coherence", "--segment", "1024"), 1),
        "SciPy": (lambda: signal.coherence(records[:1], records, nperseg=1024, noverlap=512), 1),
    },
    "bicoherence": {
        "cascade": (cascade("bicoherence", "--segment", str(SEGMENT)), 1),
        "pybispectra": (lambda: of_pybispectra(pybispectra.Bispectrum, pybispectra.Threenorm), typed.sites),
        "pybispectra, bispectrum alone": (lambda: of_pybispectra(pybispectra.Bispectrum), typed.sites),
        "NumPy": (numpy_bicoherence, typed.sites),
    },
    "modes, 512": {
        "cascade": (cascade("modes", "--segment", "512"), 1),
        "PySPOD": (lambda: of_pyspod(512), 1),
    },
    "modes, 1024": {
        "cascade": (cascade("modes", "--segment", "1024"), 1),
        "PySPOD": (lambda: of_pyspod(1024), 1),
    },
}
# numba compiles what is called first.
of_pybispectra(pybispectra.Bispectrum, pybispectra.Threenorm)
times = {(what, who): [] for what, peers in works.items() for who in peers}
in_memory = {}
for _ in range(typed.rounds):
    for what, peers in works.items():
        for who, (work, scale) in peers.items():
            begun = clock()
            work()
            times[what, who].append(scale * (clock() - begun))
    if typed.example:
        words = [typed.example, folder / "field.npy", str(typed.threads)]
        lines = subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()
        for line in lines:
            what, milliseconds = line.rsplit(maxsplit=1)
            in_memory.setdefault(what, []).append(float(milliseconds))

kind = "processor time" if typed.threads == 1 else "time of a clock"
lines = [
    f"{typed.times} samples, {typed.sites} sites, threads: {typed.threads}; NumPy {np.__version__}, "
    f"Python {platform.python_version()}; load {os.getloadavg()[0]:.1f}; {kind}, median of {typed.rounds} rounds",
    "",
    "| estimate | program | ms | times as long as the command |",
    "|---|---|---|---|",
]
for (what, who), seconds in times.items():
    took = statistics.median(seconds)
    ratio = took / statistics.median(times[what, "cascade"])
    lines.append(f"| {what} | {who} | {1e3 * took:.1f} | {ratio:.2f} |")
if in_memory:
    lines += ["", "From the array in memory to the result, in the library:", "", "| estimate | ms |", "|---|---|"]
    lines += [f"| {what} | {statistics.median(each):.2f} |" for what, each in in_memory.items()]
text = "\n".join(lines) + "\n"
print(text)
if typed.out:
    pathlib.Path(typed.out).write_text(text)
