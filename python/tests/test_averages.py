"""Averages over segments: of blocks, of Dask arrays, in workers; the same bits, and the same warnings."""

import json
import os
import pickle
import time
import warnings
from contextlib import contextmanager
from itertools import pairwise

import numpy as np
import pytest

import wavecascade as wc
from conftest import same
from wavecascade import _native
from wavecascade._large import workers
from wavecascade._large.averaged import _bytes_of_a_state
from wavecascade._large.workers import WorkerMemory

xr = pytest.importorskip("xarray")
da = pytest.importorskip("dask.array")
distributed = pytest.importorskip("distributed")

KINDS = [
    {},
    {"multitaper": (3, 4), "detrend": "linear"},
    {"window": "tukey:0.3", "detrend": "none"},
    {"estimate": "coherence", "reference": 3},
]


def same_bits(found, expected) -> None:
    assert set(found.variables) == set(expected.variables)
    for name in expected.variables:
        a, b = found[name], expected[name]
        assert a.dims == b.dims and a.attrs == b.attrs, name
        assert np.asarray(a.values).tobytes() == np.asarray(b.values).tobytes(), name
    assert found.attrs == expected.attrs


def whole_of(field, estimate="spectrum", **options):
    """The estimate of a whole field, as partial sums know it."""
    if estimate != "spectrum":
        return getattr(wc, estimate)(field, **options)
    found = wc.spectrum(field, **options, no_jackknife=True)
    # The noise is read off whole records.
    noise = [name for name in found.variables if str(name).startswith("noise")]
    return found.drop_vars(noise)


def same_arrays(found, expected, names=None) -> None:
    """That arrays have the same numbers, units and places, whatever their summaries say."""
    for name in expected.variables if names is None else names:
        a, b = found[name], expected[name]
        assert a.dims == b.dims and a.attrs == b.attrs, name
        np.testing.assert_allclose(a.values, b.values, rtol=1e-12, err_msg=str(name))


def blocks(record, cuts, length, hop, **options):
    """Partial sums of the segments between cuts, each from its own samples alone."""
    for first, last in pairwise(cuts):
        rows = record[first * hop : (last - 1) * hop + length]
        place = {"first": first * hop, "times": len(record)}
        yield wc.partial(rows, segment=length, overlap=length - hop, **place, **options)


@pytest.mark.parametrize("options", KINDS)
def test_blocks_have_the_bits_of_the_whole_run(record, run, tmp_path, options):
    words = {"dt": 0.5, "dx": "2 mm"}
    # Segments 0 to 4, 5 to 23, and the rest of 60.
    parts = list(blocks(record, [0, 5, 24, 60], 64, 24, **words, **options))
    assert [one.segments for one in parts] == [(0, 5), (5, 24), (24, 60)]
    expected = whole_of(record, segment=64, overlap=40, **words, **options)
    for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        same_arrays(wc.combine([parts[i] for i in order]), expected)
    # The files are those of the program.
    command = options.get("estimate", "spectrum")
    files = [tmp_path / f"{i}.npz" for i in range(3)]
    for one, path in zip(parts, files, strict=True):
        one.save(path)
    same_bits(wc.combine(wc.Partial.load(path) for path in files), wc.combine(parts))
    same_bits(wc.combine(pickle.loads(pickle.dumps(parts))), wc.combine(parts))
    # Buffers from other processes lie at any byte.
    about, sums = parts[0].__reduce__()[1]
    apart = np.frombuffer(b" " + sums.tobytes(), offset=1)
    same_bits(wc.combine([wc.Partial(about, apart), *parts[1:]]), wc.combine(parts))
    out = run(command, "--merge", *files, out="merged")
    with np.load(out / f"{command}.npz") as archive:
        same(wc.combine(parts), archive)
    np.save(tmp_path / "field.npy", record)
    typed = ["--segment=64", "--overlap=40", "--dt=0.5", "--dx=2 mm"]
    typed += [f"--{name.replace('_', '-')}={text(value)}" for name, value in options.items()]
    typed = [word for word in typed if "estimate" not in word]
    out = run(command, tmp_path / "field.npy", *typed, "--part=2/3", out="second")
    second = wc.partial(record, segment=64, overlap=40, part=(2, 3), **words, **options)
    theirs = wc.Partial.load(out / "part.npz")
    assert second.segments == theirs.segments == (20, 40)
    ours = [wc.partial(record, segment=64, overlap=40, part=f"{i}/3", **words, **options) for i in (1, 3)]
    same_arrays(wc.combine([*ours, second]), expected)


