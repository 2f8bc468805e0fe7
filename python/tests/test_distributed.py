"""Planned transforms and sweeps over several processes: the same bits, whatever is lost."""

import os
import shutil
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import wavecascade as wc

xr = pytest.importorskip("xarray")
da = pytest.importorskip("dask.array")
zarr = pytest.importorskip("zarr")
distributed = pytest.importorskip("distributed")


def test_val_scipy_windows():
    """Of the transforms over a store."""
    from scipy.signal import get_window

    from wavecascade._large import windows

    names = {"blackman-harris": "blackmanharris", "flat-top": "flattop", "none": "boxcar"}
    for name in ("hann", "hamming", "blackman-harris", "flat-top", "none"):
        for n in (7, 128):
            expected = get_window(names.get(name, name), n)
            np.testing.assert_allclose(windows.window(name, n), expected, rtol=0, atol=5e-16)


@pytest.mark.parametrize("which", ["temporal", "spatial"])
def test_blockwise_spectra_of_odd_chunks_and_single_precision(labelled, which):
    single = labelled.astype("f4")
    spectrum = getattr(wc, f"{which}_spectrum")
    for chunks in [(1501, (7, 1, 15)), ((1, 500, 1000), 23)]:
        lazy = spectrum(single.copy(data=da.from_array(single.values, chunks=chunks)))
        eager = spectrum(single)
        assert lazy.dims == eager.dims and lazy.attrs == eager.attrs
        assert lazy.compute().values.tobytes() == eager.values.tobytes()
        # A chunk that is whole along its records stays by itself.
        blocks = [n for n in lazy.data.numblocks if n > 1]
        assert blocks == ([3] if (chunks[0] == 1501) == (which == "temporal") else [])
    wide = xr.DataArray(da.zeros((1 << 20, 4096), chunks=(1024, 4096)), dims=("time", "x"))
    with pytest.raises(ValueError, match=r"1024 chunks along time.*field\.chunk\(\{'x': 16\}\)"):
        wc.temporal_spectrum(wide)


# S(k, f) of whole records.


