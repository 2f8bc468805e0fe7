"""Interpolated samples and delays by other programs, for tests/fields.

python3 tests/data/interpolation.py > tests/data/interpolation.json   # 2026-11, NumPy 2.x, SciPy 1.x
"""

import json

import numpy
import scipy
from scipy.interpolate import CubicSpline, interp1d

rng = numpy.random.default_rng(20261125)


def rounded(values):
    return [float(v) for v in values]


def resampled(count):
    steps = rng.uniform(0.3, 1.7, count - 1)
    nodes = numpy.concatenate([[-2.0], -2.0 + numpy.cumsum(steps)])
    values = rng.standard_normal(count)
    # The places as the program has them.
    step = (nodes[-1] - nodes[0]) / (count - 1)
    places = numpy.minimum(nodes[0] + numpy.arange(count) * step, nodes[-1])
    nearest = interp1d(nodes, values, kind="nearest", assume_sorted=True)
    linear = interp1d(nodes, values, kind="linear", assume_sorted=True)
    return {
        "nodes": rounded(nodes),
        "values": rounded(values),
        "nearest": rounded(nearest(places)),
        "linear": rounded(linear(places)),
        "cubic": rounded(CubicSpline(nodes, values)(places)),
    }


def delayed(count, other, lag):
    noise = rng.standard_normal(count + other + abs(lag))
    at = max(0, lag)
    first = noise[at : at + count]
    record = noise[at - lag : at - lag + other] + 0.3 * rng.standard_normal(other)
    a, b = first - numpy.median(first), record - numpy.median(record)
    correlation = numpy.correlate(b, a, "full")
    at = int(numpy.argmax(correlation))
    before, here, after = correlation[at - 1 : at + 2]
    return {
        "first": rounded(first),
        "record": rounded(record),
        "samples": at - (count - 1),
        "fraction": float((before - after) / (2 * (before - 2 * here + after))),
        "coefficient": float(here / numpy.sqrt((a @ a) * (b @ b))),
    }


print(
    json.dumps(
        {
            "generator": f"NumPy {numpy.__version__}, SciPy {scipy.__version__}",
            "resampled": [resampled(count) for count in (2, 3, 4, 5, 12, 60)],
            "delayed": [delayed(64, 64, 7), delayed(64, 50, -5), delayed(40, 90, 0), delayed(50, 50, 21)],
        },
        indent=1,
    )
)