def text(value) -> str:
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def test_blocks_of_labelled_fields_and_shots(record, labelled):
    expected = whole_of(labelled, segment=128)
    hop = 64
    found = []
    for first, last in pairwise([0, 9, 22]):
        rows = labelled.isel(time=slice(first * hop, (last - 1) * hop + 128))
        found.append(wc.partial(rows, segment=128, first=first * hop, times=1501))
    same_arrays(wc.combine(found), expected)
    # Parts of several records.
    shots = np.stack([record[:700], record[700:1400]])
    expected = whole_of(shots, segment=100)
    parts = [wc.partial(shots, segment=100, part=(i, 4)) for i in (4, 2, 1, 3)]
    same_arrays(wc.combine(parts), expected)


@pytest.mark.parametrize("options", KINDS)
@pytest.mark.parametrize("chunks", [(1501, 23), (97, 5), ((30, 1, 870, 600), (22, 1))])
def test_averages_of_dask_arrays_are_lazy_with_the_same_bits(record, labelled, options, chunks):
    lazy = labelled.copy(data=da.from_array(record, chunks=chunks))
    found = wc.distributed.averaged(lazy, segment=128, **options)
    main = options.get("estimate", "spectrum")
    assert hasattr(found[main].data, "dask")
    expected = whole_of(labelled, segment=128, **options)
    names = [name for name in expected.variables if name in found]
    least = {"coherence": {"delay"}, "spectrum": {"low", "high"}}
    assert {"frequency", main} | least[main] <= set(names)
    same_arrays(found.compute(scheduler="synchronous"), expected, names)


def test_sums_that_are_left_over_are_not_copied(record, monkeypatch):
    joined, join = [], _native.join
    monkeypatch.setattr(_native, "join", lambda *given: joined.append(len(given[0])) or join(*given))
    # 9 chunks of times.
    lazy = wc.distributed.averaged(da.from_array(record, chunks=((160,) * 9 + (61,), 23)), segment=128)
    found = lazy.compute(scheduler="synchronous")
    assert joined == [2] * 8
    same_arrays(found, whole_of(record, segment=128), ["spectrum", "low", "high"])


def test_averages_of_bare_dask_arrays_of_single_precision(record):
    single = record.astype("f4")
    lazy = da.from_array(single, chunks=(100, 4))
    for options in ({}, {"dt": "2 ms", "dx": 3, "unit": "m/s"}):
        expected = whole_of(single, segment=128, **options)
        found = wc.distributed.averaged(lazy, segment=128, **options).compute()
        names = [name for name in expected.variables if name in found]
        assert "position" in names
        same_arrays(found, expected, names)
        assert found.attrs["time_unit"] == whole_of(single, segment=128, dt=options.get("dt")).time_unit
    # A reference that is no site.
    other = record[:, 3] + record[:, 5]
    beside = np.concatenate([other[:, None], record], axis=1)
    expected = wc.coherence(beside, segment=128)
    lazy = da.from_array(record, chunks=(300, 7))
    found = wc.distributed.averaged(lazy, "coherence", reference=other, segment=128).compute()
    np.testing.assert_allclose(found.coherence, expected.coherence[:, 1:], rtol=1e-12)
    level = json.loads(wc.coherence(record, segment=128).attrs["independence"])["steadiness"]
    own = wc.distributed.averaged(lazy, "coherence", segment=128).compute()
    assert (
        float(own.steadiness) == level and own.attrs["level"] == wc.coherence(record, segment=128).level
    )


@contextmanager
def heard(action="always"):
    """What reaches the user meanwhile."""
    found = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter(action)
        yield found
        found += [str(one.message) for one in caught if one.category is wc.CascadeWarning]


@pytest.fixture(scope="module")
def bursts(record):
    """The same with transients at two sites far apart."""
    field = record.copy()
    field[:, [3, 17]] = 0.0
    field[200:260, [3, 17]] = record[:60, [3, 17]]
    return field


