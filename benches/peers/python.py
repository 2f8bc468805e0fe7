"""Transforms of the Python package beside scipy.fft and numpy.fft: times of calls, in turn.

    pip install ./python scipy
    python benches/peers/python.py [--rounds 15] [--core 1] [--out FILE.md]

All run on one thread pinned to one core, round after round, each once a round; a figure is the median
over rounds. The overhead of a call is the time of a transform of 8 x 2 numbers.
"""

import argparse
import os
import platform
import statistics
import time

parser = argparse.ArgumentParser(
    description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
)
parser.add_argument("--rounds", type=int, default=15)
parser.add_argument("--core", type=int, default=1)
parser.add_argument("--shapes", default="16384x300,65536x1000")
parser.add_argument("--out")
options = parser.parse_args()
os.sched_setaffinity(0, [options.core])
for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"

import numpy
import scipy
import scipy.fft

import wavecascade as wc

PEERS = {
    "wavecascade": lambda a, axis: wc.fft.rfft(a, axis=axis),
    "scipy": lambda a, axis: scipy.fft.rfft(a, axis=axis),
    "numpy": lambda a, axis: numpy.fft.rfft(a, axis=axis),
}


def timed(call, *arguments):
    """Seconds of a call, and of what it returns to be let go of."""
    begin = time.perf_counter()
    call(*arguments)
    return time.perf_counter() - begin


def medians(values, axis, rounds, repeat=1):
    """The median over rounds of each library, in seconds."""
    times = {name: [] for name in PEERS}
    for _ in range(rounds):
        for name, call in PEERS.items():
            times[name].append(min(timed(call, values, axis) for _ in range(repeat)))
    return {name: statistics.median(all_) for name, all_ in times.items()}


lines = [
    f"wavecascade {wc.__version__}, scipy {scipy.__version__}, numpy {numpy.__version__}, "
    f"Python {platform.python_version()}; load {os.getloadavg()[0]:.1f}; "
    f"median of {options.rounds} rounds, ms",
    "",
    "| shape | axis | type | wavecascade | scipy | numpy | speed to the faster peer |",
    "|---|---|---|---|---|---|---|",
]
rng = numpy.random.default_rng(26)
for shape in options.shapes.split(","):
    rows, columns = map(int, shape.split("x"))
    whole = rng.standard_normal((rows, columns))
    for kind in ("float64", "float32"):
        values = whole.astype(kind)
        for axis in (0, 1):
            # Along the last axis, as many records of the same length.
            array = values if axis == 0 else numpy.ascontiguousarray(values.T)
            found = medians(array, axis, options.rounds)
            cells = " | ".join(f"{1e3 * found[name]:.2f}" for name in PEERS)
            speed = min(found["scipy"], found["numpy"]) / found["wavecascade"]
            place = "first" if axis == 0 else "last"
            lines.append(
                f"| {array.shape[0]} x {array.shape[1]} | {place} | {kind} | {cells} | {speed:.2f} |"
            )
small = medians(rng.standard_normal((8, 2)), 0, 200, 20)
lines += ["", "Overhead of a call, us: " + ", ".join(f"{n} {1e6 * t:.1f}" for n, t in small.items())]
text = "\n".join(lines) + "\n"
print(text)
if options.out:
    with open(options.out, "w", encoding="utf-8") as log:
        log.write(text)
