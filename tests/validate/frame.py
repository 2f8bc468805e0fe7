"""The frame of all parts: the program as its users call it, and claims with their truth and verdict."""

import contextlib
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import time
import traceback
import zlib
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import binom

#: Chance by which a row on random draws fails although its claim is right.
CHANCE = 1e-4


@dataclass
class Row:
    what: str
    where: str
    by: str
    found: str
    allowed: str
    #: None: the machine was too busy to tell.
    holds: bool | None
    #: Of a difference, what it is of the allowed one.
    share: float | None = None


@dataclass
class Outcome:
    """What a part found, as it comes back from its process."""

    name: str
    title: str
    rows: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    series: dict = field(default_factory=dict)
    seconds: float = 0.0


def short(value):
    """A number with as many digits as matter."""
    if isinstance(value, str | bool):
        return str(value)
    if isinstance(value, int | np.integer):
        return str(int(value))
    value = float(value)
    if value != 0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.2e}".split("e")
        return f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    return f"{value:.4g}"


class Part:
    """A part of a family. `where` is the document that makes a claim, `by` is the truth."""

    def __init__(self, name, title, program, folder, seed, quick):
        self.outcome = Outcome(name, title)
        self.program, self.quick = str(program), quick
        self.folder = pathlib.Path(folder, name)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.rng = np.random.default_rng([seed, zlib.crc32(name.encode())])

    # Claims.

    def row(self, what, where, by, found, allowed, holds, share=None):
        holds = None if holds is None else bool(holds)
        self.outcome.rows.append(Row(what, where, by, short(found), short(allowed), holds, share))

    def claim(self, what, truth, found, allowed, *, where, by, scale=None):
        """The largest difference over `scale` is at most `allowed`. NaN in one alone differs."""
        truth, found = np.asarray(truth), np.asarray(found)
        if truth.shape != found.shape:
            return self.row(what, where, by, f"shape {found.shape} for {truth.shape}", allowed, False)
        both = np.isnan(truth) & np.isnan(found)
        apart = np.where(both, 0, np.abs(np.where(both, 0, truth) - np.where(both, 0, found)))
        scale = 1.0 if scale is None else scale
        worst = float(np.max(apart / scale)) if apart.size else np.nan
        self.row(what, where, by, worst, allowed, worst <= allowed, worst / allowed)

    def within(self, what, found, low, high, *, where, by):
        """A number lies between two others; `None` is no limit."""
        words = {
            (False, True): f"at most {short(high or 0)}",
            (True, False): f"at least {short(low or 0)}",
        }
        allowed = words.get(
            (low is not None, high is not None), f"{short(low or 0)} to {short(high or 0)}"
        )
        holds = (low is None or found >= low) and (high is None or found <= high)
        self.row(what, where, by, found, allowed, holds)

    def ratio(self, what, ratios, low, high, *, where, by):
        """The median of ratios of times in interleaved rounds.

        It is not decided against a bound by rounds that differ about it, or on a busy machine.
        """
        found = statistics.median(ratios)
        inside = [(low is None or r >= low) and (high is None or r <= high) for r in (found, *ratios)]
        is_busy = os.getloadavg()[0] > os.cpu_count()
        holds = inside[0] or (None if any(inside) or is_busy else False)
        allowed = f"at least {short(low)}" if high is None else f"at most {short(high)}"
        self.row(what, where, by, found, allowed, holds)

    def same(self, what, truth, found, *, where, by):
        """Words, or whatever is compared as it is."""
        self.row(what, where, by, str(found), str(truth), truth == found)

    def covers(self, what, held, count, stated=0.95, *, where, by, wide=False):
        """As many independent intervals hold the truth as stated, within the binomial band; `wide` ones
        may hold more often."""
        low, high = stated if isinstance(stated, tuple) else (stated, stated)
        least = int(binom.ppf(CHANCE / 2, count, low))
        most = count if wide else int(binom.ppf(1 - CHANCE / 2, count, high))
        share = f"{low:.1%}" if low == high else f"{low:.1%} to {high:.1%}"
        share += " or more" if wide else ""
        text = f"{held} of {count} ({held / max(count, 1):.1%})"
        self.outcome.series.setdefault("coverage", []).append((what, held, count, least, most))
        self.row(
            what, where, by, text, f"{least} to {most} ({share})", count > 0 and least <= held <= most
        )

    def none_of(self, what, bad, count, *, where, by):
        """No case of many is bad."""
        self.row(what, where, by, f"{bad} of {count}", "0", bad == 0 and count > 0)

    def note(self, text):
        self.outcome.notes.append(text)

    # The program.

    def run(self, *words, code=0):
        """What the program printed; a number of exit codes may be right."""
        codes = code if isinstance(code, tuple) else (code,)
        command = [self.program, *map(str, words)]
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder)
        if done.returncode not in codes:
            raise RuntimeError(
                f"{' '.join(command)}\nexit code {done.returncode}: {done.stderr.strip()[:1500]}"
            )
        return done

    def estimate(self, command, *words, threads=1):
        """`summary.json` and the arrays of a command that writes a directory."""
        out = self.folder / f"out-{command}"
        shutil.rmtree(out, ignore_errors=True)
        words = [command, *words, "--out", out, "--figures", "none", "--quiet"]
        self.run(*words, *([] if threads is None else ["--threads", threads]))
        summary = json.loads((out / "summary.json").read_text())
        arrays = {}
        for file in out.glob("*.npz"):
            with np.load(file) as stored:
                arrays.update({name: stored[name] for name in stored})
        return summary, arrays

    def analyzed(self, values, *words, **about):
        return self.estimate("analyze", self.field(values, **about), *words)

    def field(self, values, dt=1.0, dx=1.0, name="field", unit="m/s"):
        """A file with its axes beside it."""
        path = self.folder / f"{name}.npy"
        np.save(path, values)
        text = f'layout = "time-site"\ndt = "{dt!r} s"\ndx = "{dx!r} m"\nquantity = "velocity"\n'
        text += f'unit = "{unit}"\n'
        path.with_suffix(".toml").write_text(text)
        return path

    def simulated(self, scene, *words, name="run", code=0):
        """The arrays of a run, and its report."""
        path = self.folder / f"{name}.toml"
        path.write_text(scene)
        out = self.folder / f"{name}.npz"
        self.run("simulate", path, *words, "--out", out, "--force", "--quiet", code=code)
        with np.load(out) as stored:
            arrays = {key: stored[key] for key in stored}
        return arrays, json.loads(str(arrays["report"]))


def scene_text(**keys):
    return "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())


def carried_out(function, program, folder, seed, quick):
    """One part in a process of its own. What ends it early is a row that fails, never silence."""
    name = f"{function.__module__}-{function.__name__}"
    part = Part(name, function.__doc__.strip().splitlines()[0], program, folder, seed, quick)
    start = time.perf_counter()
    try:
        function(part)
    except Exception as fault:
        said = f"{type(fault).__name__}: {fault}"
        part.row("the part is carried out to its end", "", "", said[:240], "no error", False)
        part.note("".join(traceback.format_exception(fault)[-2:]))
    part.outcome.seconds = time.perf_counter() - start
    with contextlib.suppress(OSError):
        shutil.rmtree(part.folder)
    return part.outcome
