"""The whole command against the bound of its data: `python benches/whole_bound.py` (with NumPy).

Builds the program, makes a field of 16384 times and 300 sites, and in each round does in turn:

- bound: the field read by read() into 1 MiB, and as many bytes as the results have written by
  write() from 1 MiB to a new file, both by one thread, all in the page cache;
- `cascade analyze` without figures, by two threads and by one; and with them, by two.

Times are from exec to exit. Writes benches/runs/<date>-<cpu>/whole_bound.json and .md.
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
import time

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
SHAPE = 16384, 300
PIECE = 1 << 20
RUNS = {"two threads": ("2", "none"), "one thread": ("1", "none"), "with figures": ("2", "png")}


def make_field(path):
    values = numpy.random.default_rng(1).standard_normal(SHAPE).cumsum(axis=0)
    numpy.save(path, values - values.mean(0))


def plain(field, size, target):
    """Seconds to read `field` and to write `size` bytes to `target`."""
    piece = bytearray(os.urandom(PIECE))
    start = time.perf_counter()
    source = os.open(field, os.O_RDONLY)
    while os.readv(source, [piece]):
        pass
    os.close(source)
    sink = os.open(target, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
    left = size
    while left:
        left -= os.write(sink, memoryview(piece)[: min(left, PIECE)])
    os.close(sink)
    seconds = time.perf_counter() - start
    os.unlink(target)
    return seconds


def analyzed(program, field, out, threads, figures):
    """Seconds of the command, and the bytes it left."""
    command = [program, "analyze", field, "--dt", "1e-6", "--dx", "0.01", "--quiet"]
    command += ["--figures", figures, "--threads", threads, "--out", out]
    start = time.perf_counter()
    subprocess.run(list(map(str, command)), check=True)
    seconds = time.perf_counter() - start
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    shutil.rmtree(out)
    return seconds, size


def machine():
    cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return {
        "cpu": cpu[1] if cpu else "unknown",
        "cores": os.cpu_count(),
        "load_before": os.getloadavg(),
        "kernel": os.uname().release,
    }


def table(record):
    about = ", ".join(f"{key} {value}" for key, value in record["machine"].items())
    yield f"# The whole command against reading and writing\n\n{about}.\n"
    yield f"`{record['command']}`; {record['runs']} rounds, milliseconds; the ratio is the median of"
    yield "those of the rounds.\n"
    yield "| what | median | least | over the bound |\n|---|---|---|---|"
    bound = record["seconds"]["bound"]
    for name, seconds in record["seconds"].items():
        ratio = statistics.median(s / b for s, b in zip(seconds, bound))
        middle, least = 1e3 * statistics.median(seconds), 1e3 * min(seconds)
        yield f"| {name} | {middle:.1f} | {least:.1f} | {ratio:.2f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--program", type=pathlib.Path, help="instead of building it")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "target/bench-work",
                        help="where field and results lie while it runs")
    asked = parser.parse_args()
    program = asked.program or ROOT / "target/release/cascade"
    if not asked.program:
        subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=ROOT, check=True)
    asked.work.mkdir(parents=True, exist_ok=True)
    field, out = asked.work / "field.npy", asked.work / "result"
    make_field(field)
    about = machine()
    _, size = analyzed(program, field, out, *RUNS["two threads"])

    seconds = {name: [] for name in ["bound", *RUNS]}
    for _ in range(asked.runs):
        seconds["bound"].append(plain(field, size, asked.work / "plain"))
        for name, (threads, figures) in RUNS.items():
            seconds[name].append(analyzed(program, field, out, threads, figures)[0])
    field.unlink()

    record = {
        "machine": about | {"load_after": os.getloadavg()},
        "command": f"python benches/whole_bound.py --runs {asked.runs}",
        "runs": asked.runs,
        "seconds": seconds,
    }
    text = "\n".join(table(record)) + "\n"
    if not asked.program:
        cpu = re.sub(r"[^a-z0-9]+", "-", about["cpu"].lower()).strip("-")
        folder = ROOT / f"benches/runs/{datetime.date.today()}-{cpu}"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "whole_bound.json").write_text(json.dumps(record, indent=1) + "\n")
        (folder / "whole_bound.md").write_text(text)
    print(text)


main()
