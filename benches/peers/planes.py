"""Transforms of both axes, and of overlapping segments: cascade and the libraries that Python reaches.

    cargo build --release -p throughput --bench planes            # prints where the program is
    target/peers/bin/python benches/peers/planes.py --program target/release/deps/planes-... \
        [--cores 1] [--rounds 7] [--cases spacetime:8192x8192,short-time:16384x300] [--out FILE.md]

All run pinned to the same cores, round after round, each once a round; a figure is the median over
rounds. Arrays are allocated and plans made beforehand (FFTW: FFTW_MEASURE), results go to arrays
that exist where the library allows it (not: SciPy, MKL).

Short-time segments are of 256 samples, 32 apart, weighed by Hann's window. `ShortTimeFFT` is SciPy's own;
the others get the segments weighed by NumPy in one expression, whose time counts.
"""

import argparse
import json
import math
import os
import platform
import statistics
import subprocess
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--program", required=True)
parser.add_argument("--cores", default="1", help="cores to pin to, separated by commas; a thread each")
parser.add_argument("--rounds", type=int, default=7)
parser.add_argument("--cases", default="spacetime:8192x8192,short-time:16384x300")
parser.add_argument("--types", default="f64,f32")
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
import scipy.signal

SEGMENT, HOP = 256, 32


def both_axes(values):
    rows, columns = values.shape
    kind = numpy.complex64 if values.dtype == numpy.float32 else numpy.complex128
    # An array that is written to first keeps page faults out of the times.
    out = numpy.zeros((rows, columns // 2 + 1), kind)
    fftw_in = pyfftw.empty_aligned(values.shape, values.dtype)
    fftw_out = pyfftw.empty_aligned(out.shape, kind)
    plan = pyfftw.FFTW(fftw_in, fftw_out, axes=(0, 1), flags=("FFTW_MEASURE",), threads=THREADS)
    fftw_in[:] = values
    return {
        "ducc0": lambda: ducc0.fft.r2c(values, axes=(0, 1), nthreads=THREADS, out=out),
        "FFTW": plan.execute,
        "MKL": lambda: mkl_fft.rfft2(values),
        "scipy": lambda: scipy.fft.rfft2(values, workers=THREADS),
    }


def segments_of(values):
    window = scipy.signal.get_window("hann", SEGMENT).astype(values.dtype)
    pieces = numpy.lib.stride_tricks.sliding_window_view(values, SEGMENT, axis=0)[::HOP]
    kind = numpy.complex64 if values.dtype == numpy.float32 else numpy.complex128
    weighed = numpy.empty((len(pieces), SEGMENT, values.shape[1]), values.dtype)
    out = numpy.zeros((len(pieces), SEGMENT // 2 + 1, values.shape[1]), kind)
    by_row = numpy.moveaxis(pieces, 2, 1)

    def weigh():
        return numpy.multiply(by_row, window[:, None], out=weighed)

    own = scipy.signal.ShortTimeFFT(window, HOP, fs=1.0)
    return {
        "ShortTimeFFT": lambda: own.stft(values, axis=0),
        "window, ducc0": lambda: ducc0.fft.r2c(weigh(), axes=(1,), nthreads=THREADS, out=out),
        "window, MKL": lambda: mkl_fft.rfft(weigh(), axis=1),
        "window, MKL, turned": lambda: mkl_fft.rfft(pieces * window, axis=2),
        "window, scipy": lambda: scipy.fft.rfft(weigh(), axis=1, workers=THREADS),
    }


def measured(program, work, rows, columns, kind):
    random = numpy.random.default_rng(1)
    dtype = numpy.float64 if kind == "f64" else numpy.float32
    values = (random.random((rows, columns)) - 0.5).astype(dtype)
    peers = both_axes(values) if work == "spacetime" else segments_of(values)
    times = {name: [] for name in ["cascade", "realfft, rustfft", *peers]}
    for turn in range(options.rounds + 1):
        program.stdin.write(f"{work} {rows} {columns} {kind} {THREADS}\n")
        program.stdin.flush()
        found = dict(zip(times, map(float, program.stdout.readline().split())))
        for name, run in peers.items():
            start = time.perf_counter()
            run()
            found[name] = 1e3 * (time.perf_counter() - start)
        # The first round warms up.
        if turn > 0:
            for name, value in found.items():
                times[name].append(value)
    return times


def main():
    program = subprocess.Popen(
        [options.program, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with open("/proc/cpuinfo") as info:
        cpu = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), "?")
    lines = [
        f"# Both axes, and short-time, {THREADS} thread{'s' if THREADS > 1 else ''}",
        "",
        f"`benches/peers/planes.py --cores {options.cores} --rounds {options.rounds}`; {cpu}; "
        f"Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}, "
        f"ducc0 {ducc0.__version__}, pyFFTW {pyfftw.__version__}, mkl_fft {mkl_fft.__version__}. "
        f"Load average at the start: {os.getloadavg()[0]:.1f}.",
        "",
        "Milliseconds, medians; in brackets the ratio to cascade.",
    ]
    raw = {}
    for case in options.cases.split(","):
        work, shape = case.split(":")
        rows, columns = (int(part) for part in shape.split("x"))
        header = True
        for kind in options.types.split(","):
            times = measured(program, work, rows, columns, kind)
            raw[f"{case} {kind}"] = times
            medians = {name: statistics.median(values) for name, values in times.items()}
            ours = medians.pop("cascade")
            operations = 2.5 * rows * columns * math.log2(rows * columns)
            if work == "short-time":
                segments = (rows - SEGMENT) // HOP + 1
                operations = 2.5 * segments * columns * SEGMENT * math.log2(SEGMENT)
            if header:
                lines.append("")
                lines.append("| case | type | cascade | GFLOP/s | best other | " + " | ".join(medians) + " |")
                lines.append("|---" * (5 + len(medians)) + "|")
                header = False
            lines.append(
                f"| {work} {shape} | {kind} | {ours:.2f} | {operations / ours / 1e6:.1f} | "
                f"x {min(medians.values()) / ours:.2f} | "
                + " | ".join(f"{value:.2f} ({value / ours:.2f})" for value in medians.values())
                + " |"
            )
            print(lines[-1], flush=True)
    program.stdin.close()
    program.wait()
    lines.append("")
    if options.out:
        with open(options.out, "w") as out:
            out.write("\n".join(lines))
        with open(os.path.splitext(options.out)[0] + ".json", "w") as out:
            json.dump(raw, out, indent=1)


main()
