"""From the sums over all segments to spectra, intervals and coherence."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from wavecascade._axes import Axes
from wavecascade._results import dataset
from wavecascade._segments import Cut, Partial, Sums
from wavecascade._windows import effective_number, interval_factors, sum_of, window

Array = npt.NDArray[Any]

#: As in the program: below it, the energy of the segments is that of a transient.
_LEAST_STEADINESS = 1.0 / 3.0
#: Bytes of a column of numbers that are finished at once.
_AT_ONCE = 1 << 20


def averages(whole: Partial, significance: float) -> dict[str, Array]:
    """The arrays of :func:`wavecascade.combine`'s averages."""
    sums = whole.total()
    bins, width = sums["power"].shape
    step = max(1, _AT_ONCE // (8 * bins))
    found: dict[str, Array] = {}
    # A few columns after others, so that what is between takes no memory.
    for at in range(0, width, step):
        columns = slice(at, min(at + step, width))
        part = {name: a[..., columns] if a.shape[-1] == width else a for name, a in sums.items()}
        for name, array in _some(whole, part, significance).items():
            if array.shape[-1] != columns.stop - at:
                found[name] = array
                continue
            if name not in found:
                found[name] = np.empty((*array.shape[:-1], width), array.dtype)
            found[name][..., columns] = array
    return found


def _some(whole: Partial, sums: Sums, significance: float) -> dict[str, Array]:
    """The same of some columns."""
    cut, axes, count = whole.cut, whole.axes, whole.segments
    length = cut.length
    fold = np.where((np.arange(length // 2 + 1) * 2) % length == 0, 1.0, 2.0)[:, None]
    power = sums["power"]
    if cut.of == "temporal":
        # By way of the variance, as the program does.
        variance = np.add.accumulate(fold * power, axis=0)[-1]
        variance = np.where(variance > 0.0, variance / (length * count), 1.0)
        spectrum = (power * (1.0 / variance)) / count * variance * axes.dt * fold
    elif cut.of == "coherence":
        spectrum = power * (axes.dt / count) * fold
    else:
        weights = window(cut.window_space, whole.sites)
        along_space = axes.dx / sum_of(weights * weights) / (2.0 * np.pi)
        spectrum = power * (axes.dt / count * fold * along_space)
    effective = effective_number(cut.taper(), cut.hop, count)
    squares = sums["energy_squared"]
    steadiness = np.divide(
        sums["energy"] ** 2, count * squares, out=np.ones_like(squares), where=squares > 0.0
    )
    # The transforms at 0 and at the Nyquist frequency are real.
    degrees = np.broadcast_to(fold * effective, spectrum.shape).copy()
    degrees[:, np.broadcast_to(steadiness, spectrum.shape[1:]) < _LEAST_STEADINESS] = np.nan
    degrees[~(spectrum > 0.0)] = np.nan
    if cut.detrend != "none":
        degrees[0] = np.nan
    low, high = np.full_like(spectrum, np.nan), np.full_like(spectrum, np.nan)
    for one in (effective, 2.0 * effective):
        factors, at = interval_factors(one, significance), degrees == one
        low[at], high[at] = factors[0] * spectrum[at], factors[1] * spectrum[at]
    found = {"spectrum": spectrum, "degrees_of_freedom": degrees, "low": low, "high": high}
    found["steadiness"] = steadiness
    if cut.of == "coherence":
        cross, own = sums["cross"], sums["reference"] * power
        squared = cross.real * cross.real + cross.imag * cross.imag
        ratio = np.divide(squared, own, out=np.full_like(own, np.nan), where=own > 0.0)
        found |= {"coherence": np.minimum(ratio, 1.0), "phase": _angles(cross)}
        found["cross_spectrum"] = cross * (axes.dt / count) * fold
    return found


def _angles(z: Array) -> Array:
    """Phases, each by the C library: NumPy's own differ from it in the last bit."""
    return np.asarray(np.frompyfunc(math.atan2, 2, 1)(z.imag, z.real).astype(np.float64))


def described(cut: Cut, axes: Axes, count: int, significance: float) -> dict[str, Any]:
    """Attributes of an average."""
    effective = effective_number(cut.taper(), cut.hop, count)
    attrs = {
        "segment": cut.length,
        "overlap": cut.length - cut.hop,
        "segments": count,
        "effective_segments": effective,
        "window": cut.window if isinstance(cut.window, str) else "given",
        "detrend": cut.detrend,
        "significance": significance,
        "units": json.dumps(dict(axes.units)),
    }
    if cut.of == "coherence" and effective >= 2.0:
        attrs["level"] = -np.expm1(np.log(significance) / (effective - 1.0))
    return attrs


def arranged(cut: Cut, axes: Axes, sites: int, found: Mapping[str, Any], attrs: Mapping[str, Any]) -> Any:
    """Arrays, computed or lazy, with their dimensions and coordinates."""
    units = axes.units
    coordinates = [("frequency", axes.frequency(cut.length), units.get("frequency"))]
    if cut.of == "spacetime":
        across = "wavenumber_signed"
        coordinates.append((across, axes.wavenumber_signed(sites), units.get("wavenumber")))
    else:
        across = "position"
        coordinates.append((across, axes.positions(0, sites), units.get("space")))
    own = axes.spectra.get(("spacetime" if cut.of == "spacetime" else "temporal", "density"))
    arrays = [
        (name, [name], values, {"units": unit} if unit else {}) for name, values, unit in coordinates
    ]
    of_spectrum = {"long_name": "power spectral density"} | ({"units": own} if own else {})
    # One of the whole field, or of the reference.
    single = found["steadiness"][0] if cut.of != "temporal" else None
    for name, array in found.items():
        if name == "steadiness" and single is not None:
            continue
        dims = ["frequency", across][-len(array.shape) :]
        is_spectrum = name in ("spectrum", "low", "high", "cross_spectrum")
        arrays.append((name, dims, array, dict(of_spectrum) if is_spectrum else {}))
    out = dataset({"attributes": {}, "arrays": arrays}, attrs)
    if single is not None:
        out["steadiness"] = single if isinstance(out, dict) else ((), single)
    return out


def averaged(whole: Partial, significance: float) -> Any:
    """The average of a partial that holds all segments."""
    if not 0.0 < significance < 1.0:
        raise ValueError(f"significance: expected a probability from 0 to 1, found {significance}")
    found = averages(whole, significance)
    attrs = described(whole.cut, whole.axes, whole.segments, significance)
    return arranged(whole.cut, whole.axes, whole.sites, found, attrs)
