"""What the README and the guide print, and what happens to files when a run is killed or fed rubbish."""

import json
import pathlib
import re
import signal
import subprocess
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROBUST = "robustness.md"


def moved_between(field, first, last):
    """U, D and their places of whole records: cumulative spectra of two groups of sites."""
    power = np.abs(np.fft.rfft(field, axis=0)) ** 2
    power[1:-1] *= 2
    share = [np.cumsum(power[:, group].sum(axis=1)) / power[:, group].sum() for group in (first, last)]
    difference = share[0] - share[1]
    return difference.max(), np.argmax(difference), -difference.min()


def printed(part):
    """What the README prints"""
    where = "README.md"
    readme = (ROOT / where).read_text(encoding="utf-8")
    text = re.search(r"# growing_harmonic: (.+?); \.\.\.", readme)[1]
    part.run("examples", "growing_harmonic")
    done = part.run("analyze", "growing_harmonic.npz", "--figures", "none", "--force")
    line = " ".join(done.stdout.split())
    part.same(
        "growing_harmonic: the first line is the README's", True, text in line, where=where, by=text
    )
    with np.load(part.folder / "growing_harmonic.npz") as stored:
        field = max((stored[name] for name in stored), key=lambda a: a.size)
        names = {name: stored[name] for name in stored if stored[name].ndim < 2}
    if field.shape[0] < field.shape[1]:
        field = field.T
    share, site = re.search(r"([\d.]+) ± [\d.]+ % past .+ by site (\d+)", text).groups()
    last = slice(int(site) - 3, int(site) + 1)
    up, at, _ = moved_between(field, slice(0, 4), last)
    t = names.get("time", names.get("t"))
    by = "cumulative spectra of whole records by NumPy"
    part.claim("its share that moved up", float(share) / 100, up, 0.02, where=where, by=by)
    if t is not None and t.ndim == 1:
        df = 1 / (len(field) * (t[1] - t[0]))
        # Nothing lies between the two lines, so that any place there is right.
        part.note(f"largest difference of the cumulative spectra at {at * df:.5g} per unit of time")
    part.run("examples", "dimer")
    for words in re.findall(r"^cascade (simulate dimer.+)$", readme, re.MULTILINE):
        part.run(*words.split(), "--force", "--quiet")
    # The first line, which may be folded, ends where the first fact begins.
    for name, text in re.findall(
        r"^(localized|dispersive): (.+?)\nmoved", readme, re.MULTILINE | re.DOTALL
    ):
        text = " ".join(text.split())
        done = part.run("analyze", f"{name}.npz", "--figures", "none", "--force")
        said = " ".join(done.stdout.split())
        part.same(f"{name}: the first line is the README's", True, text in said, where=where, by=text)

    summary, found = part.estimate("analyze", ROOT / "examples/data/lattice_impact.npy")
    shape = found["spacetime_spectrum"].shape
    part.same(
        "lattice_impact: S(k, f) has (frequency, wavenumber)", (385, 96), shape, where=where, by="README"
    )
    plus = summary["direction"]["toward_plus_x"]
    part.within(
        "lattice_impact: share towards +x",
        plus,
        0.95,
        1.0,
        where=where,
        by="README, struck at its first site",
    )
    k, f, s = (found[name] for name in ("wavenumber_signed", "frequency", "spacetime_spectrum"))
    inside = (k > 0.3 * k.max()) & (k < 0.7 * k.max())
    peak = f[np.argmax(s[:, inside], axis=0)]
    law = np.abs(np.sin(k[inside] / k.max() * np.pi / 2))
    spread = peak / law
    what = "lattice_impact: ridge over the dispersion of equal springs, spread"
    part.within(
        what, float(spread.std() / spread.mean()), None, 0.03, where="figures/README.md", by="|sin(ka/2)|"
    )

    words = [
        "design",
        "--free",
        "angle=2..90",
        "--minimize",
        "peak_force_last",
        "--figures",
        "none",
        "--force",
    ]
    part.run("examples", "quartz_cylinders")
    done = part.run(words[0], "quartz_cylinders.toml", *words[1:])
    said = " ".join(done.stdout.split())
    text = "falls from 314.9 to 200.4 N, 36.38 % less"
    part.same(
        "design of the quartz cylinders prints the guide's",
        True,
        text in said,
        where="guide/design.md",
        by=text,
    )

    # What the guide prints, and what made the records.
    told = {
        "young": (70.306, 70.4),
        "striker_velocity": (0.8312, 0.83),
        "tangent": (0.6053, 0.6),
        "angle": (17.969, 18),
    }
    data = ROOT / "examples/data"
    words = [data / "impact_records.csv", data / "impact_scene.toml", "--bodies", "2,4,6,8,10,12"]
    free = "young=60GPa..85GPa,striker_velocity,tangent=0..5us,angle"
    summary, _ = part.estimate("fit", *words, "--free", free, threads=2)
    for value in summary["values"]:
        printed, right = told[value["name"]]
        # The summary may be in base units.
        scale = 10.0 ** round(np.log10(printed / value["value"]))
        found = value["value"] * scale
        what = f"fit of impact_records: {value['name']}, relative"
        part.claim(
            what,
            printed,
            found,
            1e-4,
            where="guide/fit.md",
            by=f"printed there: {printed}",
            scale=printed,
        )
        error = (value["high"] - value["low"]) / 2 * scale / 1.96
        what = f"and its distance from the truth in standard errors: {value['name']}"
        by = f"{right:g}, of the chain that made the records"
        part.within(what, abs(found - right) / error, None, 3.0, where="guide/fit.md", by=by)


