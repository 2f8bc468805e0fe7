"""Fields and the program that the tests compare with."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
LATTICE = ROOT / "examples" / "data" / "lattice_impact.npy"


@pytest.fixture(scope="session")
def program() -> str:
    """The program, as it was built beside the package: `CASCADE`, else the package's own."""
    beside = Path(sys.executable).parent / "cascade"
    return os.environ.get("CASCADE") or shutil.which("cascade") or str(beside)


@pytest.fixture
def run(program, tmp_path):
    """Runs the program in a folder of the test; returns the folder of its results."""

    def run(*words: object, out: str = "out") -> Path:
        command = [program, *map(str, words), "--out", str(tmp_path / out), "--quiet"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return tmp_path / out

    return run


@pytest.fixture
def field() -> np.ndarray:
    """Noise beside a wave, of odd lengths."""
    rng = np.random.default_rng(26)
    t, x = np.arange(207)[:, None], np.arange(31)[None, :]
    return rng.standard_normal((207, 31)) + 3 * np.cos(0.3 * x - 0.7 * t)


@pytest.fixture(scope="module")
def record() -> np.ndarray:
    """Noise beside a wave, of lengths without a divisor in common with any chunk."""
    rng = np.random.default_rng(53)
    t, x = np.arange(1501)[:, None], np.arange(23)[None, :]
    return rng.standard_normal((1501, 23)) + 3 * np.cos(0.3 * x - 0.7 * t) + 2


@pytest.fixture(scope="module")
def labelled(record):
    """The same with coordinates and units."""
    xr = pytest.importorskip("xarray")
    time = ("time", 5e-4 * np.arange(1501), {"units": "s"})
    coords = {"time": time, "x": ("x", 2.0 * np.arange(23), {"units": "mm"})}
    return xr.DataArray(record, coords, ("time", "x"), "velocity", {"units": "m/s"})


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """Two workers of little memory."""
    distributed = pytest.importorskip("distributed")
    folder = tmp_path_factory.mktemp("workers")
    cluster = distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        memory_limit="420 MB",
        dashboard_address=":0",
        local_directory=folder,
        silence_logs=50,
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


def same(found, archive) -> None:
    """That every array of an archive is found, with the same type and bits."""
    names = [name for name in archive.files if archive[name].dtype.kind == "f"]
    assert names
    for name in names:
        array = np.asarray(found[name])
        assert array.dtype == archive[name].dtype, name
        assert array.shape == archive[name].shape, name
        assert array.tobytes() == archive[name].tobytes(), name
