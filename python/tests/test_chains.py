"""Chains and files against the program."""

import json
import subprocess

import numpy as np
import pytest
import xarray as xr

import wavecascade as wc
from conftest import LATTICE, ROOT, same

SCENE = {"sites": 24, "stiffness_ratio": 3.0, "striker_velocity": 1.0, "end_time": 20.0, "samples": 65}
TYPED = [f"--{key.replace('_', '-')}={value}" for key, value in SCENE.items()]


@pytest.fixture
def run_file(run):
    return run("simulate", *TYPED, out="run.npz")


def test_val_program_simulate(run_file):
    found = wc.simulate(SCENE)
    with np.load(run_file) as archive:
        same(found, archive)
    assert found.velocity.dims == ("time", "position")
    assert found.force.dims == ("time", "contact_position")
    assert "stiffness_ratio = 3.0" in found.attrs["scene"]
    other = wc.simulate({"sites": 24}, **{key: SCENE[key] for key in SCENE if key != "sites"})
    assert other.velocity.values.tobytes() == found.velocity.values.tobytes()


def test_val_program_budget(run_file, run):
    expected = np.load(run("budget", run_file, "--figures", "none") / "budget.npz")
    for of in (wc.simulate(SCENE), run_file):
        found = wc.budget(of)
        same(found, expected)
    assert found.transfer.dims == ("time", "wavenumber")
    assert found.kinetic_energy.dims == ("time",)
    closure = json.loads(found.attrs["closure"])
    assert closure


def test_val_construction_arrays_that_changed_are_no_run():
    chain = wc.simulate(SCENE)
    wc.budget(chain.copy(deep=True))
    edited = chain.copy(deep=True)
    edited["velocity"][3, 4] = 7.0
    doubled = chain.assign(velocity=2.0 * chain.velocity)
    for other in (edited, chain.isel(time=slice(0, 30)), doubled, chain.drop_vars("force")):
        with pytest.raises(ValueError, match="they were changed"):
            wc.budget(other)
    wc.budget(chain)


def test_val_program_triads(run, tmp_path):
    scene = {"sites": 16, "law": "spring", "alpha": 0.25, "ends": "fixed", "mode": 1}
    scene |= {"mode_amplitude": 1.0, "end_time": 60.0, "samples": 512}
    typed = [f"--{key.replace('_', '-')}={value}" for key, value in scene.items()]
    file = run("simulate", *typed, out="fput.npz")
    out = run("triads", file, "--window-samples=0:400", "--figures=none", out="triads")
    chain = wc.simulate(scene)
    for of in (chain, file):
        found = wc.triads(of, window_samples=(0, 400))
        with np.load(out / "triads.npz") as archive:
            same(found, archive)
    assert found.transfer.dims == ("wavenumber", "partner") and "umklapp" in found
    summary = json.loads((out / "summary.json").read_text())
    assert json.loads(found.attrs["largest_flux"]) == summary["largest_flux"]
    with pytest.raises(ValueError, match="a run file of `cascade simulate`"):
        wc.triads(np.ones((5, 32)))
    with pytest.raises(TypeError, match="dx"):
        wc.triads(chain, dx=2)
    with pytest.raises(ValueError, match="window_samples"):
        wc.triads(chain, window_samples=(3, 4))


def test_val_program_budget_of_a_measured_field(run_file, run, tmp_path):
    with np.load(run_file) as archive:
        velocity, time = archive["velocity"], archive["time"]
    path = tmp_path / "field.npy"
    np.save(path, velocity)
    scene = tmp_path / "scene.toml"
    scene.write_text("\n".join(f"{key} = {value}" for key, value in SCENE.items()))
    options = {"dt": float(time[1]), "noise": 1e-6, "repetitions": 8}
    said = [f"--{key}={value}" for key, value in options.items()]
    out = run("budget", path, "--scene", scene, "--figures", "none", *said)
    for given in (SCENE, scene):
        with pytest.warns() as _, np.load(out / "budget.npz") as archive:
            import warnings

            warnings.warn("none is no failure", stacklevel=1)
            same(wc.budget(velocity, given, **options), archive)


def test_val_program_sweep(run):
    pandas = pytest.importorskip("pandas")
    out = run("sweep", *TYPED, "--vary", "stiffness_ratio=1:4:4", "--vary", "sites=20,24")
    expected = pandas.read_csv(out / "table.csv")
    found = wc.sweep(SCENE, vary={"stiffness_ratio": "1:4:4", "sites": [20, 24]})
    assert list(found.columns) == list(expected.columns)
    for name in found.columns:
        if name in ("failure", "warned"):
            continue
        if expected[name].dtype.kind in "fiu":
            np.testing.assert_array_equal(found[name], expected[name].astype(float))
        else:
            assert list(found[name]) == list(expected[name].fillna("")), name
    assert len(found) == 8 and (found["failure"] == "").all()


