"""Bicoherence of a record: cascade beside NumPy and pybispectra, in turn.

    cargo build --release
    python -m venv VENV && VENV/bin/pip install numpy pybispectra==1.3.2
    VENV/bin/python benches/peers/bicoherence.py --program target/release/cascade [--out FILE.md]

One record of 16384 samples, segments of 512 that overlap by half under a Hann window (63 realisations), bicoherence and
biphase of all triples. All run on one core, round after round; a figure is the median over rounds. NumPy: `rfft`,
then products of all pairs at once, one realisation after the other, with indices made beforehand. pybispectra:
`Bispectrum` alone, without the denominators. cascade is timed as a whole process with `--figures none`, on a field of
one site and on one of many, so that the difference divided by their number is the time of a site.
"""

import argparse
import os
import pathlib
import platform
import statistics
import subprocess
import tempfile
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--program", required=True)
parser.add_argument("--core", type=int, default=1)
parser.add_argument("--rounds", type=int, default=7)
parser.add_argument("--sites", type=int, default=300)
parser.add_argument("--segment", type=int, default=512)
parser.add_argument("--out")
options = parser.parse_args()
os.sched_setaffinity(0, [options.core])
for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"

import numpy
import pybispectra

SAMPLES, SEGMENT = 16384, options.segment
HOP, LAST = SEGMENT // 2, (SEGMENT - 1) // 2
random = numpy.random.default_rng(1)
record = random.standard_normal(SAMPLES)
window = 0.5 - 0.5 * numpy.cos(2 * numpy.pi * numpy.arange(SEGMENT) / SEGMENT)
first, second = (index.ravel() for index in numpy.meshgrid(numpy.arange(1, LAST + 1), numpy.arange(1, LAST + 1)))
# As cascade: neighbouring bins share power under the Hann window, so none below 2.
inside = (first >= second) & (second >= 2) & (first + second <= LAST)
first, second = first[inside], second[inside]
third = first + second


def spectra():
    starts = range(0, SAMPLES - SEGMENT + 1, HOP)
    segments = numpy.array([record[s : s + SEGMENT] for s in starts])
    return numpy.fft.rfft((segments - segments.mean(axis=1, keepdims=True)) * window)


def with_numpy():
    transforms = spectra()
    mean, pairs = numpy.zeros(len(first), complex), numpy.zeros(len(first))
    for x in transforms:
        product = x[first] * x[second]
        mean += product * x[third].conj()
        pairs += product.real**2 + product.imag**2
    powers = (abs(transforms) ** 2).sum(axis=0)
    return abs(mean) ** 2 / (pairs * powers[third]), numpy.angle(mean)


def with_pybispectra():
    transforms = spectra()[:, None, : LAST + 1]
    peer = pybispectra.Bispectrum(transforms, numpy.arange(LAST + 1, dtype=float), SEGMENT, verbose=False)
    peer.compute(indices=((0,), (0,), (0,)), n_jobs=1)
    return peer.results.get_results(copy=False)[0]


def seconds(work):
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    numpy.save(folder / "one.npy", record[:, None])
    numpy.save(folder / "many.npy", random.standard_normal((SAMPLES, options.sites)))

    def with_cascade(name, *more):
        words = [options.program, "bicoherence", folder / f"{name}.npy", "--segment", str(SEGMENT), "--threads", "1"]
        words += ["--figures", "none", "--quiet", "--force", "--out", folder / "out", *more]
        subprocess.run(words, check=True)

    with_cascade("one", "--every", "0")
    found = numpy.load(folder / "out" / "bicoherence.npz")
    expected, _ = with_numpy()
    order = numpy.lexsort((first, second))
    assert abs(found["bicoherence"] - expected[order]).max() < 1e-12
    works = {
        "cascade, process of one site": lambda: with_cascade("one", "--every", "0"),
        f"cascade, process of {options.sites} sites": lambda: with_cascade("many"),
        "NumPy, one site": with_numpy,
        "pybispectra, one site": with_pybispectra,
    }
    with_pybispectra()
    times = {name: [] for name in works}
    for _ in range(options.rounds):
        for name, work in works.items():
            times[name].append(seconds(work))

medians = {name: statistics.median(all_of) for name, all_of in times.items()}
one, many, numpy_one, peer = medians.values()
site = (many - one) / options.sites
versions = f"NumPy {numpy.__version__}, pybispectra {pybispectra.__version__}, {platform.processor() or platform.machine()}"
lines = [f"{SAMPLES} samples, segments of {SEGMENT}, {len(first)} triples, one core; {versions}", ""]
lines += ["| what | ms |", "|---|---|"]
lines += [f"| {name} | {1000 * value:.1f} |" for name, value in medians.items()]
lines += [f"| cascade, a further site | {1000 * site:.2f} |", ""]
lines += [f"NumPy takes {numpy_one / site:.1f} times as long as cascade a site, pybispectra {peer / site:.1f} times."]
text = "\n".join(lines) + "\n"
print(text)
if options.out:
    pathlib.Path(options.out).write_text(text)
