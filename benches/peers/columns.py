"""Transforms of all columns: cascade and the libraries that Python reaches, in turn.

    cargo build --release --bench columns            # prints where the program is
    target/peers/bin/python benches/peers/columns.py --program target/release/deps/columns-... \
        [--cores 1] [--rounds 9] [--shapes 4096x300,...] [--out FILE.md]

All run pinned to the same cores, round after round, each once a round, so that a change of the
machine's clock or load meets all of them; a figure is the median over rounds. Arrays are allocated
and plans made beforehand (FFTW: FFTW_MEASURE), results go to arrays that exist where the library
allows it (not: SciPy, MKL).
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
parser.add_argument("--rounds", type=int, default=9)
parser.add_argument("--shapes", default="4096x300,16384x300,65536x1000,65536x1024,10007x300,9973x301")
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
        ("FFTW", plan.execute),
        ("MKL", lambda: mkl_fft.rfft(values, axis=0)),
        ("scipy", lambda: scipy.fft.rfft(values, axis=0, workers=THREADS)),
    ]


def of_shape(program, rows, columns, kind):
    random = numpy.random.default_rng(1)
    dtype = numpy.float64 if kind == "f64" else numpy.float32
    values = (random.random((rows, columns)) - 0.5).astype(dtype)
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


def main():
    program = subprocess.Popen(
        [options.program, "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with open("/proc/cpuinfo") as info:
        cpu = next((line.split(":")[1].strip() for line in info if line.startswith("model name")), "?")
    lines = [
        f"# Columns, {THREADS} thread{'s' if THREADS > 1 else ''}",
        "",
        f"`benches/peers/columns.py --cores {options.cores} --rounds {options.rounds}`; {cpu}; "
        f"Python {platform.python_version()}, NumPy {numpy.__version__}, SciPy {scipy.__version__}, "
        f"ducc0 {ducc0.__version__}, pyFFTW {pyfftw.__version__}, mkl_fft {mkl_fft.__version__}. "
        f"Load average at the start: {os.getloadavg()[0]:.1f}.",
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
    lines.append("")
    if options.out:
        with open(options.out, "w") as out:
            out.write("\n".join(lines))
        with open(os.path.splitext(options.out)[0] + ".json", "w") as out:
            json.dump(raw, out, indent=1)
    else:
        print("\n".join(lines))


main()
