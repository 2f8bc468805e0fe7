"""What can be done with results: files, pages, figures, comparisons, types."""

import copy
import json
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from test_chains import SCENE, TYPED

import wavecascade as wc
from conftest import LATTICE, same

pytestmark = pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")


@pytest.fixture(scope="module")
def chain():
    return wc.simulate(SCENE)


def engines():
    return ["scipy"] + (["netcdf4"] if __import__("importlib.util").util.find_spec("netCDF4") else [])


def test_a_run_survives_travel_and_files(chain, tmp_path):
    expected = wc.budget(chain)
    others = [pickle.loads(pickle.dumps(chain)), copy.deepcopy(chain)]
    for engine in engines():
        file = tmp_path / f"{engine}.nc"
        chain.to_netcdf(file, engine=engine)
        others.append(xr.load_dataset(file, engine=engine))
        # The file by its path, as the program reads it.
        others.append(file)
    for other in others:
        found = wc.budget(other)
        for name in expected.variables:
            assert found[name].values.tobytes() == expected[name].values.tobytes(), name


def test_val_program_budget_of_a_netcdf_file(chain, run, tmp_path):
    expected = np.load(
        run("budget", run("simulate", *TYPED, out="run.npz"), "--figures=none", out="a") / "budget.npz"
    )
    own = run("simulate", *TYPED, out="own.nc")
    chain.to_netcdf(tmp_path / "ours.nc", engine="scipy")
    for i, file in enumerate((own, tmp_path / "ours.nc")):
        same(np.load(run("budget", file, "--figures=none", out=f"b{i}") / "budget.npz"), expected)
        same(wc.budget(file), expected)
    # A part of it is a field.
    part = tmp_path / "part.nc"
    chain.isel(position=slice(4, 20), contact_position=slice(4, 20)).to_netcdf(part, engine="scipy")
    assert wc.analyze(part).sizes["position"] == 16
    with pytest.raises(ValueError, match=r"part.nc"):
        wc.budget(part)
    # So it is of a file of the program, which has no checksum.
    opened = xr.load_dataset(own, engine="scipy")
    assert wc.budget(opened)
    cut = opened.isel(position=slice(4, 20), contact_position=slice(4, 20))
    assert wc.analyze(cut).sizes["position"] == 16
    with pytest.raises(ValueError, match="cut or exchanged"):
        wc.budget(cut)


def test_val_program_answer_of_a_run_in_memory(run):
    lossy = {**SCENE, "dashpot": 0.02, "end_time": 40.0, "samples": 257, "sites": 60}
    typed = [f"--{key.replace('_', '-')}={value}" for key, value in lossy.items()]
    summary = run("analyze", run("simulate", *typed, out="run.npz"), "--figures=none") / "summary.json"
    told = json.loads(summary.read_text())
    found = wc.analyze(wc.simulate(lossy))
    assert json.loads(found.attrs["moved"]) == told["moved"]
    assert found.attrs["answer"] == told["answer"]
    assert found.attrs["wavenumber_verdict"] == told["moved"]["wavenumber"]["verdict"]


def test_answers_are_attributes():
    found = wc.analyze(LATTICE)
    answer = json.loads(found.attrs["moved"])

    def leaves(tree, path=()):
        for key, value in tree.items():
            if isinstance(value, dict):
                yield from leaves(value, (*path, key))
            elif value is not None and not isinstance(value, list):
                yield "_".join((*path, key)), value

    told = dict(leaves(answer))
    assert {"frequency_verdict", "frequency_up", "frequency_bound", "wavenumber_verdict"} <= set(told)
    for name, value in told.items():
        assert found.attrs[name] == value, name


def results(field):
    """A result of each function."""
    chain = wc.simulate(SCENE)
    springs = {"sites": 16, "law": "spring", "alpha": 0.25, "ends": "fixed", "mode": 1}
    springs |= {"mode_amplitude": 1.0, "end_time": 60.0, "samples": 512}
    return {
        "analyze": wc.analyze(field),
        "spectrum": wc.spectrum(field, segment=64),
        "both": wc.spectrum(field, along="both", segment=64),
        "coherence": wc.coherence(field, segment=64),
        "bicoherence": wc.bicoherence(field, segment=32),
        "modes": wc.modes(field, segment=32),
        "increments": wc.increments(field),
        "slope": wc.slope(field, band=(0.3, 2.5)),
        "ridges": wc.ridges(field),
        "flux": wc.flux(field),
        "budget": wc.budget(chain),
        "triads": wc.triads(wc.simulate(springs)),
        "wave": wc.localize(profile=2),
    }


