"""Transforms of all columns: cascade and the libraries that Python reaches, in turn.

    cargo build --release -p throughput --bench columns            # prints where the program is
    target/peers/bin/python benches/peers/columns.py --program target/release/deps/columns-... \
        [--cores 1] [--rounds 9] [--shapes 4096x300,...] [--out FILE.md]
    ... --errors [--out FILE.md]       # relative errors instead of times

All run pinned to the same cores, round after round, each once a round, so that a change of the
machine's clock or load meets all of them; a figure is the median over rounds. Arrays are allocated
and plans made beforehand (FFTW: FFTW_MEASURE), results go to arrays that exist where the library
allows it (not: SciPy, MKL).

The error is the root mean square, over all bins of some 25 columns, of the difference from the
spectrum in extended precision (80 bits), relative to the root mean square of that spectrum. That
spectrum is SciPy's of `longdouble`, itself held against direct sums of exactly reduced angles.
"""

import argparse
import json
import math
import os
import platform
import statistics
import subprocess
import tempfile
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--program", required=True)
parser.add_argument("--cores", default="1", help="cores to pin to, separated by commas; a thread each")
parser.add_argument("--rounds", type=int, default=9)
parser.add_argument("--shapes", default="4096x300,16384x300,65536x1000,65536x1024,10007x300,9973x301")
parser.add_argument("--types", default="f64,f32")
parser.add_argument("--errors", action="store_true")
parser.add_argument("--out")
options = parser.parse_args()

CORES = [int(core) for core in options.cores.split(",")]
THREADS = len(CORES)
os.sched_setaffinity(0, CORES)
for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "DUCC0_NUM_THREADS"):
    os.environ[name] = str(THREADS)

import ducc0
import mkl_fft
import numpy
import pyfftw
import scipy
import scipy.fft

OURS = ["cascade", "realfft, 8 columns", "realfft, 1 column", "rustfft, two-for-one"]


