"""Spectral proper orthogonal decomposition: `cascade modes` and PySPOD, timed in turn.

    cargo build --release --bin cascade
    python3 -m venv target/pyspod && target/pyspod/bin/pip install numpy==2.4.6 pyspod==2.0.0
    target/pyspod/bin/python benches/peers/modes.py [--times 16384] [--sites 300] [--segment 1024] [--cores 2] [--rounds 5]

Both read one .npy file, average segments that overlap by half, find all eigenvalues and write the first three modes
of ten frequencies (PySPOD: of all, which it cannot leave out; its time to write them counts, and is printed apart by
its own report). Whole commands are timed, for PySPOD without the start of Python and its imports. Prints the median
of each, the ratio, and the largest difference of the eigenvalues after the windows' scales are removed.
"""

import argparse
import contextlib
import io
import json
import os
import pathlib
import statistics
import subprocess
import tempfile
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--times", type=int, default=16384)
parser.add_argument("--sites", type=int, default=300)
parser.add_argument("--segment", type=int, default=1024)
parser.add_argument("--cores", type=int, default=2)
parser.add_argument("--rounds", type=int, default=5)
parser.add_argument("--program", default="target/release/cascade")
options = parser.parse_args()
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = str(options.cores)

import numpy as np
import pyspod.spod.utils
from pyspod.spod.standard import Standard

N = options.segment
window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(N) / N)
pyspod.spod.utils._hamming_window = lambda n: window
program = pathlib.Path(options.program).resolve()
rng = np.random.default_rng(1)
t, x = np.arange(options.times)[:, None], np.arange(options.sites)[None, :]
field = np.cos(0.3 * x - 0.2 * t) + rng.normal(size=(options.times, options.sites))

with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
    np.save("field.npy", field)
    frequencies = ",".join(str((10 + 40 * i) / N) for i in range(10))

    def ours():
        words = ["modes", "field.npy", "--segment", str(N), "--frequencies", frequencies, "--figures", "none"]
        words += ["--threads", str(options.cores), "--force", "--quiet"]
        subprocess.run([program, *words], check=True)
        return np.load("field-modes/modes.npz")["eigenvalues"]

    def theirs():
        how = {"time_step": 1, "n_space_dims": 1, "n_variables": 1, "n_dft": N, "overlap": 50}
        how |= {"mean_type": "blockwise", "n_modes_save": 3, "savedir": "spod"}
        with contextlib.redirect_stdout(io.StringIO()):
            spod = Standard(params=how)
            spod.fit(data_list=[np.load("field.npy")[:, :, None]])
        return spod.eigs.real * window.sum() ** 2 / (window**2).sum()

    seconds = {"cascade": [], "pyspod": []}
    for _ in range(options.rounds):
        for name, run in (("cascade", ours), ("pyspod", theirs)):
            start = time.perf_counter()
            found = run()
            seconds[name].append(time.perf_counter() - start)
            if name == "cascade":
                eigenvalues = found
    medians = {name: statistics.median(all) for name, all in seconds.items()}
    off = np.abs(found - eigenvalues).max() / eigenvalues.max()
    print(json.dumps({**medians, "ratio": medians["pyspod"] / medians["cascade"], "difference": off, "seconds": seconds}))