def test_results_have_pages_and_figures(field, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("agg")
    for name, result in results(field).items():
        page = tmp_path / f"{name}.html"
        result.cascade.report(page)
        assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>"), name
        axes = result.cascade.plot()
        assert all(place.has_data() for place in axes), name
        assert all(place.get_xlabel() for place in axes), name
        axes[0].figure.canvas.draw()
        matplotlib.pyplot.close(axes[0].figure)
        with pytest.raises(ValueError, match="were changed"):
            wc.report(result.assign(other=3.0), page)
    found = wc.analyze(field)
    _, (place,) = matplotlib.pyplot.subplots(1, 1, squeeze=False)
    assert found.cascade.plot("temporal_spectrum", place)[0] is place[0]
    with pytest.raises(ValueError, match="names: expected variables of one or two dimensions"):
        found.cascade.plot("nothing")
    with pytest.raises(ValueError, match="axes: expected 3"):
        found.cascade.plot(axes=place)


def test_tables_have_pages(tmp_path):
    tables = {
        "sweep": wc.sweep(SCENE, vary="stiffness_ratio=1,2"),
        "attenuate": wc.attenuate(ratios=[3], bodies=6, sense="chain"),
        "transmission": wc.attenuate(sites=8, against="stiffness_ratio=1,2,3", no_extremes=True),
        "localize": wc.localize(order=range(1, 3)),
    }
    for name, table in tables.items():
        page = tmp_path / f"{name}.html"
        wc.report(table, page)
        assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>"), name
        with pytest.raises(ValueError, match="expected what a function"):
            wc.report(table.copy(), page)
        json.dumps(table.attrs)


def test_val_program_compare(run, chain, tmp_path):
    other = {**SCENE, "stiffness_ratio": 1.0}
    files = [run("simulate", *TYPED, out="a.npz")]
    files.append(
        run(
            "simulate",
            *(word for word in TYPED if "ratio" not in word),
            "--stiffness-ratio=1",
            out="b.npz",
        )
    )
    expected = json.loads((run("compare", *files, "--figures=none") / "summary.json").read_text())
    for both in ((chain, wc.simulate(other)), files):
        found = wc.compare(*both)
        read = json.loads(found.attrs["summary"])
        assert read["difference"] == expected["difference"]
        np.testing.assert_allclose(
            found["difference"], found["second"] - found["first"], rtol=0, atol=1e-15
        )
        wc.report(found, tmp_path / "page.html")
        assert "<!DOCTYPE html>" in (tmp_path / "page.html").read_text(encoding="utf-8")
    with pytest.raises(ValueError, match="second: expected a run"):
        wc.compare(chain, np.zeros((3, 4)))


def test_val_program_plan_and_inspect(program, field, tmp_path):
    path = tmp_path / "field.npy"
    np.save(path, field)

    def said(*words):
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=True)
        return json.loads(done.stdout)

    plan = said("analyze", path, "--plan", "--json", "--segment=64")
    for given in (field, path):
        found = wc.plan(given, segment=64)
        assert set(found) == set(plan)
        keys = set(plan) - {"memory", "memory_needed", "memory_allowed", "field", "name"}
        assert {key: found[key] for key in keys} == {key: plan[key] for key in keys}
    assert wc.inspect(path, dt=0.5) == said("inspect", path, "--json", "--dt=0.5")
    assert (
        wc.inspect(LATTICE, channels=True)["channels"]
        == said("inspect", LATTICE, "--json", "--channels")["channels"]
    )
    with pytest.raises(FileNotFoundError):
        wc.inspect(tmp_path / "missing.npy")


def test_variables_are_documented(field, chain):
    for function, result in (
        (wc.analyze, wc.analyze(field)),
        (wc.simulate, chain),
        (wc.budget, wc.budget(chain)),
    ):
        text = function.__doc__
        told = {
            word for code in re.findall(r"``([^`]*)``", text) for word in re.findall(r"[a-z0-9_]+", code)
        }
        bare = {re.sub(r"_(error|half)$", "", str(name)) for name in result.variables}
        assert bare <= told, (function.__name__, sorted(bare - told))


TYPED_CODE = """
import xarray as xr
import wavecascade as wc

def right(da: xr.DataArray) -> None:
    field: wc.FieldAccessor = da.cascade
    found: xr.Dataset = field.analyze(segment=64, window_time=("kaiser", 8), dt="5 us")
    run: xr.Dataset = wc.simulate(sites=40, stiffness_ratio=4.9, ends="free")
    passed: xr.DataArray = wc.filter(da, frequency=(1.0, None))

def wrong(da: xr.DataArray) -> None:
    field: wc.FieldAccessor = da.cascade
    field.analyze(segmnet=64)
    field.spectrum(along="sideways")
    wc.simulate(siets=40)
    wc.simulate(ends="open")
    wc.budget(da, scales="all", bands=3)
    wc.simulate(sites=40).to_lists()
"""


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_keywords_and_results_are_typed(checker, tmp_path):
    pytest.importorskip(checker)
    file = tmp_path / "use.py"
    file.write_text(TYPED_CODE)
    words = {"mypy": ["--strict", "--no-error-summary"], "pyright": ["--pythonpath", sys.executable]}[
        checker
    ]
    command = [sys.executable, "-m", checker, *words, str(file)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    wrong = {int(line) for line in re.findall(r"use\.py:(\d+)(?::\d+)?(?: -|:) error", done.stdout)}
    lines = TYPED_CODE.splitlines()
    first = lines.index("def wrong(da: xr.DataArray) -> None:") + 1
    # Attributes of a Dataset have any name.
    assert wrong == set(range(first + 2, len(lines))), done.stdout


def test_every_key_of_scenes_is_typed():
    from wavecascade import _native
    from wavecascade._keywords.scene import SceneKeys

    assert set(SceneKeys.__annotations__) == set(_native.scene_keys())
