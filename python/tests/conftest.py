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


def same(found, archive) -> None:
    """That every array of an archive is found, with the same type and bits."""
    names = [name for name in archive.files if archive[name].dtype.kind == "f"]
    assert names
    for name in names:
        array = np.asarray(found[name])
        assert array.dtype == archive[name].dtype, name
        assert array.shape == archive[name].shape, name
        assert array.tobytes() == archive[name].tobytes(), name
