"""The whole command against SciPy in one run: `target/peers/bin/python benches/whole_command.py`.

Builds the program, makes the fields, then runs in turn, pinned to the same cores with the same
number of threads, every program writing its arrays:

- process: exec to exit, for Python with its imports;
- stages: one spectrum asked for alone, from a field in memory or page cache, by bare scipy.fft,
  the quicker of its two calls and nothing written. The times of `cascade` hold more: measures of
  each spectrum, maps, and writing the array.

Then the time from exec to the first byte of output. Needs `benches/peers/install.sh` and Linux.
Writes benches/runs/<date>-<cpu>/whole_command.json and .md.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import time

import numpy
import scipy

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/cascade"
PEER = ROOT / "benches/peers/scipy_analyze.py"
NAMES = "cascade", "scipy.fft", "scipy.signal"
SHAPES = (16384, 300), (65536, 1024), (10007, 301)
# Name for the program, name for the peer, stages of the program that make it.
STAGES = {
    "along time": ("temporal", "time", ("along time",)),
    "along space": ("spatial", "space", ("along space",)),
    "space-time": ("spacetime", "spacetime", ("along time", "space-time")),
}


def make_field(work, shape):
    path = work / f"{shape[0]}x{shape[1]}.npy"
    numpy.save(path, numpy.random.default_rng(1).standard_normal(shape))
    return path


def timed(command):
    start = time.perf_counter()
    before = os.times()
    done = subprocess.run(command, check=True, capture_output=True)
    after = os.times()
    cpu = sum(after[2:4]) - sum(before[2:4])
    return time.perf_counter() - start, cpu, done.stdout


def compare(contestants, runs):
    """Runs of all contestants in turn: name -> list of what each returned."""
    seen = {name: [] for name in contestants}
    for _ in range(runs):
        for name, run in contestants.items():
            seen[name].append(run())
    return seen


def processes(field, work, pin, threads, runs):
    out, arrays = work / "result", work / "result.npz"
    cascade = [PROGRAM, "analyze", field, "--figures", "none", "--quiet"]
    cascade += ["--threads", str(threads), "--force", "--out", out]
    peer = [sys.executable, PEER, field, "--runs", "1", "--workers", str(threads), "--out", arrays]

    def run(command):
        seconds, cpu, _ = timed([*pin, *map(str, command)])
        shutil.rmtree(out, ignore_errors=True)
        arrays.unlink(missing_ok=True)
        return seconds, cpu

    return compare(
        {
            "cascade": lambda: run(cascade),
            "scipy.fft": lambda: run([*peer, "--with", "fft"]),
            "scipy.signal": lambda: run([*peer, "--with", "signal"]),
        },
        runs,
    )


def stages(field, work, pin, threads, runs):
    def program(only, parts):
        out = work / "result"
        command = [PROGRAM, "analyze", field, "--figures", "none", "--json", "--only", only]
        command += ["--threads", str(threads), "--force", "--out", out]
        summary = json.loads(timed([*pin, *map(str, command)])[2])
        shutil.rmtree(out)
        return sum(t["seconds"] for t in summary["timings"] if t["stage"] in parts)

    def peer(only):
        command = [sys.executable, PEER, field, "--runs", "2", "--only", only]
        command += ["--workers", str(threads)]
        return min(json.loads(timed([*pin, *map(str, command)])[2])["runs_s"])

    return {
        stage: compare(
            {
                "cascade": lambda: program(ours, parts),
                "scipy.fft": lambda: peer(theirs),
            },
            runs,
        )
        for stage, (ours, theirs, parts) in STAGES.items()
    }


def first_byte(command, runs=21):
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        with subprocess.Popen([*map(str, command)], stdout=subprocess.PIPE) as child:
            child.stdout.read(1)
            seconds.append(time.perf_counter() - start)
            child.stdout.read()
    return seconds


def said(*command):
    return subprocess.run(command, capture_output=True, text=True).stdout.strip()


def machine():
    cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return {
        "cpu": cpu[1] if cpu else "unknown",
        "cores": os.cpu_count(),
        "load_before": os.getloadavg(),
        "kernel": os.uname().release,
        "rustc": said("rustc", "--version"),
        "cascade": said(str(PROGRAM), "--version"),
        "commit": said("git", "-C", str(ROOT), "rev-parse", "--short", "HEAD"),
        "python": sys.version.split()[0],
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
    }


def table(record):
    yield "# The whole command against SciPy\n"
    about = record["machine"]
    yield ", ".join(f"{key} {value}" for key, value in about.items()) + ".\n"
    yield f"`{record['command']}`; medians of {record['runs']} runs in turn, seconds; the ratio is"
    yield "the better of the peers over cascade; CPU time is user and system.\n"
    yield "| field | threads | what | cascade | scipy.fft | scipy.signal | ratio | ratio of CPU |"
    yield "|---|---|---|---|---|---|---|---|"
    for row in record["rows"]:
        seconds = row["seconds"]
        whole = row["what"] == "process"
        of = lambda name, part: statistics.median(r[part] if whole else r for r in seconds[name])
        wall = {name: of(name, 0) for name in seconds}
        ratio = min(s for name, s in wall.items() if name != "cascade") / wall["cascade"]
        cells = [row["field"], row["threads"], row["what"]]
        cells += [f"{wall[n]:.4f}" if n in wall else "" for n in NAMES] + [f"{ratio:.2f}"]
        if whole:
            used = {name: of(name, 1) for name in seconds}
            cells.append(f"{min(used[n] for n in NAMES[1:]) / used['cascade']:.2f}")
        yield "| " + " | ".join(map(str, cells)) + " |"
    yield "\nFrom exec to the first byte, ms (median, largest):\n"
    for what, seconds in record["first_byte"].items():
        middle, largest = 1e3 * statistics.median(seconds), 1e3 * max(seconds)
        yield f"- `cascade {what}`: {middle:.1f}, {largest:.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "target/bench-work",
                        help="where fields and results lie while it runs")
    asked = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=ROOT, check=True)
    asked.work.mkdir(parents=True, exist_ok=True)

    about, rows, starts = machine(), [], {}
    every = sorted(os.sched_getaffinity(0))
    for shape in SHAPES:
        field = make_field(asked.work, shape)
        for cores in [every[:1], every]:
            threads = len(cores)
            pin = ["taskset", "-c", ",".join(map(str, cores))]
            common = {"field": field.stem, "threads": threads}
            print(field.stem, threads, "threads", file=sys.stderr)
            seen = processes(field, asked.work, pin, threads, asked.runs)
            rows.append({**common, "what": "process", "seconds": seen})
            for stage, seen in stages(field, asked.work, pin, threads, asked.runs).items():
                rows.append({**common, "what": stage, "seconds": seen})
        if not starts:
            starts["--version"] = first_byte([PROGRAM, "--version"])
            starts["analyze FIELD --plan"] = first_byte([PROGRAM, "analyze", field, "--plan"])
        field.unlink()

    record = {
        "machine": about,
        "command": f"python benches/whole_command.py --runs {asked.runs}",
        "runs": asked.runs,
        "rows": rows,
        "first_byte": starts,
    }
    cpu = re.sub(r"[^a-z0-9]+", "-", about["cpu"].lower()).strip("-")
    folder = ROOT / f"benches/runs/{datetime.date.today()}-{cpu}"
    folder.mkdir(parents=True, exist_ok=True)
    text = "\n".join(table(record)) + "\n"
    (folder / "whole_command.json").write_text(json.dumps(record, indent=1) + "\n")
    (folder / "whole_command.md").write_text(text)
    print(text)


main()
