"""The code of the guide runs as it is written, on files of its names, and prints what is written."""

import importlib.util
import inspect
import operator
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import wavecascade as wc
from conftest import ROOT

_found = importlib.util.spec_from_file_location("documents", ROOT / "tests/validate/documents.py")
documents = importlib.util.module_from_spec(_found)
_found.loader.exec_module(documents)

PAGES = ["README.md", "python/README.md", *documents.GUIDE, "docs/site/start.md"]

#: Commands of minutes: the sizes that are written are replaced by these.
SMALLER = {
    "--vary stiffness_ratio=1:120:400log": "--vary stiffness_ratio=1:120:4log",
    "--members 200": "--members 3",
    "stiffness_ratio=1:20:12log --members 50": "stiffness_ratio=1:20:2log --members 3",
    "--order 1..19": "--order 1..3",
    "localize --direct": "localize --order 1..2 --direct --cells 30",
    "--launch 8 --cells 1000": "--launch 2 --cells 60",
    "--against stiffness_ratio=1:100:41log": "--against stiffness_ratio=1:100:3log",
    "--against angle": "--against angle=10:80:3",
    "--minimize peak_force_last": "--minimize peak_force_last --tries 12",
    "--bodies 100 --sense chain": "--bodies 20 --sense chain",
    "--angles 8,18,90": "--angles 18,90 --bodies 12",
    "--samples 8192": "--samples 1024",
    "angle --out out/fit": "angle --starts 1 --out out/fit",
}


#: Not run, with what they need that no file made here has.
NOT_RUN = {
    "out/records/": "the measurements that `cargo run --example impact_records` makes",
    "--scene chain.toml": "a measured chain and its scene, as in tests/budget",
    "--fit diatomic": "a field with both branches of a diatomic lattice, as in tests/analysis/ridges.rs",
}


def commands(page: str) -> list[str]:
    """The lines of a page that run the program, but those whose output is shown."""
    shown = [shell for shell, _ in documents.outputs(page)]
    blocks = documents.blocks(page)
    shells = (content for language, content in blocks if language == "sh" and content not in shown)
    lines = (line for shell in shells for line in documents.commands(shell))
    return [line for line in lines if not any(words in line for words in NOT_RUN)]


def steepening(rng: np.random.Generator, times: int = 4096, sites: int = 64) -> np.ndarray:
    """Waves of a band that go towards +x, with the sums of pairs behind them, and noise."""
    t, x = 1e-4 * np.arange(times)[:, None], 0.05 * np.arange(sites)[None, :]
    wave = sum(
        np.cos(2 * np.pi * f * (t - x / 400) + p)
        for f, p in zip(rng.uniform(100, 900, 40), rng.uniform(0, 6, 40), strict=True)
    )
    return 0.1 * wave + 2e-3 * x * wave**2 + 1e-2 * rng.standard_normal((times, sites))


def run_in(folder: Path, line: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True, check=False)


def scan(file: Any, times: np.ndarray, values: np.ndarray) -> None:
    """Writes velocities over time and x, and y between them if there are planes."""
    axes = [("time", "s", times), ("y", "m", 3e-3 * np.arange(3)), ("x", "m", 0.05 * np.arange(20))]
    with file:
        velocity = file.create_dataset("scan/velocity", data=values)
        velocity.attrs["units"] = "m/s"
        for n, (name, unit, places) in enumerate(axes if values.ndim == 3 else axes[::2]):
            scale = file.create_dataset(f"scan/{name}", data=places)
            scale.attrs["units"] = unit
            scale.make_scale(name)
            velocity.dims[n].attach_scale(scale)


