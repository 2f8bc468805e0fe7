#!/usr/bin/env python3
"""Runs the program over and over and looks for growth of memory and of files.

Usage: soak.py PROGRAM MINUTES

Half of the time goes to one long sweep, whose resident memory is sampled once a second, less the length
of its journal: a sweep holds a row for each member that is known. Half goes to short runs of analyze,
filter, simulate and budget, each over the last result of its kind, whose peaks are compared. Ends with code
1 if memory in the last quarter is above that in the second by more than 3 %, or if a file remains that the
first round had not left.
"""

import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

program, minutes = pathlib.Path(sys.argv[1]).resolve(), float(sys.argv[2])
MOST_GROWTH = 1.03


def resident(process):
    """Resident memory in bytes; None once the process has ended."""
    try:
        pages = pathlib.Path(f"/proc/{process.pid}/statm").read_text().split()[1]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")
    except (FileNotFoundError, ProcessLookupError, IndexError):
        return None


def quarters(values):
    """Medians of the second and of the last quarter: the first warms up."""
    n = len(values) // 4
    return statistics.median(values[n : 2 * n]), statistics.median(values[-n:])


def long_sweep(directory, seconds):
    """Samples of one sweep that is stopped after this time."""
    members = int(100 * seconds) + 100
    words = ["sweep", "--vary", f"stiffness_ratio=1:9:{members}", "--sites", "12", "--samples", "2",
             "--end-time", "20", "--out", "swept", "--quiet"]
    process = subprocess.Popen([program, *words], cwd=directory, stderr=subprocess.DEVNULL)
    end, samples = time.time() + seconds, []
    journal = directory / "swept" / "members.jsonl"
    while time.time() < end and process.poll() is None:
        time.sleep(min(1.0, seconds / 40))
        held, rows = resident(process), journal.stat().st_size if journal.exists() else 0
        # The scenes of all members are checked before the first of them runs.
        if rows:
            samples.append(held and held - rows)
    process.terminate()
    process.wait()
    return [sample for sample in samples if sample]


def peak(directory, *words):
    """Peak of the resident memory of one run, in bytes."""
    process = subprocess.Popen([program, *words], cwd=directory, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{' '.join(words)}: exit code {os.waitstatus_to_exitcode(status)}")
    return usage.ru_maxrss * 1024


def names(directory):
    return sorted(str(path.relative_to(directory)) for path in directory.rglob("*"))


def short_runs(directory, seconds):
    """Peaks of each command, and names of all files after the first and after the last round."""
    rounds = {
        "simulate": ["simulate", "--sites", "40", "--samples", "512", "--end-time", "60", "--out", "run.npz"],
        "analyze": ["analyze", "run.npz", "--out", "analysis", "--figures", "png"],
        "filter": ["filter", "run.npz", "--frequency", "0.05:0.2", "--out", "filtered.npy"],
        "budget": ["budget", "run.npz", "--out", "budget", "--figures", "none"],
    }
    peaks, first, end = {name: [] for name in rounds}, None, time.time() + seconds
    while time.time() < end or len(peaks["budget"]) < 8:
        for name, words in rounds.items():
            peaks[name].append(peak(directory, *words, "--force", "--quiet"))
        first = first or names(directory)
    return peaks, first, names(directory)


def main():
    grown = False
    with tempfile.TemporaryDirectory() as place:
        directory = pathlib.Path(place)
        series = {"sweep": long_sweep(directory, 30 * minutes)}
        (directory / "short").mkdir()
        peaks, first, last = short_runs(directory / "short", 30 * minutes)
    for name, values in (series | peaks).items():
        early, late = quarters(values)
        grown |= late > MOST_GROWTH * early
        print(f"{name}: {len(values)} values, {early / 1e6:.1f} MB early, {late / 1e6:.1f} MB late")
    print(f"files: {len(first)} after the first round, {len(last)} after the last")
    for name in sorted(set(last) - set(first)):
        print(f"left behind: {name}")
    sys.exit(1 if grown or first != last else 0)


main()
