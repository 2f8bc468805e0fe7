"""One document of proof from one run: claims of the README and the docs against independent truth.

    ./validate [--quick] [--seed N] [--program PATH] [--out DIR]

Prints how many of how many claims hold, then those that do not. Exit code 1 if any fails.
"""

import argparse
import concurrent.futures
import datetime
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))

import chains
import documents
import energy
import frame
import intervals
import jinja2
import mpmath
import numpy
import promises
import scipy
import spectra
import speed
import unverified
import verdicts
import waves

import figures

FAMILIES = [
    ("spectra", "Spectra and estimates", spectra),
    ("intervals", "Intervals", intervals),
    ("verdicts", "Verdicts in words", verdicts),
    ("chains", "Chains", chains),
    ("energy", "Budgets, measurements and fits", energy),
    ("waves", "Localized waves and the paper", waves),
    ("promises", "What is printed, and files", promises),
    ("speed", "Speed", speed),
]


def asked():
    parser = argparse.ArgumentParser(prog="./validate", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer draws and rounds, in two minutes")
    parser.add_argument(
        "--seed", type=int, default=1, help="of all random fields and chains (default: 1)"
    )
    parser.add_argument(
        "--program", type=pathlib.Path, required=True, help="default: the one that is built"
    )
    parser.add_argument(
        "--out", type=pathlib.Path, default=pathlib.Path("validation"), help="folder of the document"
    )
    parser.add_argument("--only", help="families to carry out, separated by commas (for work on them)")
    return parser.parse_args()


def carried_out(options, folder):
    """Families with their parts. Two at once, but for times, which are measured alone."""
    wanted = set(options.only.split(",")) if options.only else {name for name, *_ in FAMILIES}
    families = [(name, title, module) for name, title, module in FAMILIES if name in wanted]
    given = options.program, folder, options.seed, options.quick
    jobs = {}
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        for name, _, module in families:
            for part in module.PARTS if name != "speed" else []:
                jobs[part] = pool.submit(frame.carried_out, part, *given)
        for part, job in jobs.items():
            print(f"{part.__module__}: {part.__doc__.splitlines()[0]}", file=sys.stderr, flush=True)
            concurrent.futures.wait([job])
    found = []
    for name, title, module in families:
        if name == "speed":
            parts = [frame.carried_out(part, *given) for part in module.PARTS]
        else:
            parts = [jobs[part].result() for part in module.PARTS]
        rows = [row for part in parts for row in part.rows]
        good = sum(row.holds is True for row in rows)
        found.append({"name": name, "title": title, "parts": parts, "good": good, "count": len(rows)})
    return found


def machine():
    """The processor, and what it has."""
    name = platform.processor() or platform.machine()
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{name}, {os.cpu_count()} cores, {platform.system()} {platform.release()}"


def printed(page):
    """A PDF beside the page, where something at hand makes it."""
    target = page.with_suffix(".pdf")
    browser = next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
    )
    weasyprint = shutil.which("weasyprint")
    if browser:
        words = [browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer"]
        command = [*words, f"--print-to-pdf={target.resolve()}", page.resolve().as_uri()]
    elif weasyprint:
        command = [weasyprint, page, target]
    else:
        return None
    done = subprocess.run([str(word) for word in command], capture_output=True, timeout=180)
    return target if done.returncode == 0 and target.exists() else None


def main():
    options = asked()
    options.program = options.program.resolve()
    start = time.perf_counter()
    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory(prefix="cascade-validate-") as folder:
        families = carried_out(options, folder)
    seconds = time.perf_counter() - start
    rows = [row for family in families for part in family["parts"] for row in part.rows]
    failures = [row for row in rows if row.holds is False]
    open_rows = [row for row in rows if row.holds is None]
    version = subprocess.run(
        [options.program, "--version"], capture_output=True, text=True
    ).stdout.strip()
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, cwd=ROOT
    ).stdout.strip()
    stated = documents.number("README.md", "holds # claims of these pages")
    if options.quick and not options.only and stated != len(rows):
        print(f"README.md: it states {stated:.0f} claims, {len(rows)} were held", file=sys.stderr)
    good = sum(row.holds is True for row in rows)
    headline = f"{good} of {len(rows)} claims hold"
    if open_rows:
        headline += f", {len(open_rows)} not decided"
    packages = {"NumPy": numpy, "SciPy": scipy, "mpmath": mpmath, "matplotlib": figures.matplotlib}
    facts = [
        ("machine", machine()),
        ("load at the start", f"{load:.2f}"),
        ("program", f"{version}, commit {commit or 'unknown'}"),
        ("Python", platform.python_version()),
        *((name, package.__version__) for name, package in packages.items()),
        ("seed", options.seed),
        ("whole run", f"{seconds:.0f} s"),
        *(
            (f"seconds: {part.title}", f"{part.seconds:.1f}")
            for family in families
            for part in family["parts"]
        ),
    ]
    words = " --quick" if options.quick else ""
    template = jinja2.Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        (HERE / "page.html").read_text()
    )
    told = dict(
        headline=headline, failed=len(failures), failures=failures, families=families, facts=facts
    )
    told |= dict(figures=figures.all_of(families), unverified=unverified.CLAIMS, version=version)
    told |= dict(machine=machine(), seed=options.seed, quick=options.quick, chance=frame.CHANCE)
    told |= dict(date=datetime.date.today().isoformat(), minutes=f"{seconds / 60:.1f} minutes")
    page = template.render(told, command=f"./validate{words} --seed {options.seed}")
    options.out.mkdir(parents=True, exist_ok=True)
    target = options.out / "validation.html"
    target.write_text(page)
    print(headline)
    for row in open_rows:
        print(f"not decided on this machine now: {row.what}: found {row.found}, allowed {row.allowed}")
    for row in failures:
        print(f"fails: {row.what}: found {row.found}, allowed {row.allowed} ({row.where})")
    made = [target, printed(target)]
    print("document:", ", ".join(str(document) for document in made if document))
    return 1 if failures or not rows else 0


if __name__ == "__main__":
    sys.exit(main())