def killed(part):
    """Runs that are killed, and files of rubbish"""
    count = 10 if part.quick else 40
    field = part.rng.standard_normal((4096, 256))
    path = part.field(field)
    out = part.folder / "result"
    words = [part.program, "analyze", path, "--out", out, "--figures", "none", "--quiet"]
    subprocess.run([*words, "--force"], check=True, cwd=part.folder, capture_output=True)
    start = time.perf_counter()
    subprocess.run([*words, "--force"], check=True, cwd=part.folder, capture_output=True)
    took = time.perf_counter() - start
    whole = sorted(file.name for file in out.iterdir())
    broken = 0
    for _ in range(count):
        child = subprocess.Popen(
            [*words, "--force"], cwd=part.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        time.sleep(part.rng.uniform(0, 1.2 * took))
        child.send_signal(signal.SIGKILL)
        child.wait()
        try:
            json.loads((out / "summary.json").read_text())
            with np.load(out / "spectra.npz") as stored:
                complete = all(stored[name].size > 0 for name in stored)
            complete &= sorted(file.name for file in out.iterdir()) == whole
        except Exception:
            complete = False
        broken += not complete
    what = "results that are not whole after a run that replaces them was killed"
    part.none_of(what, broken, count, where=f"{ROBUST}, Results", by="names and contents of the files")
    subprocess.run([*words, "--force"], check=True, cwd=part.folder, capture_output=True)
    left = [file.name for file in part.folder.iterdir() if file.name.startswith(".cascade-partial")]
    part.same(
        "working files that are left after the next run",
        0,
        len(left),
        where=f"{ROBUST}, Results",
        by="the folder",
    )

    count = 60 if part.quick else 300
    np.save(part.folder / "small.npy", part.rng.standard_normal((64, 8)))
    np.savez(part.folder / "small.npz", velocity=part.rng.standard_normal((64, 8)), time=np.arange(64.0))
    np.savetxt(part.folder / "small.csv", part.rng.standard_normal((64, 8)), delimiter=",")
    bad = []
    for number in range(count):
        source = part.folder / ("small.npy", "small.npz", "small.csv")[number % 3]
        content = bytearray(source.read_bytes())
        for _ in range(part.rng.integers(1, 8)):
            content[part.rng.integers(0, len(content))] = part.rng.integers(0, 256)
        if part.rng.random() < 0.3:
            content = content[: part.rng.integers(0, len(content))]
        target = part.folder / f"mutated{source.suffix}"
        target.write_bytes(bytes(content))
        done = subprocess.run(
            [part.program, "analyze", target, "--layout", "time-site", "--figures", "none", "--quiet",
             "--force", "--out", part.folder / "rubbish", "--memory", "200MB"],
            capture_output=True, text=True, cwd=part.folder, timeout=60,
        )  # fmt: skip
        if done.returncode not in (0, 1, 2) or (done.returncode and not done.stderr.strip()):
            bad.append(
                f"{target.name} of case {number}: exit code {done.returncode}, {done.stderr[:200]!r}"
            )
    what = "mutated files that end the program in any way but a result or a sentence"
    part.none_of(what, len(bad), count, where=f"{ROBUST}, What the tests do", by="exit codes 0, 1 and 2")
    for text in bad[:5]:
        part.note(text)

    wrong = 0
    count = 5 if part.quick else 25
    for _ in range(count):
        values = part.rng.standard_normal((40, 5)) * 10.0 ** part.rng.integers(-200, 200, (40, 5))
        digits = int(part.rng.integers(1, 18))
        np.savetxt(part.folder / "table.csv", values, delimiter=",", fmt=f"%.{digits}e")
        truth = np.loadtxt(part.folder / "table.csv", delimiter=",")
        part.run(
            "convert", "table.csv", "table.npz", "--header", "absent", "--time-column", "none", "--force"
        )
        with np.load(part.folder / "table.npz") as stored:
            read = next(stored[name] for name in stored if stored[name].shape == truth.shape)
        wrong += not np.array_equal(read, truth)
    what = "random tables that are not read to the bit as NumPy reads them"
    part.none_of(what, wrong, count, where=f"{ROBUST}, What the tests do", by="numpy.loadtxt")


PARTS = [printed, killed]