@pytest.fixture(scope="module")
def files(tmp_path_factory, program):
    """A folder with a file for each name that the pages use."""
    h5py = pytest.importorskip("h5py")
    folder = tmp_path_factory.mktemp("guide")
    rng = np.random.default_rng(7)
    (folder / "examples").symlink_to(ROOT / "examples")
    sidecar = (
        'layout = "time-site"\ndt = 1e-4\ndx = 0.05\ntime_unit = "s"\nspace_unit = "m"\nunit = "m/s"\n'
    )
    for name in ("field", "long", "shot1", "shot2", "shot3", "data/day1", "data/day2"):
        path = folder / f"{name}.npy"
        path.parent.mkdir(exist_ok=True)
        np.save(path, steepening(rng, 20_000 if name == "long" else 4096, 4 if name == "long" else 64))
        path.with_suffix(".toml").write_text(sidecar)
    (folder / "out").mkdir()
    shutil.copy(folder / "field.npy", folder / "out" / "steepening.npy")
    x = np.arange(128)
    ring = sum(np.cos(2 * np.pi * k * x / 128 - 0.2 * np.arange(2048)[:, None]) / k for k in range(1, 9))
    np.save(folder / "ring.npy", ring)
    np.savez(folder / "ring.npz", v=ring, t=np.arange(2048.0), x=np.arange(128.0))
    noise = rng.standard_normal((4096, 24))
    for name in ("noise", "waves", "gaps"):
        np.save(folder / f"{name}.npy", noise)
    noise[700:720, 3] = np.nan
    np.save(folder / "gaps.npy", noise)
    wave = steepening(rng, 1024, 20)
    uneven = 1e-4 * (np.arange(1024) + 0.1 * rng.uniform(-1, 1, 1024))
    header = "time (s)," + ",".join(f"{0.05 * site:.2f}" for site in range(20))
    np.savetxt(folder / "logger.csv", np.c_[uneven, wave], delimiter=",", header=header, comments="")
    even = 1e-4 * np.arange(1024)
    planes = np.stack([wave, wave, wave], axis=1)
    for name, times, values in (("scan", even, planes), ("uneven", uneven, wave)):
        scan(h5py.File(folder / f"{name}.h5", "w"), times, values)
    (folder / "scan").mkdir()
    for n in range(8):
        rows = np.c_[wave[:, 0], wave[:, n]]
        name = folder / "scan" / f"x={5 * n}mm.csv"
        np.savetxt(name, rows, delimiter=",", header="hammer,velocity", comments="")
    for path in (ROOT / "tests" / "data" / "scan_uff").glob("*.uff"):
        shutil.copy(path, folder / "scan")
    shutil.copy(ROOT / "tests" / "data" / "scan_segy" / "shot1.sgy", folder / "traces.sgy")
    wavenumber = np.linspace(-3, 3, 61)
    np.savetxt(
        folder / "curve.csv",
        np.c_[wavenumber, np.abs(wavenumber)],
        delimiter=",",
        header="k,f",
        comments="",
    )
    for name in ("fput", "dimer"):
        shutil.copy(ROOT / "examples" / "scenes" / f"{name}.toml", folder)
    scene = (ROOT / "examples" / "scenes" / "dimer.toml").read_text(encoding="utf-8")
    (folder / "scene.toml").write_text(f"coefficient_spread = 0.05\n{scene}", encoding="utf-8")
    for name in ("localized", "dispersive", "out/dimer"):
        line = f"{program} simulate dimer.toml --sites 60 --samples 257 --out {name}.npz --quiet"
        assert run_in(folder, line).returncode == 0
    return folder


def copied(files: Path, tmp_path: Path) -> None:
    """The files for one page alone: what its code writes, later code reads."""
    for path in files.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.copytree(path, tmp_path / path.name)
        elif path.is_symlink():
            (tmp_path / path.name).symlink_to(path)
        else:
            (tmp_path / path.name).hardlink_to(path)