def whole_and_parts(estimate, options):
    """A warning of a whole run as it is, and as it is where sites are in several chunks."""
    with heard() as whole:
        estimate(**options)
    assert len(whole) == 1
    return whole[0], whole[0].replace("2 of 23 sites", "some of 23 sites")


def test_warnings_of_tasks_reach_the_user_once(bursts):
    averaged = wc.distributed.averaged
    whole, parts = whole_and_parts(wc.spectrum, {"field": bursts, "segment": 128, "no_jackknife": True})
    assert whole.startswith("2 of 23 sites have a transient") and whole != parts
    for chunks, expected in (((400, 5), parts), ((400, 23), whole), ((1501, 1), parts)):
        lazy = averaged(da.from_array(bursts, chunks=chunks), segment=128)
        with heard() as found:
            lazy.compute(scheduler="threads")
        assert found == [expected]
        # Each computation by itself, and each array.
        lazy = averaged(da.from_array(bursts, chunks=chunks), segment=128)
        with heard() as found:
            lazy.spectrum.compute(scheduler="threads")
        assert found == [expected]
    # Sites that are steady say nothing of others.
    with heard() as found:
        averaged(da.from_array(bursts, chunks=(400, 5)), segment=128).spectrum[:, 5:10].compute(
            scheduler="threads"
        )
    assert found == []
    options = {"segment": 128, "reference": 3}
    _, expected = whole_and_parts(wc.coherence, {"field": bursts, **options})
    assert expected.startswith("one transient is one realisation")
    with heard() as found:
        averaged(da.from_array(bursts, chunks=(400, 5)), "coherence", **options).compute(
            scheduler="threads"
        )
    assert found == [expected]


def test_warnings_of_workers_reach_the_client_once(bursts, client):
    _, expected = whole_and_parts(wc.spectrum, {"field": bursts, "segment": 128, "no_jackknife": True})
    lazy = wc.distributed.averaged(da.from_array(bursts, chunks=(400, 5)), segment=128)
    before = len(client.get_events("warn"))
    with heard("default") as found:
        client.compute(lazy).result()
        # They come on the same way as the results, but another thread takes them.
        time.sleep(0.2)
    assert found == [expected]
    assert 1 <= len(client.get_events("warn")) - before <= 2
    # A worker in the process of the client.
    local = {"processes": False, "n_workers": 1, "dashboard_address": ":0", "silence_logs": 50}
    with distributed.LocalCluster(**local) as cluster, distributed.Client(cluster) as other:
        lazy = wc.distributed.averaged(da.from_array(bursts, chunks=(400, 5)), segment=128)
        with heard() as found:
            filters = list(warnings.filters)
            other.compute(lazy).result()
            time.sleep(0.2)
            assert warnings.filters == filters
        assert found == [expected]