@pytest.mark.filterwarnings("ignore::wavecascade.CascadeWarning")
@pytest.mark.parametrize("shape", [(301, 31), (256, 16), (64, 7)])
@pytest.mark.parametrize("scaling", ["energy", "density", "spectrum"])
def test_val_analyze_spacetime(record, tmp_path, shape, scaling, capsys):
    field = record.ravel()[: shape[0] * shape[1]].reshape(shape)
    options = {"dt": "2 ms", "dx": "3 mm", "unit": "m/s", "scaling": scaling}
    expected = wc.analyze(field, only="spacetime", **options).spacetime_spectrum
    plan = wc.distributed.plan_spacetime(field, tmp_path / "out", memory="2 GB", **options)
    assert capsys.readouterr().out.strip() == str(plan)
    assert not (tmp_path / "out").exists() and plan.tasks == 2
    found = plan.run()
    assert hasattr(found.data, "dask") and found.attrs["units"] == expected.attrs["units"]
    for name in expected.coords:
        np.testing.assert_array_equal(found[name], expected[name])
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-15 * expected.values.max())
    assert abs(found.attrs["parseval"]) < 1e-14
    # Nothing but the result is left, and it opens by itself.
    names = {entry.name for entry in (tmp_path / "out").iterdir()}
    assert names == {"zarr.json", "frequency", "side", "wavenumber", "spacetime_spectrum"}
    opened = xr.open_zarr(tmp_path / "out", consolidated=False)
    assert opened.spacetime_spectrum.dims == ("frequency", "side", "wavenumber")
    options["scaling"] = "density" if scaling == "energy" else "energy"
    with pytest.raises(ValueError, match="expected the same work to resume, found scaling"):
        wc.distributed.plan_spacetime(field, tmp_path / "out", memory="2 GB", **options).run()


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A field in a store of Zarr, and S(k, f) of it in one block."""
    folder = tmp_path_factory.mktemp("stored")
    field = np.random.default_rng(54).standard_normal((2003, 501))
    array = zarr.create_array(folder / "field", shape=field.shape, chunks=(100, 167), dtype="f8")
    array[:] = field
    plan = wc.distributed.plan_spacetime(folder / "field", folder / "out", memory="2 GB", show=False)
    return folder / "field", field, plan.run().values


def test_blocks_of_any_size_have_the_same_bits(stored, tmp_path):
    path, field, expected = stored
    windows = {"window_time": "hann", "window_space": np.hamming(501)}
    whole = wc.distributed.plan_spacetime(field, tmp_path / "whole", memory="2 GB", show=False, **windows)
    tapered = whole.run().values
    sources = {
        "path": path,
        "array": zarr.open_array(path, mode="r"),
        "dask": da.from_array(field, chunks=((70,) * 28 + (43,), (500, 1))),
        "numpy": field,
    }
    for name, source in sources.items():
        plan = wc.distributed.plan_spacetime(source, tmp_path / name, memory="347 MB", show=False)
        assert plan.blocks[0] > 2 and plan.blocks[1] >= 1, plan
        with ThreadPoolExecutor(2) as pool:
            assert plan.run(pool).values.tobytes() == expected.tobytes(), name
    plan = wc.distributed.plan_spacetime(path, tmp_path / "w", memory="347 MB", show=False, **windows)
    assert plan.run().values.tobytes() == tapered.tobytes()
    # Another window along space, but the same energy.
    spaced = wc.analyze(field, window_time="hann", window_space="hamming", only="spacetime")
    assert abs(tapered.sum() / spaced.spacetime_spectrum.values.sum() - 1) < 2e-3


def test_stores_of_xarray_have_their_coordinates(labelled, tmp_path):
    plan = wc.distributed.plan_spacetime
    expected = plan(labelled, tmp_path / "a", memory="2 GB", show=False).run()
    assert expected.frequency.attrs["units"] == "Hz"
    assert float(expected.frequency[-1]) == pytest.approx(1000, rel=1e-3)
    for name, field in {"b": labelled, "c": labelled.T}.items():
        field.chunk({"x": 7, "time": 400}).to_zarr(tmp_path / f"{name}.zarr")
        found = plan(tmp_path / f"{name}.zarr", tmp_path / name, memory="350 MB", show=False).run()
        xr.testing.assert_identical(found.compute(), expected.compute())
    bare = labelled.T.values
    zarr.create_array(tmp_path / "d.zarr", data=bare, chunks=(7, 400))
    options = {"dt": 5e-4, "dx": 2, "layout": "site-time"}
    found = plan(tmp_path / "d.zarr", tmp_path / "d", memory="2 GB", show=False, **options).run()
    np.testing.assert_allclose(found.values, expected.values, rtol=1e-12)
    labelled.to_zarr(tmp_path / "e.zarr", encoding={"velocity": {"scale_factor": 0.5, "dtype": "f8"}})
    with pytest.raises(ValueError, match="found velocity with scale_factor"):
        plan(tmp_path / "e.zarr", tmp_path / "e", memory="2 GB")


def test_what_does_not_fit_is_refused(record, tmp_path):
    plan = wc.distributed.plan_spacetime
    with pytest.raises(
        ValueError, match=r"memory: expected at least .* found 250 MB: the records of one"
    ):
        plan(record, tmp_path / "out", memory="250 MB")
    long = da.zeros((100_000, 400), chunks=(50_000, 400))
    with pytest.raises(ValueError, match="a chunk of 50000 times x all 400 sites .*shorter chunks"):
        plan(long, tmp_path / "out", memory="600 MB")
    with pytest.raises(ValueError, match="memory: expected what a worker may take"):
        plan(record, tmp_path / "out")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").touch()
    with pytest.raises(ValueError, match="found something else"):
        plan(record, tmp_path / "out", memory="1 GB", show=False).run()
    gap = record.copy()
    gap[700, 5] = np.inf
    with pytest.raises(ValueError, match="found others at time 700"):
        plan(gap, tmp_path / "gap", memory="1 GB", show=False).run()


def test_a_killed_process_is_resumed(stored, tmp_path):
    path, _, expected = stored
    code = (
        "import os, sys, signal, wavecascade as wc\n"
        "plan = wc.distributed.plan_spacetime(sys.argv[1], sys.argv[2], memory='342 MB', show=False)\n"
        "kill = lambda stage, done, total: done > 1 and os.kill(os.getpid(), signal.SIGKILL)\n"
        "plan.run(progress=kill)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path), str(tmp_path / "out")])
    assert done.returncode == -signal.SIGKILL
    with pytest.raises(ValueError, match="expected a finished store"):
        wc.distributed.open_spacetime(tmp_path / "out")
    other = wc.distributed.plan_spacetime(
        path, tmp_path / "out", memory="500 MB", window_time="hann", show=False
    )
    with pytest.raises(ValueError, match="expected the same work to resume, found windows"):
        other.run()
    # As a kill in the middle of a line leaves it.
    with (tmp_path / "out" / ".journal").open("ab") as file:
        file.write(b'["x9')
    plan = wc.distributed.plan_spacetime(path, tmp_path / "out", memory="500 MB", show=False)
    counted = []
    found = plan.run(progress=lambda stage, done, total: counted.append(stage))
    assert counted.count("along x") == plan.blocks[0] - 2 and found.values.tobytes() == expected.tobytes()
    counted.clear()
    plan.run(progress=lambda stage, done, total: counted.append(stage))
    assert counted == []
    # A field that has changed is another.
    shutil.copytree(path, tmp_path / "field")
    begun = wc.distributed.plan_spacetime(tmp_path / "field", tmp_path / "b", memory="1 GB", show=False)
    begun.run()
    zarr.open_array(tmp_path / "field", mode="r+")[0, 0] = 7.0
    with pytest.raises(ValueError, match="expected the same work to resume, found field"):
        wc.distributed.plan_spacetime(tmp_path / "field", tmp_path / "b", memory="1 GB", show=False).run()


def test_a_killed_worker_loses_nothing(stored, client, tmp_path):
    path, field, expected = stored
    # No more than the client's workers have.
    overhead = wc.distributed.plan_spacetime(path, tmp_path / "out", client, show=False).worker.overhead
    memory = int((overhead + 40_000_000) / 0.75)
    plan = wc.distributed.plan_spacetime(path, tmp_path / "out", client, memory=memory, show=False)
    assert plan.worker.limit == memory and plan.blocks[0] > 2
    killed = []

    def kill(stage, done, total):
        if not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[-1], signal.SIGKILL)

    found = plan.run(client, progress=kill)
    assert len(killed) == 1 and found.values.tobytes() == expected.tobytes()
    client.wait_for_workers(2)

    lazy = wc.distributed.averaged(da.from_zarr(os.fspath(path)), segment=128)
    running = client.compute(lazy.spectrum.data)
    os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
    averaged = wc.spectrum(field, segment=128, no_jackknife=True).spectrum.values
    np.testing.assert_allclose(running.result(), averaged, rtol=1e-12)


# Sweeps.


def test_val_program_sweep_in_parts(client, run, tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text("sites = 8\n")
    vary = {"stiffness_ratio": [1, 2, 4.9], "end_time": [3.0, 4.0]}
    expected = wc.sweep({"sites": 8}, vary=vary)
    found = wc.distributed.sweep({"sites": 8}, vary=vary, out=tmp_path / "dask", pool=client, parts=3)
    assert found.equals(expected) and not (tmp_path / "dask-parts").exists()
    # Parts that are begun go on with the split they were begun with.
    wc.sweep({"sites": 8}, vary=vary, out=tmp_path / "split-parts" / "2-of-3", part="2/3")
    pool = ThreadPoolExecutor(2)
    with pytest.raises(ValueError, match="parts: expected 3"):
        wc.distributed.sweep({"sites": 8}, vary=vary, out=tmp_path / "split", pool=pool, parts=2)
    told = []
    wc.distributed.sweep(
        {"sites": 8}, vary=vary, out=tmp_path / "split", pool=pool, progress=lambda *a: told.append(a)
    )
    assert told[-1] == ("parts", 3, 3)
    run("sweep", scene, "--vary=stiffness_ratio=1,2,4.9", "--vary=end_time=3.0,4.0", out="alone")
    tables = [(tmp_path / name / "table.csv").read_bytes() for name in ("alone", "dask", "split")]
    assert tables[0] == tables[1] == tables[2]
    with pytest.raises(ValueError, match="sites"):
        wc.distributed.sweep({"sites": 0}, vary=vary, out=tmp_path / "wrong", pool=pool)
