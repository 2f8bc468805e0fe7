#!/usr/bin/env python3
"""A field in Zarr larger than all workers: time and peak memory beside dask.array.fft and xrft.

    python/check --prepare && target/python/bin/pip install target/wheels/*.whl
    target/python/bin/python benches/large_dask.py --gb 1
    target/python/bin/python benches/large_dask.py --gb 10 --folder /large/disk --log large_dask.txt

Makes a field of white noise in chunks of times, in a new folder of --folder, and has each method
transform it on two workers of one thread with --memory each, one method after another, each with a
cluster of its own:

    cascade         S(k, f) of the whole record, by plan_spacetime
    tasks, p2p      the same by dask.array.fft: rfft along x, rechunk by tasks or peer to peer, fft along
                    t
    xrft            the same by xrft.power_spectrum, which wants the field in one chunk
    cascade-welch   S(f, x) averaged over segments that overlap by half
    xrft-welch      the same by xrft with segments that do not overlap, which are chunks

Prints seconds, the largest resident memory of any worker, and how far the numbers are from those of
NumPy at one wavenumber, or of SciPy at one site; or what the method failed with. A method that is not
done after --timeout seconds, or that the system kills, is named, and the next one follows. Needs xrft,
and three times the field on disk, which is looked for before. The folder is removed at the end, also
after Ctrl-C or SIGTERM.
"""

import argparse
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Of the process that was called; those that it starts are given it.
WORK = pathlib.Path(os.environ.get("LARGE_DASK", ROOT / "target"))
FIELD = WORK / "field.zarr"
# Disk that is needed, in sizes of the field: itself, what is between both halves, and results.
DISK = 3
ROWS = 512
SEGMENT = 1024
METHODS = ["cascade", "tasks", "p2p", "xrft", "cascade-welch", "xrft-welch"]


def make(gb, sites):
    import zarr

    times = int(gb * 1e9 / 8 / sites) // SEGMENT * SEGMENT
    field = zarr.create_array(
        FIELD,
        shape=(times, sites),
        chunks=(ROWS, sites),
        dtype="f8",
        compressors=None,
        dimension_names=("time", "x"),
    )
    noise = np.random.default_rng(1)
    for start in range(0, times, ROWS):
        field[start : start + ROWS] = noise.standard_normal((ROWS, sites))


class Watch:
    """The largest resident memory of any process below this one."""

    def __init__(self):
        self.peak, self.ends = 0, threading.Event()
        self.thread = threading.Thread(target=self.look, daemon=True)

    def look(self):
        page = os.sysconf("SC_PAGE_SIZE")
        while not self.ends.wait(0.02):
            parents = {}
            for folder in pathlib.Path("/proc").glob("[0-9]*"):
                try:
                    parents[int(folder.name)] = int(
                        (folder / "stat").read_text().rpartition(")")[2].split()[1]
                    )
                except (OSError, IndexError):
                    pass
            below = {os.getpid()}
            while more := {pid for pid, parent in parents.items() if parent in below} - below:
                below |= more
            for pid in below - {os.getpid()}:
                try:
                    resident = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * page
                except (OSError, IndexError):
                    continue
                self.peak = max(self.peak, resident)


def spacetime_by_dask(method, memory):
    import dask
    import dask.array as da

    field = da.from_zarr(str(FIELD))
    nt = len(field)
    width = max(1, int(memory / 8 / (16 * nt)))
    with dask.config.set({"array.rechunk.method": method}):
        profiles = da.fft.rfft(field, axis=1).rechunk((nt, width))
        power = abs(da.fft.fft(profiles, axis=0)) ** 2
        power.to_zarr(str(WORK / "out.zarr"), compute=True)


def spacetime_by_xrft():
    import xrft

    field = opened()
    field = field.assign_coords(time=np.arange(field.shape[0]), x=np.arange(field.shape[1]))
    power = xrft.power_spectrum(field.chunk({"time": -1, "x": -1}), dim=["time", "x"])
    power.rename("power").to_dataset().to_zarr(WORK / "out.zarr")


def opened():
    import dask.array as da
    import xarray

    return xarray.DataArray(da.from_zarr(str(FIELD)), dims=("time", "x"))