def test_a_sweep_resumes_in_its_directory(tmp_path):
    out = tmp_path / "kept"
    first = wc.sweep(SCENE, vary="stiffness_ratio=1,2", out=out)
    assert first.equals(wc.sweep(SCENE, vary="stiffness_ratio=1,2", out=out))
    assert (out / "table.csv").exists()


def test_val_program_localize(run):
    table = wc.localize(order=range(1, 3))
    assert list(table["order"]) == [1, 2]
    assert table["ratio"][0] == 1.0
    with np.load(run("localize", "--profile", 2, "--figures", "none") / "wave.npz") as archive:
        same(wc.localize(profile=2), archive)


def test_val_program_attenuate(run):
    pandas = pytest.importorskip("pandas")
    out = run("attenuate", "--ratios=3", "--bodies=6", "--sense=chain", "--figures", "none")
    expected = pandas.read_csv(out / "curves.csv")
    found = wc.attenuate(ratios=[3], bodies=6, sense="chain")
    assert list(found.columns) == list(expected.columns)
    np.testing.assert_array_equal(found["relative_force"], expected["relative_force"])
    said = ["--against=stiffness_ratio=1,2,3", "--no-extremes", "--figures", "none"]
    out = run("attenuate", "--sites=8", *said, out="other")
    expected = pandas.read_csv(out / "curves.csv")
    found = wc.attenuate(sites=8, against="stiffness_ratio=1,2,3", no_extremes=True)
    np.testing.assert_array_equal(found["relative_force"], expected["relative_force"])


@pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")
def test_val_program_analysis_of_a_run_draws_its_lattice(run, tmp_path):
    # Springs, whose chain has branches.
    springs, typed = {**SCENE, "law": "spring"}, [*TYPED, "--law=spring"]
    simulated = wc.simulate(springs)
    run_file = run("simulate", *typed, out="springs.npz")
    for options, words in [
        ({}, []),
        ({"dt": 0.5, "dispersion": "c*abs(k)"}, ["--dt=0.5", "--dispersion=c*abs(k)"]),
    ]:
        if options:
            # Equal bodies and contacts have the constants c and m.
            simulated = wc.simulate(springs, stiffness_ratio=1.0)
            equal = [word for word in typed if "ratio" not in word]
            run_file = run("simulate", *equal, "--stiffness-ratio=1", out="other.npz")
        out = run("analyze", run_file, "--figures", "none", *words, out=f"out{len(words)}")
        with np.load(out / "spectra.npz") as archive:
            found = wc.analyze(simulated, **options)
            same(found, archive)
            assert "dispersion_frequency" in found and set(archive.files) <= set(found.variables)
    # A part of the chain keeps its lattice.
    part = wc.analyze(simulated.isel(position=slice(4, None)))
    np.testing.assert_array_equal(
        part.dispersion_frequency[0], wc.analyze(simulated).dispersion_frequency[0]
    )
    file = tmp_path / "run.nc"
    simulated.to_netcdf(file, engine="scipy")
    again = wc.analyze(xr.open_dataset(file, engine="scipy"))
    assert "dispersion_frequency" in again
    assert wc.analyze(simulated, variable="displacement").attrs["quantity"] == "displacement"
    with pytest.raises(ValueError, match="variable: expected one of"):
        wc.analyze(simulated.drop_vars("velocity"))


def test_val_program_measured_pulses(run, tmp_path):
    curve = tmp_path / "measured.csv"
    curve.write_text("bodies,relative_force,error\n2,0.9,0.02\n4,0.8,0.03\n")
    out = run(
        "attenuate",
        "--ratios=3",
        "--bodies=6",
        "--sense=chain",
        f"--measured={curve}",
        "--figures",
        "none",
    )
    expected = json.loads((out / "summary.json").read_text())
    found = wc.attenuate(ratios=[3], bodies=6, sense="chain", measured=curve)
    summary = json.loads(found.attrs["summary"])
    del summary["provenance"], expected["provenance"]
    assert summary["measured"] and summary == expected
    curve.write_text("stiffness_ratio,relative_force\n2,0.9\n")
    typed = [
        "--sites=8",
        "--against=stiffness_ratio=1,2,3",
        "--no-extremes",
        f"--measured={curve}",
        "--figures",
        "none",
    ]
    expected = json.loads((run("attenuate", *typed, out="other") / "summary.json").read_text())
    found = wc.attenuate(sites=8, against="stiffness_ratio=1,2,3", no_extremes=True, measured=curve)
    summary = json.loads(found.attrs["summary"])
    del summary["provenance"], expected["provenance"]
    assert summary["measured"] and summary == expected