def test_tasks_keep_to_the_memory_of_their_worker(record, client, monkeypatch):
    averaged, here = wc.distributed.averaged, {"scheduler": "threads"}
    assert WorkerMemory.here() is None
    there = client.submit(WorkerMemory.here).result()
    assert there.limit == 420_000_000 and there.at_once == 1 and 50e6 < there.overhead <= 220e6
    assert there.task == int(0.75 * 420_000_000 - there.overhead)
    processes = client.run(os.getpid)
    # 384 bytes a sample.
    long = averaged(da.zeros((1_000_000, 8), chunks=(500_000, 8)), segment=1_000_000)
    message = (
        r"the spectra of this part needs .* of memory, allowed are .*, in a worker of 420 MB that runs "
        r"1 tasks at once beside .* of Python and 128 MB of samples in each; give workers more memory or "
        r"fewer threads"
    )
    with pytest.raises(MemoryError, match=message):
        client.compute(long.spectrum).result()
    assert client.run(os.getpid) == processes
    # What is stated is taken.
    lazy = da.from_array(record, chunks=(1501, 23))
    stated = averaged(lazy, segment=128, memory="30 kB")
    for result in (lambda: client.compute(stated).result(), lambda: stated.compute(**here)):
        with pytest.raises(MemoryError, match=r"allowed are 29.30 KiB\nraise"):
            result()
    # Bits are those without a limit, in the least memory that does.
    # Segments reach sample 1472.
    samples = 8 * 23 * 1472
    least = 2_000_000 + samples
    again = averaged(lazy, segment=128, threads=1)
    expected = again.compute(**here)
    same_arrays(client.compute(again).result(), expected)
    with monkeypatch.context() as patched:
        patched.setattr(WorkerMemory, "here", lambda least=least: WorkerMemory(2 * least, least // 2, 1))
        same_arrays(again.compute(**here), expected)
        small = WorkerMemory(2_000_000, 1_450_000 - samples, 1)
        patched.setattr(WorkerMemory, "here", lambda small=small: small)
        with pytest.raises(MemoryError, match="allowed are 48.83 KiB, in a worker of 2 MB"):
            again.compute(**here)


def test_all_tasks_have_the_memory_and_threads_of_one(record, monkeypatch):
    averaged, given = wc.distributed.averaged, {"partial": [], "join": [], "combine": []}

    def watch(name, function):
        def watched(*arguments, **keywords):
            given[name].append((arguments, keywords))
            return function(*arguments, **keywords)

        monkeypatch.setattr(_native, name, watched)

    def words_given(begin):
        words = [word for (_, words, _), _ in given["partial"] for word in words]
        return [word.removeprefix(begin) for word in words if word.startswith(begin)]

    for name in given:
        watch(name, getattr(_native, name))
    lazy = da.from_array(record, chunks=((600, 901), 23))
    kinds = [{}, {"estimate": "coherence"}]
    # What is stated, as it is.
    for kind in kinds:
        averaged(lazy, segment=128, memory="300 MB", threads=2, **kind).compute(scheduler="synchronous")
        for (_, words, _), _ in given["partial"]:
            assert {"--memory=300 MB", "--threads=2"} < set(words)
        assert {arguments[1] for arguments, _ in given["join"]} == {"300 MB"}
        assert {arguments[1:] for arguments, _ in given["combine"]} == {("300 MB",)}
        assert all(keywords == {"threads": 2} for _, keywords in given["combine"])
        assert all(given.values())
        for calls in given.values():
            calls.clear()
    # Else the share of a task in a worker, and one core. Of it go samples: those of two chunks and their
    # copy, 0 to 704, and those of one, 640 to 1472.
    worker = WorkerMemory(100_000_000, 25_000_000, 1)
    monkeypatch.setattr(WorkerMemory, "here", lambda: worker)
    monkeypatch.setattr(workers, "_worker", lambda: worker)
    found = averaged(lazy, segment=128).compute(scheduler="synchronous")
    held = [2 * 8 * 23 * 704, 8 * 23 * 832]
    shares = sorted(int(word) for word in words_given("--memory="))
    assert shares == sorted(50_000_000 - samples for samples in held)
    assert words_given("--threads=") == ["1", "1"]
    assert [arguments[1] for arguments, _ in given["join"]] == ["50000000"]
    assert [keywords for _, keywords in given["combine"]] == [{"threads": 1}]
    assert [arguments[1] for arguments, _ in given["combine"]] == ["50000000"]
    same_arrays(found, whole_of(record, segment=128), ["spectrum", "low", "high"])
    # One core also in a worker without a limit.
    monkeypatch.setattr(WorkerMemory, "here", lambda: None)
    for calls in given.values():
        calls.clear()
    averaged(lazy, segment=128).compute(scheduler="synchronous")
    assert words_given("--threads=") == ["1", "1"]
    assert words_given("--memory=") == []
    assert [(arguments[1], keywords) for arguments, keywords in given["combine"]] == [
        (None, {"threads": 1})
    ]


@pytest.mark.parametrize("options", KINDS)
@pytest.mark.parametrize(("segment", "times"), [(64, 1501), (9, 30), (100, 110)])
def test_bytes_of_a_state_are_known_without_sums(options, segment, times):
    noise = np.random.default_rng(55).standard_normal((segment, 8))
    options = {**options, "segment": segment, "overlap": segment // 3}
    if "multitaper" in options:
        options["multitaper"] = (2, 3)
    node = wc.partial(noise, first=0, times=times, **options)
    count = (times - segment) // (segment - segment // 3) + 1
    cut = segment, segment - segment // 3, count
    tapers = 3 if "multitaper" in options else 1
    most = 8 * _bytes_of_a_state(options.get("estimate", "spectrum"), cut, tapers)
    assert 0.3 * most < node.nbytes <= most


def test_val_welch(record):
    signal_ = pytest.importorskip("scipy.signal")
    f, power = signal_.welch(record, 2.0, "hann", 128, 64, axis=0, detrend="constant")
    found = wc.combine(blocks(record, [0, 7, 22], 128, 64, dt=0.5))
    np.testing.assert_allclose(found.spectrum[1:], power[1:], rtol=1e-12)
    np.testing.assert_allclose(found.frequency, f, rtol=1e-15)


def test_errors_of_averages(record):
    averaged = wc.distributed.averaged
    lazy = da.from_array(record, chunks=(100, 23))
    with pytest.raises(
        ValueError, match="segment: expected 4 samples to the 1501 of the record, found 4000"
    ):
        averaged(lazy, segment=4000)
    with pytest.raises(ValueError, match="overlap"):
        wc.partial(record, segment=64, overlap=64)
    with pytest.raises(ValueError, match="han"):
        wc.partial(record, segment=64, window="han")
    with pytest.raises(ValueError, match="reference: expected a site from 0 to 22, found 23"):
        averaged(lazy, "coherence", segment=64, reference=23)
    for estimate in ("modes", "bicoherence"):
        with pytest.raises(ValueError, match="estimate: expected spectrum or coherence, found"):
            averaged(lazy, estimate)
    with pytest.raises(ValueError, match="reference: expected none with spectrum, found 3"):
        averaged(lazy, segment=64, reference=3)
    for estimate in ("spectrum", "coherence"):
        message = "part: expected none, since the chunks are the parts, found '1/2'; use partial"
        with pytest.raises(ValueError, match=message):
            averaged(lazy, estimate, segment=64, part="1/2")
    with pytest.raises(ValueError, match="along: expected spectra along time, in parts"):
        averaged(lazy, along="space")
    with pytest.raises(ValueError, match="first: expected samples from 0 on"):
        wc.partial(record, segment=64, first=-1, times=1501)
    with pytest.raises(ValueError, match="first: expected it together with times"):
        wc.partial(record, segment=64, first=3)
    with pytest.raises(ValueError, match="first: expected a block of the 1500 samples of a record"):
        wc.partial(record, segment=64, first=0, times=1500)
    with pytest.raises(TypeError, match="segmnet"):
        wc.partial(record, segment=64, segmnet=3)
    gap = record.copy()
    gap[700, 5] = np.nan
    with pytest.raises(ValueError, match="time row 700, site 5"):
        averaged(da.from_array(gap, chunks=(600, 23)), segment=64).compute()
    parts = list(blocks(record, [0, 5, 24, 60], 64, 24))
    with pytest.raises(ValueError, match="found no segments 5 to 23"):
        wc.combine([parts[0], parts[2]])
    with pytest.raises(ValueError, match="found no segments 0 to 4"):
        wc.combine(parts[1:])
    with pytest.raises(ValueError, match="each part once, found segments 5 to 23"):
        wc.combine([*parts, parts[1]])
    other = wc.partial(record, segment=64, overlap=40, dt=0.5)
    with pytest.raises(ValueError, match="parts of one result"):
        wc.combine([parts[0], other])
    with pytest.raises(ValueError, match="at least one part"):
        wc.combine([])
    with pytest.raises(ValueError, match="partial: "):
        wc.Partial("{}", np.zeros(3))
    about, sums = parts[0].__reduce__()[1]
    with pytest.raises(ValueError, match="sums from segment 0 on"):
        wc.combine([wc.Partial(about, sums[:-1]), *parts[1:]])


def test_combining_takes_the_memory_it_may(record):
    tapers = {"multitaper": (3, 5)}
    parts = list(blocks(record, [0, 7, 22], 128, 64, **tapers))
    same_bits(wc.combine(parts, memory="300 MB"), wc.combine(parts))
    same_bits(wc.combine(parts, memory=300_000_000), wc.combine(parts))
    for memory in ("100 kB", 100_000):
        with pytest.raises(MemoryError, match="the result of these parts needs .* allowed are 97.66 KiB"):
            wc.combine(parts, memory=memory)
    with pytest.raises(ValueError, match='memory: expected a size such as 500MB or 2GiB, found "much"'):
        wc.combine(parts, memory="much")
