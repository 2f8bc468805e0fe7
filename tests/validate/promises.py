"""What the README and the guide print, and what happens to files when a run is killed or fed rubbish."""

import json
import pathlib
import shutil
import signal
import subprocess
import time

import documents
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
ROBUST = "robustness.md"


def moved_between(field, first, last):
    """The largest share that moved up from one group of sites to another, by spectra of whole records."""
    power = np.abs(np.fft.rfft(field, axis=0)) ** 2
    power[1:-1] *= 2
    share = [np.cumsum(power[:, group].sum(axis=1)) / power[:, group].sum() for group in (first, last)]
    return (share[0] - share[1]).max()


#: Sentences of the README, and those of the pages that prove them.
REPEATED = [
    ("agree with NumPy and SciPy to # of the peak", "accuracy.md", "fields, `f64` | # of the peak |"),
    ("Parseval's identity closes to # at every length", "accuracy.md", "all lengths tested | # |"),
    (
        "hold in # to # % of the cells of noise",
        "guide/spectra.md",
        "intervals hold in # to # % of the cells",
    ),
    ("every tolerance from # to #,", "accuracy.md", "every tolerance from # to #,"),
    ("close in real space to # of the energy", "accuracy.md", "(# where forces set in with a kink)"),
]


def printed(part):
    """What the README and the guide print"""
    for number, page in enumerate(
        ("README.md", "python/README.md", "docs/site/start.md", *documents.GUIDE)
    ):
        # Results that another page has made are refused.
        folder = part.folder / str(number)
        folder.mkdir()
        (folder / "examples").symlink_to(ROOT / "examples")
        for shell, text in documents.outputs(page):
            script = f'export COLUMNS=160; cascade() {{ {part.program} "$@"; }}; {shell}'
            done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, cwd=folder)
            what = f"what is shown under `{documents.commands(shell)[-1]}` and is not printed"
            left = documents.missing(text, done.stdout)
            part.same(what, "nothing", "; ".join(left) or "nothing", where=page, by="the program")
            shutil.rmtree(folder / "out", ignore_errors=True)


def shown(part):
    """Numbers of the README and the guide against their truth"""
    where = "README.md"
    for sentence, page, there in REPEATED:
        stated = documents.numbers(page, there)
        found = documents.numbers(where, sentence)
        part.same(f"the README states the numbers of {page}", stated, found, where=where, by=there)
    sentence = "energy moves up in frequency along x: # ± # % past # kHz by site #"
    share, _, _, site = documents.numbers(where, sentence)
    part.run("examples", "growing_harmonic")
    with np.load(part.folder / "growing_harmonic.npz") as stored:
        field = max((stored[name] for name in stored), key=lambda a: a.size)
    if field.shape[0] < field.shape[1]:
        field = field.T
    up = moved_between(field, slice(0, 4), slice(int(site) - 3, int(site) + 1))
    by = "cumulative spectra of whole records by NumPy"
    part.claim("growing_harmonic: its share that moved up", share / 100, up, 0.02, where=where, by=by)

    summary, found = part.estimate("analyze", ROOT / "examples/data/lattice_impact.npy")
    shape = tuple(int(n) for n in documents.numbers(where, "assert_eq!(spectrum.dim(), (#, #));"))
    what = "lattice_impact: S(k, f) has (frequency, wavenumber)"
    part.same(what, shape, found["spacetime_spectrum"].shape, where=where, by="the code there")
    least = documents.number(where, "assert!(direction.toward_plus_x > #);")
    plus = summary["direction"]["toward_plus_x"]
    by = "the code there; struck at its first site"
    part.within("lattice_impact: share towards +x", plus, least, 1.0, where=where, by=by)
    k, f, s = (found[name] for name in ("wavenumber_signed", "frequency", "spacetime_spectrum"))
    inside = (k > 0.3 * k.max()) & (k < 0.7 * k.max())
    peak = f[np.argmax(s[:, inside], axis=0)]
    spread = peak / np.abs(np.sin(k[inside] / k.max() * np.pi / 2))
    what = "lattice_impact: ridge over the dispersion of equal springs, spread"
    found = float(spread.std() / spread.mean())
    part.within(what, found, None, 0.03, where="figures/README.md", by="|sin(ka/2)|")

    where = "guide/fit.md"
    names = ("young", "striker_velocity", "tangent", "angle")
    made = documents.numbers(where, "The records are of a chain of # GPa, # m/s, # us and # degrees.")
    for name, right in zip(names, made, strict=True):
        value, half = documents.numbers(where, f"{name} = # ± #")
        what = f"fit of impact_records: {name}, from the truth, in standard errors"
        by = f"{right:g}, of the chain that made the records"
        part.within(what, abs(value - right) / (half / 1.96), None, 3.0, where=where, by=by)


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


PARTS = [printed, shown, killed]