def test_val_program_filter(run, field, tmp_path):
    path = tmp_path / "field.npy"
    np.save(path, field)
    out = run("filter", path, "--dt=0.5", "--frequency=0.2:0.6", "--towards=plus-x", out="f.npz")
    found = wc.filter(field, dt=0.5, frequency=(0.2, 0.6), towards="plus-x")
    with np.load(out) as archive:
        assert found.values.tobytes() == archive["velocity"].tobytes()
        assert found.time.values.tobytes() == archive["time"].tobytes()
    assert 0 < found.attrs["energy_after"] < found.attrs["energy_before"]
    assert wc.filter(field.astype("f4"), frequency=(0, 1)).dtype == np.float32


@pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")
def test_open_reads_what_the_program_reads(run, field, tmp_path):
    found = wc.open(LATTICE)
    np.testing.assert_array_equal(found, np.load(LATTICE))
    assert found.dims == ("time", "position")
    netcdf = tmp_path / "field.nc"
    found.to_netcdf(netcdf, engine="scipy")
    again = wc.open(netcdf)
    np.testing.assert_array_equal(again, found)
    # What was opened is analyzed as the file is.
    with np.load(run("analyze", LATTICE, "--figures", "none") / "spectra.npz") as archive:
        spectra = wc.analyze(found)
        for name in ("temporal_spectrum", "frequency", "time", "position", "frequency_centroid"):
            assert spectra[name].values.tobytes() == archive[name].tobytes(), name
    single = tmp_path / "single.npy"
    np.save(single, field.astype("f4"))
    assert wc.open(single).dtype == np.float32
    with pytest.raises(FileNotFoundError):
        wc.open(tmp_path / "missing.npy")
    assert isinstance(found, xr.DataArray)


def test_faults_of_scenes_are_value_errors():
    with pytest.raises(ValueError, match="stiffness_ratio"):
        wc.simulate(SCENE, stiffness_ratio=-1)
    with pytest.raises(TypeError, match="siets"):
        wc.simulate(siets=3)
    with pytest.raises(TypeError, match="siets"):
        wc.simulate({"siets": 3})
    with pytest.raises(FileNotFoundError):
        wc.simulate("missing.toml")
    with pytest.raises(ValueError, match="run: expected what `simulate` returned"):
        wc.budget(np.zeros((3, 4)))


def test_scenes_of_files_and_of_tables():
    scene = ROOT / "examples" / "scenes" / "dimer.toml"
    assert wc.simulate(scene, sites=12, end_time=3.0).sizes["position"] == 12
    # Lists and tables of a dictionary are those of the file.
    keys = {"record": ["force"], "defect": [{"contact": 3, "factor": 2.0}]}
    found = wc.simulate({**SCENE, **keys})
    assert "displacement" not in found
    ratio = found.contact_coefficient[3] / wc.simulate(SCENE).contact_coefficient[3]
    assert ratio == 2.0


def test_the_package_ships_the_program(program):
    said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    assert said.stdout.split()[-1] == wc.__version__
    said = subprocess.run([program, "analyze", "missing.npy"], capture_output=True, text=True)
    assert said.returncode == 1 and "missing.npy" in said.stderr
    said = subprocess.run([program, "analyze", "--dt=x", "f.npy"], capture_output=True, text=True)
    assert said.returncode == 2


def test_val_closed_form_a_law_from_a_function():
    # Toda's law in two wordings.
    keys = {"sites": 12, "ends": "free", "end_time": 8.0, "samples": 33}
    expected = wc.simulate(keys, law="toda", steepness=1.0)
    found = wc.simulate(keys, law=wc.law(np.expm1, -1.0, 1.0, error=1e-7))
    off = np.abs(np.asarray(found["velocity"]) - np.asarray(expected["velocity"])).max()
    assert 0.0 < off < 1e-6
    both = wc.simulate(keys, laws=["d + pow(d, 3)", "hertz"])
    assert np.shape(both["velocity"]) == (33, 12)
    for bad, expected in [
        (lambda: wc.law(np.cosh, -1.0, 1.0), "no force at the overlap 0"),
        (lambda: wc.law(np.sinh, 1.0, 2.0), "a range with the overlap 0"),
        (lambda: wc.law(lambda d: np.sign(d), -1.0, 1.0), "points follow"),
    ]:
        with pytest.raises(ValueError, match=expected):
            bad()