def run_one(method, memory):
    """One method in this process: a line of JSON with what was found."""
    import dask.utils
    import distributed
    import zarr

    warnings.simplefilter("ignore")
    watch = Watch()
    cluster = distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        memory_limit=memory,
        dashboard_address=":0",
        silence_logs=50,
        local_directory=WORK,
    )
    client = distributed.Client(cluster)
    import wavecascade as wc

    watch.thread.start()
    size = dask.utils.parse_bytes(memory)
    started, apart = time.monotonic(), None
    field = zarr.open_array(FIELD, mode="r")
    nt, nx = field.shape
    if method == "cascade":
        plan = wc.distributed.plan_spacetime(FIELD, WORK / "out", client, show=False)
        print(plan, file=sys.stderr)
        found = plan.run(client)
    elif method in ("tasks", "p2p"):
        spacetime_by_dask(method, size)
    elif method == "xrft":
        spacetime_by_xrft()
    elif method == "cascade-welch":
        found = wc.distributed.averaged(opened(), segment=SEGMENT).compute()
    else:
        import xrft

        data = opened().chunk({"time": SEGMENT}).assign_coords(time=np.arange(nt), x=np.arange(nx))
        power = xrft.power_spectrum(
            data,
            dim="time",
            real_dim="time",
            chunks_to_segments=True,
            window="hann",
            detrend="constant",
        )
        found = power.mean("time_segment").compute()
    seconds = time.monotonic() - started
    watch.ends.set()
    if method == "cascade":
        total = np.zeros(nt)
        for start in range(0, nt, ROWS):
            total[start : start + ROWS] = field[start : start + ROWS].sum(axis=1)
        expected = np.abs(np.fft.rfft(total)) ** 2 / (2 * np.pi)
        expected[1 : len(expected) - (nt % 2 == 0)] *= 2
        power = found[:, nx // 2].values
        apart = float(np.abs(power - expected).max() / expected.max())
    elif method == "cascade-welch":
        import scipy.signal

        record = np.concatenate([field[start : start + ROWS, 7] for start in range(0, nt, ROWS)])
        expected = scipy.signal.welch(record, nperseg=SEGMENT)[1]
        apart = float(np.abs(found.spectrum.values[:, 7] - expected).max() / expected.max())
    print(json.dumps({"seconds": seconds, "peak": watch.peak, "apart": apart}), flush=True)
    client.close()
    cluster.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gb", type=float, default=1.0, help="size of the field")
    parser.add_argument("--sites", type=int, default=4096)
    parser.add_argument("--memory", default="450 MB", help="of each of the two workers")
    parser.add_argument("--only", default=",".join(METHODS), help="methods, separated by commas")
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds for each method")
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "target", help="on which disk")
    parser.add_argument("--log", type=pathlib.Path, help="a new file for what is printed")
    parser.add_argument("--method", choices=METHODS, help=argparse.SUPPRESS)
    parser.add_argument("--make", action="store_true", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.make:
        return make(asked.gb, asked.sites)
    if asked.method:
        return run_one(asked.method, asked.memory)
    unknown = set(asked.only.split(",")) - set(METHODS)
    if unknown:
        parser.error(f"--only: expected {', '.join(METHODS)}, found {', '.join(sorted(unknown))}")
    asked.folder.mkdir(parents=True, exist_ok=True)
    needed, free = DISK * asked.gb * 1e9, shutil.disk_usage(asked.folder).free
    if free < needed:
        parser.error(
            f"--folder: expected {needed / 1e9:.0f} GB free, found {free / 1e9:.0f} GB in {asked.folder}"
        )
    log = asked.log.open("x") if asked.log else None
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    work = asked.folder.resolve() / f"large_dask-{os.getpid()}"
    work.mkdir()
    try:
        run_all(asked, work, log)
    finally:
        shutil.rmtree(work, ignore_errors=True)


def run_all(asked, work, log):
    def say(text):
        print(text, flush=True)
        if log:
            print(text, file=log, flush=True)

    environment = {**os.environ, "LARGE_DASK": str(work)}
    own = [
        sys.executable,
        __file__,
        "--gb",
        str(asked.gb),
        "--sites",
        str(asked.sites),
        "--memory",
        asked.memory,
    ]
    started = time.monotonic()
    subprocess.run([*own, "--make"], check=True, env=environment)
    say(f"field of {asked.gb:g} GB, {asked.sites} sites; two workers of {asked.memory}")
    say(f"{time.strftime('%Y-%m-%d %H:%M')}, made in {time.monotonic() - started:.0f} s")
    say(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores; {versions()}")
    for method in asked.only.split(","):
        child = subprocess.Popen(
            [*own, "--method", method],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            env=environment,
        )
        try:
            said, faults = child.communicate(timeout=asked.timeout)
        except subprocess.TimeoutExpired:
            said, faults = "", f"not done after {asked.timeout:.0f} s"
        finally:
            # Its workers, too.
            try:
                os.killpg(child.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            child.wait()
        lines = [line for line in said.splitlines() if line.startswith("{")]
        if lines:
            found = json.loads(lines[-1])
            apart = "" if found["apart"] is None else f", {found['apart']:.1e} from NumPy or SciPy"
            peak = f"peak {found['peak'] / 1e6:4.0f} MB"
            say(f"{method:14} {found['seconds']:7.1f} s, {peak}{apart}")
        else:
            ended = f"ended by signal {-child.returncode}" if child.returncode < 0 else "nothing"
            last = faults.strip().splitlines()[-1] if faults.strip() else ended
            say(f"{method:14} failed: {last[:300]}")
        if method == "cascade":
            plan = [line for line in faults.splitlines() if line.startswith(("S(k", "  "))]
            say("\n".join(plan)[:2000])
        for path in work.iterdir():
            if path.name != FIELD.name:
                shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink()


def versions():
    from importlib.metadata import version

    return ", ".join(f"{name} {version(name)}" for name in ("dask", "xrft", "zarr", "numpy"))


if __name__ == "__main__":
    main()
