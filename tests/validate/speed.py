"""Speed as a ratio to SciPy in the same rounds: medians of processor time, one thread each."""

import json
import pathlib
import resource
import statistics
import subprocess
import sys
import time

import numpy as np
import scipy.fft
import scipy.signal
from documents import numbers
from frame import scene_text
from scipy.integrate import odeint, solve_ivp

ROOT = pathlib.Path(__file__).resolve().parents[2]
PERFORMANCE = "performance.md"
WHOLE = "performance.md, Whole command"


def of_child(command, folder):
    """Processor time of a program, from start to end."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(word) for word in command], check=True, capture_output=True, cwd=folder)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def of_call(call):
    """Processor time of a call, and what it returned."""
    start = time.process_time()
    result = call()
    return time.process_time() - start, result


def dimer(ratio, sites):
    coefficient = np.where(np.arange(sites) % 2 == 0, 1.0, ratio)
    overlap, out = np.empty(sites), np.empty(2 * sites)

    def rates(t, y):
        np.subtract(y[: sites - 1], y[1:sites], out=overlap[:-1])
        overlap[-1] = y[sites - 1]
        np.maximum(overlap, 0, out=overlap)
        force = coefficient * overlap * np.sqrt(overlap)
        out[:sites] = y[sites:]
        out[sites] = -force[0]
        np.subtract(force[:-1], force[1:], out=out[sites + 1 :])
        return out.copy()

    start = np.zeros(2 * sites)
    start[sites] = 1
    return rates, start


def chains(part):
    """Time against error of struck chains"""
    sites, end, samples = 300, 295.0, 64
    times = np.linspace(0, end, samples)
    ratios = (4.9272,) if part.quick else (4.9272, 1631.0)
    rounds = 3
    sentence = "SciPy took # to # times as long there, and # to # times at ratio 1631"
    soft, _, stiff, _ = numbers(PERFORMANCE, sentence)
    least = {4.9272: soft, 1631.0: stiff}
    curves = {}
    for ratio in ratios:
        rates, start = dimer(ratio, sites)
        keys = dict(sites=sites, stiffness_ratio=ratio, end_time=end, samples=samples)
        exact = part.simulated(scene_text(**keys, tolerance=1e-10))[0]["velocity"]
        scene = part.folder / "timed.toml"
        scene.write_text(scene_text(**keys))

        def program(tolerance, scene=scene):
            words = [
                "simulate",
                scene,
                "--tolerance",
                tolerance,
                "--quiet",
                "--force",
                "--out",
                "timed.npz",
            ]
            seconds = of_child([part.program, *words], part.folder)
            with np.load(part.folder / "timed.npz") as stored:
                return seconds, stored["velocity"]

        def dop853(tolerance, rates=rates, start=start):
            seconds, found = of_call(
                lambda: solve_ivp(rates, (0, end), start, "DOP853", times, rtol=tolerance, atol=tolerance)
            )
            return seconds, found.y[sites:].T

        def lsoda(tolerance, rates=rates, start=start):
            seconds, found = of_call(
                lambda: odeint(
                    rates, start, times, tfirst=True, rtol=tolerance, atol=tolerance, mxstep=10**6
                )
            )
            return seconds, found[:, sites:]

        contestants = {
            "cascade simulate": (program, [1e-4, 1e-6, 1e-8]),
            "SciPy DOP853": (
                dop853,
                [1e-8, 1e-10, 1e-12] if part.quick else [1e-8, 1e-10, 1e-11, 1e-12],
            ),
            "SciPy odeint": (lsoda, [1e-8, 1e-10] if part.quick else [1e-8, 1e-10, 1e-12]),
        }
        seen = {}
        for _ in range(rounds):
            for name, (solve, tolerances) in contestants.items():
                for tolerance in tolerances:
                    seconds, found = solve(tolerance)
                    error = float(np.abs(found - exact).max())
                    seen.setdefault((name, tolerance), []).append((seconds, error))
        points = {}
        for (name, _), values in seen.items():
            points.setdefault(name, []).append((values[0][1], statistics.median(v[0] for v in values)))
        curves[str(ratio)] = points

        def fastest(name, number, seen=seen):
            """Of the runs of a round with an error below 1e-4."""
            of_name = [values for (whose, _), values in seen.items() if whose == name]
            return min((values[number][0] for values in of_name if values[0][1] <= 1e-4), default=np.inf)

        for name in points:
            if name == "cascade simulate":
                continue
            ratios = [fastest(name, n) / fastest("cascade simulate", n) for n in range(rounds)]
            what = (
                f"ratio {ratio:g}, 300 sites: {name} takes so many times as long at an error below 1e-4"
            )
            by = f"processor time, median of {rounds} rounds; the program with start and files"
            if np.isinf(ratios).any():
                part.note(f"{name} does not reach 1e-4 at ratio {ratio:g} with a tolerance tried")
                continue
            part.ratio(what, ratios, least[ratio], None, where=f"{PERFORMANCE}, Chains", by=by)
    part.outcome.series["chains"] = curves


def transforms(part):
    """Spectra against SciPy's transforms"""
    shapes = [(4096, 300)] if part.quick else [(16384, 300), (10007, 301), (32768, 256)]
    rounds = 3 if part.quick else 7
    _, share = numbers(WHOLE, "took # to # of the time of `numpy.load`")
    speed, _ = numbers(WHOLE, "slower than bare `scipy.fft` (# to # times its speed)")
    table = []
    peer = ROOT / "benches/peers/scipy_analyze.py"
    for times, sites in shapes:
        field = part.rng.standard_normal((times, sites))
        path = part.folder / "plain.npy"
        np.save(path, field)
        out, arrays = part.folder / "timed", part.folder / "peer.npz"
        mine = [
            part.program,
            "analyze",
            path,
            "--layout",
            "time-site",
            "--figures",
            "none",
            "--quiet",
            "--threads",
            1,
            "--force",
            "--out",
            out,
        ]
        theirs = [sys.executable, peer, path, "--runs", 1, "--workers", 1, "--out", arrays]
        whole, other, stage, bare = [], [], [], []
        for _ in range(rounds):
            whole.append(of_child(mine, part.folder))
            timings = json.loads((out / "summary.json").read_text())["timings"]
            stage.append(sum(one["seconds"] for one in timings if one["stage"] == "along time"))
            other.append(of_child(theirs, part.folder))
            start = time.perf_counter()
            transform = scipy.fft.rfft(field, axis=0, workers=1)
            bare.append(time.perf_counter() - start)
            del transform
        medians = [statistics.median(values) for values in (whole, other, stage, bare)]
        table.append((f"{times} x {sites}", *medians))
        what = f"{times} x {sites}: analyze, with reading and writing, over the same in SciPy"
        by = f"processor time, medians of {rounds} interleaved rounds"
        ratios = [a / b for a, b in zip(whole, other, strict=True)]
        part.ratio(what, ratios, None, share, where=WHOLE, by=by)
        what = f"{times} x {sites}: stage along time, measures and writing included, over scipy.fft.rfft"
        by = f"time on the clock, medians of {rounds} interleaved rounds; pocketfft, one thread"
        ratios = [a / b for a, b in zip(stage, bare, strict=True)]
        part.ratio(what, ratios, None, 1 / speed, where=WHOLE, by=by)
    part.outcome.series["transforms"] = table

    times, sites = 16384, 300
    field = part.rng.standard_normal((times, sites))
    path = part.field(field)
    mine, theirs = [], []
    words = [
        "coherence",
        path,
        "--segment",
        1024,
        "--threads",
        1,
        "--figures",
        "none",
        "--quiet",
        "--force",
        "--out",
        "timed2",
    ]
    for _ in range(rounds):
        mine.append(of_child([part.program, *words], part.folder))
        call = lambda: scipy.signal.coherence(field[:, :1], field, nperseg=1024, axis=0)  # noqa: E731
        theirs.append(of_call(call)[0])
    ratios = [a / b for a, b in zip(theirs, mine, strict=True)]
    what = f"{times} x {sites}: scipy.signal.coherence takes so many times as long as the command"
    by = f"processor time, medians of {rounds} interleaved rounds"
    part.ratio(what, ratios, 3.5, None, where=f"{PERFORMANCE}, Estimates and Python", by=by)


PARTS = [chains, transforms]
