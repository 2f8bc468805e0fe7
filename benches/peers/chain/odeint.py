"""Boost.odeint on the dimer chain, compiled for this machine by g++: rows of time and error.

Steppers: dopri5 and fehlberg78, controlled; SB3A, symplectic of fixed steps. Boost's headers come
from PyPI's `boost-headers`.

    python3 benches/peers/chain/odeint.py --reference FILE.npz --kappa 4.9272
"""

import pathlib
import subprocess
import sys
import tempfile

import peer

# The compiler has to be there before the script is asked for no more than `--install`.
SOURCE = pathlib.Path(__file__).with_suffix(".cpp")
PROGRAM = peer.HOME / "odeint/odeint"
python = peer.installed("odeint", ["numpy==2.4.6", "boost-headers==1.85.0.post1"])
if not PROGRAM.exists() or PROGRAM.stat().st_mtime < SOURCE.stat().st_mtime:
    headers = next((peer.HOME / "odeint").glob("**/boost/numeric/odeint.hpp")).parents[2]
    flags = ["-std=c++17", "-O3", "-march=native", "-DNDEBUG", "-isystem", headers]
    subprocess.run(["g++", *flags, "-o", PROGRAM, SOURCE], check=True)
peer.run_in("odeint", ["numpy==2.4.6", "boost-headers==1.85.0.post1"])

problem = peer.Problem(peer.asked(__doc__))
with tempfile.TemporaryDirectory() as folder:
    times, exact = pathlib.Path(folder) / "times", pathlib.Path(folder) / "exact"
    problem.times.tofile(times)
    problem.exact.tofile(exact)
    numbers = [problem.kappa, problem.n, problem.runs, peer.LONGEST_S]
    sys.exit(subprocess.run([PROGRAM, *map(str, numbers), times, exact]).returncode)
