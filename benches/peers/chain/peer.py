"""What the peers share: the problem, how a peer is installed, timed and compared.

The non-dimensional dimer of N sites: x_j'' = F_{j-1} - F_j, F_j = c_j max(x_j - x_{j+1}, 0)^{3/2},
c_j = 1, kappa, 1, ..., the last contact with a fixed wall, site 0 at velocity 1 and all else at
rest. Asked for: velocities of all sites at the times of the reference file, which
tests/data/chain_reference.py makes. Error: the largest difference of a velocity.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[3]
HOME = ROOT / "target/peers/chain"

# Runs of one setting end when they have taken this long together.
LONGEST_S = 3.0


def installed(name, requirements):
    """The Python of a virtual environment that holds these pinned packages."""
    python = HOME / name / "bin/python"
    mark = HOME / name / "requirements.txt"
    wanted = "\n".join(requirements) + "\n"
    if not mark.exists() or mark.read_text() != wanted:
        subprocess.run([sys.executable, "-m", "venv", "--clear", HOME / name], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *requirements], check=True)
        mark.write_text(wanted)
    return python


def run_in(name, requirements):
    """Goes on with the calling script inside the environment, installed if need be."""
    if pathlib.Path(sys.prefix) != HOME / name:
        python = installed(name, requirements)
        if "--install" in sys.argv:
            sys.exit()
        os.execv(python, [python, *sys.argv])


def asked(description):
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--install", action="store_true", help="install and do no more")
    parser.add_argument("--kappa", type=float, default=4.9272, help="stiffness ratio")
    parser.add_argument("--reference", type=pathlib.Path, required="--install" not in sys.argv)
    parser.add_argument("--runs", type=int, default=3, help="timed runs after one for warming up")
    return parser.parse_args()


class Problem:
    def __init__(self, arguments):
        import numpy

        self.kappa = arguments.kappa
        self.runs = arguments.runs
        with numpy.load(arguments.reference) as file:
            self.times, self.exact = file["t"], file["v"]
        self.n = self.exact.shape[1]
        self.coefficient = numpy.where(numpy.arange(self.n) % 2 == 0, 1.0, self.kappa)

    def measure(self, program, scheme, setting, solve, prepare=None):
        """Prints a row for `solve`, which returns velocities (time, site), or says why not.

        What `prepare` returns is handed to `solve`; its time is not counted.
        """
        label = f"{program} {scheme} {setting}, kappa {self.kappa:g}"
        wall, used = [], []
        for run in range(1 + self.runs):
            try:
                ready = () if prepare is None else (prepare(),)
                start, before = time.perf_counter(), time.process_time()
                velocity = solve(*ready)
            except Exception as failure:
                print(f"{label}: {failure}", file=sys.stderr)
                return
            took = time.perf_counter() - start
            if run > 0:
                wall.append(took)
                used.append(time.process_time() - before)
            if run > 0 and sum(wall) + took > LONGEST_S:
                break
        error = float(abs(velocity - self.exact).max())
        if not error < 0.5:
            print(f"{label}: error {error:.1e}, too large a step", file=sys.stderr)
            return
        row = {
            "program": program,
            "scheme": scheme,
            "kappa": self.kappa,
            "setting": setting,
            "error": error,
            "seconds": wall,
            "cpu_seconds": used,
        }
        print(json.dumps(row), flush=True)
