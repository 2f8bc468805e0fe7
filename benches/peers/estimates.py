#!/usr/bin/env python3
"""Times of `cascade spectrum` and `cascade coherence` beside nitime and SciPy, on the same field.

    python3 benches/peers/estimates.py PATH/TO/cascade [--times 16384] [--sites 300] [--rounds 3] [--threads N]

The field is noise with a steep spectrum, in a temporary folder. Timed:

multitaper   nitime: adaptive weights, chi-square degrees of freedom and jackknife variance of every site,
             `multi_taper_psd(NW=4, adaptive=True, jackknife=True)`; cascade: the same with intervals, F-test and
             files, `spectrum --multitaper 4,7`
coherence    SciPy: `coherence` of all sites with the first, Hann segments of 1024, half overlapping; cascade: the
             same with phases, delays and files, `coherence --segment 1024`

The times of cascade are those of the whole command: start, reading, writing. nitime and SciPy are timed from the
array in memory to the result. Needs numpy, scipy, nitime. Prints one line of JSON.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile
import time

import numpy as np
from nitime.algorithms import multi_taper_psd
from scipy import signal


def timed(work, rounds):
    seconds = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cascade")
    parser.add_argument("--times", type=int, default=16384)
    parser.add_argument("--sites", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--peer-sites", type=int, default=None, help="nitime on this many sites, scaled up to all")
    typed = parser.parse_args()
    random = np.random.default_rng(1)
    field = signal.lfilter([1], [1, -0.9], random.standard_normal((typed.times, typed.sites)), axis=0)
    records = np.ascontiguousarray(field.T)
    some = records[: typed.peer_sites or typed.sites]
    share = len(some) / typed.sites
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        np.save(folder / "field.npy", field)
        common = ["--out", str(folder / "out"), "--force", "--figures", "none", "--quiet", "--threads", str(typed.threads)]
        layout = ["--layout", "time-site"]

        def cascade(*words):
            return lambda: subprocess.run([typed.cascade, *words, *common, *layout], check=True)

        path = str(folder / "field.npy")
        found = {
            "times": typed.times,
            "sites": typed.sites,
            "threads": typed.threads,
            "cascade_multitaper": timed(cascade("spectrum", path, "--multitaper", "4,7"), typed.rounds),
            "cascade_coherence": timed(cascade("coherence", path, "--segment", "1024"), typed.rounds),
            "scipy_coherence": timed(
                lambda: signal.coherence(records[:1], records, nperseg=1024, noverlap=512), typed.rounds
            ),
            "nitime_multitaper": timed(
                lambda: [multi_taper_psd(r, NW=4, adaptive=True, jackknife=True) for r in some],
                1,
            )
            / share,
            "nitime_sites": len(some),
        }
    for what, peer in [("multitaper", "nitime"), ("coherence", "scipy")]:
        found[f"{what}_ratio"] = found[f"{peer}_{what}"] / found[f"cascade_{what}"]
    print(json.dumps(found))


if __name__ == "__main__":
    main()
