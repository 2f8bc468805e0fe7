"""The two halves of S(k, f) over a store of Zarr: what their tasks do, and the memory they take."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from wavecascade._large.windows import pairwise_sum, window

Array = npt.NDArray[Any]

#: Bytes a sample of the first half (samples, transforms, what is written), of the second (transforms,
#: spectra), and what the record that is being transformed takes beside: up to 276, of prime lengths.
FIRST, SECOND, RECORD = 28, 26, 300
#: Bytes of a chunk of the result, and of what is transformed at once.
CHUNK = 4 << 20


@dataclass(frozen=True)
class Source:
    """Where samples are read: an array of a store of Zarr, by its path."""

    path: str
    array: str | None
    is_turned: bool

    def opened(self) -> Any:
        """The array."""
        import zarr

        return zarr.open_array(self.path, path=self.array or "", mode="r")

    def read(self, start: int, stop: int) -> Array:
        """Some times of all sites, one chunk of the store after another."""
        array = self.opened()
        if self.is_turned:
            step, n = array.chunks[0], array.shape[0]
            parts = (array[at : at + step, start:stop].T for at in range(0, n, step))
        else:
            step, n = array.chunks[1], array.shape[1]
            parts = (array[start:stop, at : at + step] for at in range(0, n, step))
        rows = np.empty((stop - start, n), array.dtype)
        for i, part in enumerate(parts):
            rows[:, i * step : (i + 1) * step] = part
        return rows

    def fingerprint(self) -> str:
        """Number, bytes and latest change of its files, so that a field that changed is not resumed."""
        root = Path(self.path, self.array or "")
        files = [file.stat() for file in root.rglob("*") if file.is_file()]
        latest = max((file.st_mtime_ns for file in files), default=0)
        return f"{len(files)} files, {sum(file.st_size for file in files)} bytes, {latest}"


@dataclass(frozen=True)
class Job:
    """What every task has to know."""

    store: str
    shape: tuple[int, int]
    bounds: tuple[int, ...]
    wavenumbers: int
    chunk: int
    window_time: Any
    window_space: Any
    factor: float

    def opened(self, name: str, mode: Literal["r", "r+"]) -> Any:
        """An array of the store."""
        import zarr

        return zarr.open_array(self.store, path=name, mode=mode)


def exact(values: Array) -> str:
    """A sum without rounding, so that it does not depend on who adds what."""
    return str(sum((Fraction(float(v)) for v in values), Fraction(0)))


def _joined(parts: list[list[Array]]) -> Array:
    """Chunks as one array, one after another, so that there is no more than one copy."""
    if len(parts) == 1 and len(parts[0]) == 1:
        return parts[0][0]
    shape = sum(len(row[0]) for row in parts), sum(part.shape[1] for part in parts[0])
    whole = np.empty(shape, parts[0][0].dtype)
    n = 0
    for row in parts:
        m = 0
        for part in row:
            whole[n : n + part.shape[0], m : m + part.shape[1]] = part
            m += part.shape[1]
        n += len(row[0])
    return whole


def along_space(job: Job, i: int, source: Any) -> str:
    """The first half: some times along space, to the store; sum of their squares."""
    start, stop = job.bounds[i], job.bounds[i + 1]
    if isinstance(source, Source):
        rows = source.read(start, stop)
    elif isinstance(source, list):
        rows = _joined(source)
    else:
        rows = np.asarray(source)
    nx = job.shape[1]
    if rows.dtype.kind == "c" or rows.shape != (stop - start, nx):
        raise ValueError(
            f"field: expected {stop - start} x {nx} real samples, found {rows.dtype} {rows.shape}"
        )
    across = window(job.window_space, nx)
    taper = None if (across == 1.0).all() else across
    weights = None if job.window_time == "none" else window(job.window_time, job.shape[0])[start:stop]
    found = np.empty((stop - start, nx // 2 + 1), np.complex128)
    energies = np.empty(stop - start)
    from wavecascade.fft import rfft

    step = max(1, CHUNK // (8 * nx))
    for at in range(0, stop - start, step):
        x = np.asarray(rows[at : at + step], np.float64)
        if taper is not None:
            x = x * taper
        if weights is not None:
            x = x * weights[at : at + step, None]
        energies[at : at + step] = pairwise_sum(x * x)
        found[at : at + step] = rfft(x, axis=1)
    if not np.isfinite(energies).all():
        n = int(np.flatnonzero(~np.isfinite(energies))[0])
        raise ValueError(
            f"field: expected finite samples of moderate size, found others at time {start + n}; "
            "fill gaps first"
        )
    del rows
    job.opened("intermediate", "r+")[i, : stop - start, :] = found
    return exact(energies)


def along_time(job: Job, j: int) -> str:
    """The second half: some wavenumbers along time, squared, to the store; their sum."""
    from wavecascade.fft import rfft

    nt, nx = job.shape
    k0, k1 = j * job.wavenumbers, min((j + 1) * job.wavenumbers, nx // 2 + 1)
    between = job.opened("intermediate", "r")
    records = np.empty((k1 - k0, nt), np.complex128)
    for i, (start, stop) in enumerate(pairwise(job.bounds)):
        records[:, start:stop] = between[i, : stop - start, k0:k1].T
    nf = nt // 2 + 1
    spectrum = np.empty((nf, 2, k1 - k0))
    scale = np.where(np.arange(nf) * 2 % nt == 0, job.factor, 2.0 * job.factor)
    # One record at a time: columns take 560 bytes a sample, however few they are.
    for at, record in enumerate(records):
        real, imaginary = rfft(np.stack([record.real, record.imag]), axis=1)
        imaginary *= 1j
        # Of exp(-i k x): towards -x as it is, towards +x at the opposite frequency, where the transforms
        # of both parts are conjugated.
        for side, found in enumerate((real + imaginary, real - imaginary)):
            spectrum[:, side, at] = (np.square(found.real) + np.square(found.imag)) * scale
    del records
    if not np.isfinite(spectrum).all():
        raise ValueError("field: expected samples whose squares are finite, found a spectrum that is not")
    # k = 0 and the Nyquist wavenumber are there once.
    if k0 == 0:
        spectrum[:, 0, 0] = np.nan
    if nx % 2 == 0 and k1 == nx // 2 + 1:
        spectrum[:, 1, -1] = np.nan
    job.opened("spacetime_spectrum", "r+")[:, :, k0:k1] = spectrum
    sums = pairwise_sum(np.nan_to_num(spectrum, copy=False).reshape(1, nf, -1))
    return exact(sums[0])


def first_bytes(rows: int, nx: int) -> int:
    """Memory of a task of the first half."""
    return FIRST * rows * nx + 8 * CHUNK


def second_bytes(nt: int, width: int) -> int:
    """Memory of a task of the second half."""
    return nt * (SECOND * width + RECORD) + 2 * CHUNK