@pytest.mark.parametrize("page", [page for page in PAGES if commands(page)])
def test_val_commands_of_the_guide_run(page, files, program, tmp_path):
    copied(files, tmp_path)
    told = []
    for line in commands(page):
        for written, smaller in SMALLER.items():
            line = line.replace(written, smaller)
        if page.endswith("scans.md"):
            line = line.replace("scan.h5", "uneven.h5")
        line = line.replace("FILE", "field.npy").replace("cascade ", f"{program} ", 1)
        done = run_in(tmp_path, line)
        # Alternatives of a page write to one place.
        if "is already there" in done.stderr:
            done = run_in(tmp_path, f"{line} --force")
        if done.returncode:
            told.append(f"{line}\n  exit code {done.returncode}: {done.stderr.strip()}")
    assert not told, "\n".join(told)


@pytest.mark.parametrize(
    ("page", "shell", "printed"), [(page, *both) for page in PAGES for both in documents.outputs(page)]
)
def test_val_the_guide_shows_what_is_printed(page, shell, printed, program, tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    # Wide lines: how many are printed depends on how many are folded.
    script = f'export COLUMNS=160; cascade() {{ {program} "$@"; }}; {shell}'
    done = run_in(tmp_path, script)
    assert done.returncode == 0, done.stderr
    assert documents.missing(printed, done.stdout) == []


#: Sizes of clusters, and what stands for them here.
SMALLER_PYTHON = {
    '"tcp://scheduler:8786"': "processes=False, dashboard_address=None",
    "1:120:400log": "1:120:3log",
    '"3/64"': '"3/4"',
    '"sites": 400': '"sites": 40, "end_time": 20.0',
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "page",
    [
        page
        for page in [*PAGES, "docs/formats/netcdf.md"]
        if any(language == "python" for language, _ in documents.blocks(page))
    ],
)
def test_val_python_of_the_guide_runs(page, files, tmp_path, monkeypatch):
    plots = pytest.importorskip("matplotlib.pyplot")
    pytest.importorskip("zarr")
    xr = pytest.importorskip("xarray")
    copied(files, tmp_path)
    monkeypatch.chdir(tmp_path)
    velocity = np.tile(np.load("field.npy"), (3, 1))
    axes = {"time": 1e-5 * np.arange(len(velocity)), "x": 2e-3 * np.arange(velocity.shape[1])}
    labelled = xr.DataArray(velocity, axes, ("time", "x"), "velocity")
    Path("field.npy").unlink()
    np.save("field.npy", velocity)
    labelled.chunk({"x": 16}).to_dataset().to_zarr("field.zarr", zarr_format=2)
    wc.analyze(labelled[:1024]).to_netcdf("spectra.nc")
    parts = [wc.partial("field.npy", segment=512, part=f"{n}/2") for n in (1, 2)]
    for n, part in enumerate(parts):
        part.save(f"half-{n}.npz")
    names = {
        "wc": wc, "xr": xr, "numpy": np, "velocity": velocity, "field": velocity,
        "shots": [velocity, velocity[::-1]], "input": velocity[:, 0], "output": velocity[:, 9],
        "samples": np.ones((4_100_000, 1)), "paths": ["half-0.npz", "half-1.npz"],
        "v": velocity, "t": axes["time"], "x": axes["x"],
    }  # fmt: skip
    try:
        for language, code in documents.blocks(page):
            if language == "python":
                for written, smaller in SMALLER_PYTHON.items():
                    code = code.replace(written, smaller)
                exec(compile(code, page, "exec"), names)
    finally:
        plots.close("all")
        if "client" in names:
            names["client"].close()


def test_val_names_in_the_documents_exist():
    pages = [*PAGES, "docs/reference.md", "docs/methods.md"]
    for page in pages:
        for name in re.findall(r"\bwc\.([\w.]*\w)", documents.text(page)):
            assert operator.attrgetter(name)(wc), f"{page}: wc.{name}"


def test_val_the_site_reads_the_package_without_what_is_compiled():
    code = "import make; make.package_from_source(); print(make.functions('Functions'))"
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=ROOT / "docs/site", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    functions = [name for name in wc.__all__ if inspect.isfunction(getattr(wc, name))]
    assert [name for name in functions if f"wc.{name}(" not in done.stdout] == []