def peers(values):
    """Name and a function that transforms, for each library."""
    rows, columns = values.shape
    kind = numpy.complex64 if values.dtype == numpy.float32 else numpy.complex128
    # An array that is written to first keeps page faults out of the times.
    out = numpy.zeros((rows // 2 + 1, columns), kind)
    fftw_in = pyfftw.empty_aligned(values.shape, values.dtype)
    fftw_out = pyfftw.empty_aligned(out.shape, kind)
    plan = pyfftw.FFTW(fftw_in, fftw_out, axes=(0,), flags=("FFTW_MEASURE",), threads=THREADS)
    fftw_in[:] = values
    return [
        ("ducc0", lambda: ducc0.fft.r2c(values, axes=(0,), nthreads=THREADS, out=out)),
        ("FFTW", lambda: (plan.execute(), fftw_out)[1]),
        ("MKL", lambda: mkl_fft.rfft(values, axis=0)),
        ("scipy", lambda: scipy.fft.rfft(values, axis=0, workers=THREADS)),
    ]


def noise(rows, columns, kind):
    random = numpy.random.default_rng(1)
    dtype = numpy.float64 if kind == "f64" else numpy.float32
    return (random.random((rows, columns)) - 0.5).astype(dtype)


def of_shape(program, rows, columns, kind):
    values = noise(rows, columns, kind)
    others = peers(values)
    times = {name: [] for name in OURS + [name for name, _ in others]}
    for round in range(options.rounds + 1):
        program.stdin.write(f"{rows} {columns} {kind} {THREADS}\n")
        program.stdin.flush()
        found = dict(zip(OURS, map(float, program.stdout.readline().split())))
        for name, run in others:
            start = time.perf_counter()
            run()
            found[name] = 1e3 * (time.perf_counter() - start)
        # The first round warms up.
        if round > 0:
            for name, value in found.items():
                times[name].append(value)
    return {name: statistics.median(value) for name, value in times.items()}, times


def rms(values):
    return float(numpy.sqrt(numpy.mean(numpy.abs(values) ** 2)))


def true_spectrum(values):
    """In extended precision, checked at eight bins of each column by direct sums."""
    rows = len(values)
    values = values.astype(numpy.longdouble)
    truth = scipy.fft.rfft(values, axis=0)
    assert truth.dtype == numpy.clongdouble and numpy.finfo(numpy.longdouble).eps < 2e-19
    turn = 8 * numpy.arctan(numpy.longdouble(1))
    time = numpy.arange(rows)
    bins = [(2 * i + 1) * (rows // 2) // 16 for i in range(8)]
    angles = [turn * (time * m % rows) / rows for m in bins]
    sums = [(numpy.cos(a) - 1j * numpy.sin(a)) @ values for a in angles]
    apart = rms(numpy.array(sums) - truth[bins]) / rms(truth)
    assert apart < 5e-18, apart
    return truth


def errors_of_shape(rows, columns, kind):
    values = noise(rows, columns, kind)
    every = columns // 25
    truth = true_spectrum(values[:, ::-every])
    size = rms(truth)
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "values")
        values.tofile(file)
        command = [options.program, "--spectra", str(rows), str(columns), kind, file, str(every)]
        subprocess.run(command, check=True)
        dtype = numpy.complex128 if kind == "f64" else numpy.complex64
        for way, name in enumerate(OURS):
            spectrum = numpy.fromfile(f"{file}.{way}", dtype).reshape(truth.shape)
            found[name] = rms(spectrum - truth) / size
    for name, run in peers(values):
        found[name] = rms(run()[:, ::-every] - truth) / size
    return found


def main():
    program = subprocess.Popen(
        [options.program, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    lines = [
        f"# Columns, {THREADS} thread{'s' if THREADS > 1 else ''}",
        "",
        versions(f"--cores {options.cores} --rounds {options.rounds}")
        + f" Load average at the start: {os.getloadavg()[0]:.1f}.",
        "",
        "Milliseconds, medians; in brackets the ratio to cascade.",
        "",
    ]
    raw = {}
    header = False
    for shape in options.shapes.split(","):
        rows, columns = (int(part) for part in shape.split("x"))
        for kind in options.types.split(","):
            medians, times = of_shape(program, rows, columns, kind)
            raw[f"{shape} {kind}"] = times
            ours = medians.pop("cascade")
            if not header:
                lines.append("| shape | type | cascade | GFLOP/s | best other | " + " | ".join(medians) + " |")
                lines.append("|---" * (5 + len(medians)) + "|")
                header = True
            work = 2.5 * rows * columns * math.log2(rows)
            best = min(medians.values())
            lines.append(
                f"| {shape} | {kind} | {ours:.2f} | {work / ours / 1e6:.1f} | x {best / ours:.2f} | "
                + " | ".join(f"{value:.2f} ({value / ours:.2f})" for value in medians.values())
                + " |"
            )
            print(lines[-1], flush=True)
    program.stdin.close()
    program.wait()
    write(lines, raw)


def errors():
    lines = [
        "# Columns, relative errors",
        "",
        versions(f"--errors --cores {options.cores}"),
        "",
        "Root mean square error over the bins of about 25 columns of uniform noise, relative to the root mean",
        "square of the spectrum, against extended precision (80 bits); in brackets the ratio to cascade.",
        "",
    ]
    raw = {}
    for shape in options.shapes.split(","):
        rows, columns = (int(part) for part in shape.split("x"))
        for kind in options.types.split(","):
            found = errors_of_shape(rows, columns, kind)
            raw[f"{shape} {kind}"] = found
            if len(raw) == 1:
                lines.append("| shape | type | " + " | ".join(found) + " |")
                lines.append("|---" * (2 + len(found)) + "|")
            others = [f"{value:.2e} ({value / found['cascade']:.2f})" for value in list(found.values())[1:]]
            lines.append(f"| {shape} | {kind} | {found['cascade']:.2e} | " + " | ".join(others) + " |")
            print(lines[-1], flush=True)
    write(lines, raw)


def versions(arguments):
    with open("/proc/cpuinfo") as info:
        cpu = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), "?")
    return (
        f"`benches/peers/columns.py {arguments}`; {cpu}; "
        f"Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}, "
        f"ducc0 {ducc0.__version__}, pyFFTW {pyfftw.__version__}, mkl_fft {mkl_fft.__version__}."
    )


def write(lines, raw):
    lines.append("")
    if options.out:
        with open(options.out, "w") as out:
            out.write("\n".join(lines))
        with open(os.path.splitext(options.out)[0] + ".json", "w") as out:
            json.dump(raw, out, indent=1)
    else:
        print("\n".join(lines))


errors() if options.errors else main()
