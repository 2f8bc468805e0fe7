"""Time against error of `cascade` and its peers on impacted dimer chains, in one run.

    python3 benches/peers/chain/run.py

Builds benches/peers/chain/cascade_rows.rs, installs the peers into target/peers/chain, makes the
references (tests/data/chain_reference.py, double-double arithmetic), then calls all programs in
turn, round after round, each pinned to the same core. Writes
benches/runs/<date>-<cpu>/chain.json, every run of it, and chain.md. A time is the CPU time of one
simulation, the median over all runs; the wall-clock time is kept beside it. Needs Linux, cargo,
g++ and PyPI. `cargo run --release -p figures --bin chain_work_precision` draws the record.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys

import peer

HERE = pathlib.Path(__file__).resolve().parent
KAPPAS = "1", "4.9272", "14.622", "1631"
SITES, END, SAMPLES = 300, 295, 64
PEERS = "scipy_dop853", "numba_verlet", "odeint", "lammps_granular", "diffrax_dopri8"
ERRORS = 1e-2, 1e-4, 1e-6, 1e-8, 1e-10


def said(*command):
    return subprocess.run(command, capture_output=True, text=True).stdout.strip()


def machine(core):
    cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return {
        "cpu": cpu[1] if cpu else "unknown",
        "core": core,
        "load_before": os.getloadavg(),
        "kernel": os.uname().release,
        "rustc": said("rustc", "--version"),
        "compiler": said("g++", "--version").splitlines()[0],
        "commit": said("git", "-C", str(peer.ROOT), "rev-parse", "--short", "HEAD"),
        "peers": {
            name.parent.name: name.read_text().split()
            for name in sorted(peer.HOME.glob("*/requirements.txt"))
        },
    }


def references(kappas):
    python = peer.installed("reference", ["numpy==2.4.6"])
    files = {}
    for kappa in kappas:
        files[kappa] = peer.HOME / f"reference/dimer{SITES}_{kappa}.npz"
        if not files[kappa].exists():
            # Beside it first, so that an interrupted run leaves no half of a file.
            part = files[kappa].with_name(f"part_{kappa}.npz")
            command = [python, peer.ROOT / "tests/data/chain_reference.py", "dimer"]
            subprocess.run([*map(str, [*command, SITES, kappa, END, SAMPLES, part])], check=True)
            part.rename(files[kappa])
    return files


def cascade():
    build = ["cargo", "build", "--locked", "--release", "--quiet", "--example", "cascade_rows"]
    subprocess.run(build, cwd=peer.ROOT, check=True)
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", peer.ROOT / "target"))
    return [target / "release/examples/cascade_rows"]


def measured(commands, files, rounds, runs, core):
    """Rows of all rounds, the runs of each setting together."""
    rows = {}
    for kappa, file in files.items():
        for turn in range(rounds):
            for name, command in commands.items():
                print(f"kappa {kappa}, round {turn + 1}: {name}", file=sys.stderr)
                asked = ["--reference", file, "--kappa", kappa, "--runs", runs]
                pinned = ["taskset", "-c", core, *command, *asked]
                done = subprocess.run([*map(str, pinned)], stdout=subprocess.PIPE, text=True)
                if done.returncode != 0:
                    sys.exit(f"{name} ended with {done.returncode}")
                for line in done.stdout.splitlines():
                    row = json.loads(line)
                    for times in ("seconds", "cpu_seconds"):
                        row[times] = [round(s, 7) for s in row[times]]
                    key = row["program"], row["scheme"], row["kappa"], row["setting"]
                    kept = rows.setdefault(key, row)
                    assert kept["error"] == row["error"], (kept, row)
                    if kept is not row:
                        kept["seconds"] += row["seconds"]
                        kept["cpu_seconds"] += row["cpu_seconds"]
    for row in rows.values():
        row["time_ms"] = round(1e3 * statistics.median(row["cpu_seconds"]), 4)
        row["wall_ms"] = round(1e3 * statistics.median(row["seconds"]), 4)
    return list(rows.values())


def least(rows, error):
    """The least time at which a row is at most this wrong."""
    return min((r["time_ms"] for r in rows if r["error"] <= error), default=None)


def table(record):
    about, rows = record["machine"], record["rows"]
    yield "# Time against error on impacted dimer chains\n"
    said_of = [f"{key} {about[key]}" for key in ("cpu", "kernel", "rustc", "compiler", "commit")]
    yield ", ".join([*said_of, f"load before {about['load_before'][0]:.2f}"]) + ".\n"
    yield "; ".join(f"{name}: {' '.join(v)}" for name, v in about["peers"].items()) + ".\n"
    yield f"`{record['command']}`: {SITES} sites to {END}, velocities at {SAMPLES} times, one core."
    yield "Least CPU time in ms, the median of its runs, at which the largest error of any velocity"
    yield "at any sample, against a reference in double-double arithmetic, is at most that above the"
    yield "column; a blank: not reached at any setting tried. The last column is the least factor by"
    yield "which `cascade` (`nystrom`) was quicker than a setting of this scheme with an error below"
    yield "1e-4, at that setting's own error or a smaller one."
    for kappa in sorted({row["kappa"] for row in rows}):
        here = [row for row in rows if row["kappa"] == kappa]
        own = [r for r in here if (r["program"], r["scheme"]) == ("cascade", "nystrom")]
        yield f"\n## kappa = {kappa:g}\n"
        yield "| program | scheme | " + " | ".join(f"{e:.0e}" for e in ERRORS) + " | factor |"
        yield "|---" * (3 + len(ERRORS)) + "|"
        for program, scheme in dict.fromkeys((r["program"], r["scheme"]) for r in here):
            of = [r for r in here if (r["program"], r["scheme"]) == (program, scheme)]
            times = [least(of, error) for error in ERRORS]
            cells = ["" if t is None else f"{t:.3g}" for t in times]
            factors = [
                r["time_ms"] / quickest
                for r in of
                if r["error"] < 1e-4 and (quickest := least(own, r["error"])) is not None
            ]
            factor = f"{min(factors):.3g}" if factors and of[0] is not own[0] else ""
            yield "| " + " | ".join([program, scheme, *cells, factor]) + " |"


def write(record, folder):
    folder.mkdir(parents=True, exist_ok=True)
    text = "\n".join(table(record)) + "\n"
    lines = ",\n  ".join(json.dumps(row) for row in record["rows"])
    head = json.dumps({k: v for k, v in record.items() if k != "rows"}, indent=1)
    whole = f'{head.removesuffix(chr(10) + "}")},\n "rows": [\n  {lines}\n ]\n}}\n'
    for name, content in [("chain.json", whole), ("chain.md", text)]:
        part = folder / f"{name}.partial"
        part.write_text(content)
        part.rename(folder / name)
    print(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3, help="times that every program is called")
    parser.add_argument("--runs", type=int, default=3, help="runs of a setting in one call")
    parser.add_argument("--kappa", action="append", choices=KAPPAS, help="only this one")
    parser.add_argument("--out", type=pathlib.Path, help="write here, not to benches/runs")
    parser.add_argument("--install", action="store_true", help="install and build, and end")
    asked = parser.parse_args()
    kappas = asked.kappa or KAPPAS

    commands = {"cascade": cascade()}
    for name in PEERS:
        commands[name] = [sys.executable, HERE / f"{name}.py"]
        subprocess.run([*commands[name], "--install"], check=True)
    files = references(kappas)
    if asked.install:
        return
    core = max(os.sched_getaffinity(0))
    about = machine(core)
    record = {
        "machine": about,
        "command": "python3 " + " ".join(["benches/peers/chain/run.py", *sys.argv[1:]]),
        "sites": SITES,
        "end_time": END,
        "samples": SAMPLES,
        "rows": measured(commands, files, asked.rounds, asked.runs, core),
    }
    cpu = re.sub(r"[^a-z0-9]+", "-", about["cpu"].lower()).strip("-")
    write(record, asked.out or peer.ROOT / f"benches/runs/{datetime.date.today()}-{cpu}")


if __name__ == "__main__":
    main()
