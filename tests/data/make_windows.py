"""Writes windows.json: windows and Slepian sequences as SciPy computes them.

Run: python make_windows.py > windows.json
"""

import datetime
import json
import sys

import numpy
import scipy
from scipy.signal import get_window
from scipy.signal.windows import dpss

WINDOWS = {
    "none": "boxcar",
    "hann": "hann",
    "hamming": "hamming",
    "blackman-harris": "blackmanharris",
    "flat-top": "flattop",
    "tukey:0": ("tukey", 0.0),
    "tukey:0.25": ("tukey", 0.25),
    "tukey:1": ("tukey", 1.0),
    "kaiser:0": ("kaiser", 0.0),
    "kaiser:14": ("kaiser", 14.0),
    "kaiser:120": ("kaiser", 120.0),
    "dpss:0.9": ("dpss", 0.9),
    "dpss:4": ("dpss", 4.0),
}


def windows():
    for name, spec in WINDOWS.items():
        for n in (1, 2, 3, 64, 101):
            if name.startswith("dpss") and 1 < n and spec[1] >= (n + 1) / 2:
                continue
            yield {"name": name, "n": n, "samples": get_window(spec, n).tolist()}


def gains():
    n = 256
    for name, spec in WINDOWS.items():
        w = get_window(spec, n)
        yield {
            "name": name,
            "n": n,
            "coherent_gain": w.mean(),
            "power_gain": (w**2).mean(),
        }


def sequences():
    for n, nw, count in ((16, 2.5, 6), (64, 4, 8), (101, 4, 8), (1000, 3.5, 7)):
        samples, ratios = dpss(n, nw, count, return_ratios=True)
        step = max(1, n // 100)
        for k in range(count):
            yield {
                "n": n,
                "nw": nw,
                "k": k,
                "step": step,
                "concentration": ratios[k],
                "samples": samples[k, ::step].tolist(),
            }


json.dump(
    {
        "made": {
            "by": "make_windows.py",
            "date": datetime.date.today().isoformat(),
            "numpy": numpy.__version__,
            "scipy": scipy.__version__,
        },
        "windows": list(windows()),
        "gains": list(gains()),
        "sequences": list(sequences()),
    },
    sys.stdout,
    separators=(",", ":"),
)
print()
