"""What a user waits for: whole commands, of one program or more.

    python3 benches/felt.py PROGRAM [OTHER ...] [--rounds 7] [--only sweep]

Programs run in interleaved rounds. Prints the median seconds by the clock and of processor time,
and the first program's over those of the others.
"""

import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

STRUCK = "--sites 300 --stiffness-ratio 4.9272 --end-time 295 --tolerance 1e-8"
RUN = f"simulate {STRUCK} --samples 4096 --out run.npz"
FAR = "--stiffness-ratio 4.9272 --end-time 1000 --samples 2 --tolerance 1e-6"
SWEEP = "--sites 300 --end-time 250 --samples 2 --vary stiffness_ratio=1:1585:64log --tolerance 1e-6"
KEYS = "stiffness_ratio,striker_velocity"
GRADIENT = "--sites 100 --stiffness-ratio 4.9272 --end-time 95 --samples 64"

#: Name, what is made before, and what is timed.
WORK = [
    (
        "analyze of a run, 4096 x 300",
        f"simulate {STRUCK} --samples 4096 --out run.npz",
        "analyze run.npz --out a",
    ),
    ("the same without pictures", None, "analyze run.npz --figures none --out a"),
    ("simulate, 4096 samples", None, f"simulate {STRUCK} --samples 4096 --out b.npz"),
    ("simulate, 64 samples", None, f"simulate {STRUCK} --samples 64 --out b.npz"),
    ("budget of the run", None, "budget run.npz --out a"),
    ("front in 1,200 sites", None, f"simulate {FAR} --sites 1200 --out b.npz"),
    ("front in 100,000 sites", None, f"simulate {FAR} --sites 100000 --out b.npz"),
    ("run of 100 sites", None, f"simulate {GRADIENT} --out b.npz"),
    (
        "its gradient by two keys",
        None,
        f"simulate {GRADIENT} --striker-velocity 1 --gradient {KEYS} --out b.npz",
    ),
    ("sweep of 64 ratios, one thread", None, f"sweep {SWEEP} --threads 1 --out a"),
]


def seconds(program, words, folder):
    """By the clock and of processor time."""
    shutil.rmtree(folder / "a", ignore_errors=True)
    (folder / "b.npz").unlink(missing_ok=True)
    before, start = os.times(), time.perf_counter()
    subprocess.run([program, *words.split(), "--quiet"], cwd=folder, check=True)
    clock, after = time.perf_counter() - start, os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return clock, used


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", default="", help="work whose name holds this")
    typed = parser.parse_args()
    programs = [str(pathlib.Path(program).resolve()) for program in typed.programs]
    print("| work | clock (s) | processor (s) | over the others: clock, processor |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for name, first, words in WORK:
            if first:
                subprocess.run([programs[0], *first.split(), "--quiet"], cwd=folder, check=True)
            if typed.only not in name:
                continue
            taken = [[] for _ in programs]
            for _ in range(typed.rounds):
                for program, times in zip(programs, taken, strict=True):
                    times.append(seconds(program, words, folder))
            medians = [[statistics.median(own) for own in zip(*times, strict=True)] for times in taken]
            own, others = medians[0], medians[1:]
            ratios = "; ".join(f"{own[0] / other[0]:.2f}, {own[1] / other[1]:.2f}" for other in others)
            print(f"| {name} | {own[0]:.3f} | {own[1]:.3f} | {ratios} |", flush=True)


if __name__ == "__main__":
    main()
