"""Estimates: averages over realisations, with their significance.

All are commands of the program on one or several fields. Each has its options and its function here, and
a line in :class:`EstimateMethods`; :func:`_made` does the rest, and :func:`documented` adds what all
docstrings have in common.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, Unpack

from wavecascade import _native
from wavecascade._arrays.fields import pair, shots, source
from wavecascade._arrays.mapped import over
from wavecascade._arrays.results import dataset, hold, summary_attrs, warn
from wavecascade._commands.documented import documented
from wavecascade._commands.methods import FieldMethods, method
from wavecascade._keywords.advice import advising
from wavecascade._keywords.options import (
    AverageOptions,
    FieldOptions,
    Gaps,
    Measure,
    Range,
    SegmentOptions,
    ShotOptions,
    Sites,
    TripleOptions,
    Window,
)
from wavecascade._keywords.words import Progress, observed, words

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["bicoherence", "coherence", "flux", "increments", "modes", "ridges", "slope", "spectrum"]

#: Parts of summaries that repeat arrays.
_IN_ARRAYS = frozenset({"columns", "delays", "outputs", "speeds"})


def _made(
    command: str,
    known: Any,
    field: Any,
    options: Mapping[str, object],
    progress: Progress,
    other: Any = None,
    sites: Mapping[str, int] = MappingProxyType({}),
) -> Any:
    """The estimate of a field, of several, or of two records.

    ``known`` are the options of the command; ``sites`` those for which two records stand, of which the
    first is the input.
    """
    if other is not None:
        return _estimated(command, known, field, options, progress, other, sites)
    of = partial(_estimated, command, known, options=options, progress=progress)
    return over(of, field, options, is_of_shots=True)


def _estimated(
    command: str,
    known: Any,
    field: Any,
    options: Mapping[str, object],
    progress: Progress,
    other: Any = None,
    sites: Mapping[str, int] = MappingProxyType({}),
) -> Any:
    given = dict(options)
    dim = given.pop("shot_dim", None)
    fields = shots(field, given, dim, other is not None)
    if other is not None:
        for option in sites:
            if given.get(option) is not None:
                raise ValueError(
                    f"{option.rstrip('_')}: expected none beside two records, whose sites are 0 and 1, "
                    f"found {given[option]}"
                )
        given |= sites
        others = shots(other, given, dim, True)
        if len(fields) != len(others):
            raise ValueError(
                f"other: expected as many records as of the first, {len(fields)}, found {len(others)}"
            )
        fields = [pair(one, two) for one, two in zip(fields, others, strict=True)]
    sources, typed = opened(fields, given)
    allowed = frozenset(known.__annotations__) | frozenset(FieldOptions.__annotations__)
    names = ["field"] * len(sources)
    said = words(command, typed, allowed, names)
    with advising(allowed, sources[0] if sources else None):
        found = _native.found(said, observed(progress), sources)
    warn(found)
    return arranged(found)


def opened(fields: Iterable[Any], options: Mapping[str, object]) -> tuple[list[Any], dict[str, object]]:
    """Fields as sources of the native half, and the options that they leave."""
    sources = []
    left: dict[str, object] = {}
    for one in fields:
        # What a field uses up, it uses up for itself.
        left = dict(options)
        sources.append(source(one, left))
    return sources, left


def arranged(found: Mapping[str, Any]) -> Any:
    """What the native half found, as a dataset."""
    arrays = {name for name, *_ in found["arrays"]}
    out = dataset(found, summary_attrs(found["summary"], without=arrays | _IN_ARRAYS))
    if "page" in found:
        hold(out, found["page"])
    return out


class BicoherenceOptions(TripleOptions, total=False):
    """The options of ``cascade bicoherence``."""

    site: int
    output: int
    along: Sites
    every: int
    transfer: int
    lag: int
    highest: Measure
    resamplings: int


@documented
def bicoherence(
    field: Any, other: Any = None, *, progress: Progress = None, **options: Unpack[BicoherenceOptions]
) -> xr.Dataset:
    """Coupling of three frequencies, f3 = f1 + f2, of one site, between two, and along x.

    b^2(f1, f2) = |<X1 X2 conj(X3)>|^2 / (<|X1 X2|^2> <|X3|^2>), 0 to 1, over realisations: segments and
    shots. The biphase is the phase of the mean in the numerator.

    Parameters
    ----------
    field
        Samples ``(time, site)`` as for :func:`analyze`. Repeated records of the same sites (shots) are a
        sequence of them, a leading dimension of an array, or of a DataArray the dimension ``shot`` or
        ``shot_dim``.
    other
        The record of the sum, where ``field`` is the record of the two that are added: both
        ``(time)``, or ``(shot, time)``.
    **options
        Those of ``cascade bicoherence``: ``site``, ``output``, ``along=(first, end)``, ``every``,
        ``segment``, ``overlap``, ``window``, ``detrend``, ``gaps``, ``significance``, ``threads``, and
        how the field is read. ``transfer``, a site, fits the transfer
        Y(f) = L(f) X(f) + sum over f1 + f2 = f of Q(f1, f2) X(f1) X(f2) from ``site`` to it, with ``lag``
        (samples), ``highest`` (cycles per unit of time) and ``resamplings``.

    Returns
    -------
    xarray.Dataset or dict
        ``first``, ``second``, ``third`` (cycles per unit of time), ``bicoherence``, ``biphase`` (rad) of
        each ``triple``; ``along_largest`` and its neighbours ``(frequency, along_site)``. Levels of
        significance are attributes. Of a transfer ``transfer_input``, ``transfer_output``,
        ``transfer_magnitude``, ``transfer_phase`` (rad), ``transfer_linear``, ``transfer_gain``,
        ``transfer_residual``, ``transfer_flux``, ``transfer_above`` with standard errors
        ``(transfer_frequency)``; ``transfer_pair_first``, ``transfer_pair_re`` and their neighbours of
        each ``transfer_pair``; shares of the output's power are in the attribute ``transfer``.
    """
    return _made(
        "bicoherence", BicoherenceOptions, field, options, progress, other, {"site": 0, "output": 1}
    )


class CoherenceOptions(AverageOptions, total=False):
    """The options of ``cascade coherence``."""

    reference: int


@documented
def coherence(
    field: Any, other: Any = None, *, progress: Progress = None, **options: Unpack[CoherenceOptions]
) -> xr.Dataset:
    """Coherence, phase, delay and phase velocity of all sites against a reference.

    gamma_j^2 = |S_rj|^2 / (S_rr S_jj) and phase_j = arg S_rj, with S_ij = <conj(X_i) X_j> over
    realisations: segments, tapers and shots.

    Parameters
    ----------
    other
        A record beside that of the reference: both ``(time)``, or ``(shot, time)``.
    **options
        Those of ``cascade coherence``: ``reference`` (a site by index), ``segment``, ``overlap``,
        ``window``, ``multitaper=(4, 7)``, ``detrend``, ``gaps``, ``significance``, ``threads``, and how
        the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``coherence``, ``phase`` and ``phase_interval`` (rad), ``spectrum`` ``(frequency, position)``;
        ``delay``, ``delay_error``, ``delay_interval``, ``delay_ambiguity`` ``(position)``, positive
        behind the reference; ``phase_velocity`` and its neighbours ``(speed_frequency)``. Averages
        (``independence``), the level of significance and the ``velocity`` of the waves are attributes.
    """
    return _made("coherence", CoherenceOptions, field, options, progress, other, {"reference": 0})


class FluxOptions(ShotOptions, total=False):
    """The options of ``cascade flux``."""

    mass_per_length: Measure | Sequence[Measure]
    group_velocity: Measure
    dispersion: str
    towards: Literal["both", "plus-x", "minus-x"]
    bands: int
    gaps: Gaps


@documented
def flux(field: Any, *, progress: Progress = None, **options: Unpack[FluxOptions]) -> xr.Dataset:
    """Flux of energy both ways, by frequency and site, and the loss of the waves.

    P(f, x) = m v_g |A|^2 exp(-2 a x) of waves A exp(-(a + i k) x) towards +x, and of those towards -x.

    Parameters
    ----------
    **options
        Those of ``cascade flux``: ``mass_per_length`` (``"0.3kg/m"``, or of each site of a cell),
        ``group_velocity`` or ``dispersion`` (``"c*k^2; c=0.5"``), ``towards`` as ``"both"``,
        ``"plus-x"`` or ``"minus-x"``, ``bands``, ``gaps``, ``significance``, ``threads``, and how the
        field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``flux_plus``, ``flux_minus``, ``flux_net`` ``(frequency, position)``, their totals
        ``total_plus`` and so on ``(position)``; ``wavenumber``, ``group_velocity``, ``attenuation``,
        ``attenuation_decibels``, ``loss_factor``, ``quality_factor`` ``(frequency)``; half of each
        interval has ``_half`` behind the name; NaN where none is stated, with the reason in the attribute
        ``bands``.
    """
    return _made("flux", FluxOptions, field, options, progress)


class IncrementsOptions(ShotOptions, total=False):
    """The options of ``cascade increments``."""

    separations: int | Sequence[int]
    lags: int | Sequence[int]
    band: Range
    lag_band: Range
    histograms: int


@documented
def increments(
    field: Any, *, progress: Progress = None, **options: Unpack[IncrementsOptions]
) -> xr.Dataset:
    """Structure functions and intermittency, along x and in time.

    S_p(r) = <|d|^p> with d = v(x + r, t) - v(x, t), p = 1 .. 6, and the same over lags in time.

    Parameters
    ----------
    **options
        Those of ``cascade increments``: ``separations`` (sites), ``lags`` (samples), ``band`` and
        ``lag_band`` as ``(from, to)`` over which exponents are fitted, ``histograms``,
        ``significance``, ``threads``, and how the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``space_structure``, ``space_structure_half`` ``(space_scale, order)``, orders 1 to 6;
        ``space_third``, ``space_flatness``, ``space_skewness`` ``(space_scale)`` with half of their
        intervals (``_half``); ``space_histogram_density``; and the same with ``time_``. Exponents are in
        the attribute ``axes``.
    """
    return _made("increments", IncrementsOptions, field, options, progress)


class ModesOptions(AverageOptions, total=False):
    """The options of ``cascade modes``."""

    frequencies: float | Sequence[float]
    modes: int


@documented
def modes(field: Any, *, progress: Progress = None, **options: Unpack[ModesOptions]) -> xr.Dataset:
    """Motions that are coherent along x, by frequency (spectral proper orthogonal decomposition).

    At each frequency, int S(x, x', f) phi(x') dx' = lambda phi(x), with S the cross-spectral density
    over realisations and int |phi|^2 dx = 1.

    Parameters
    ----------
    **options
        Those of ``cascade modes``: ``frequencies`` whose modes are kept, ``modes`` (how many),
        ``segment``, ``overlap``, ``window``, ``multitaper``, ``detrend``, ``gaps``, ``significance``,
        ``threads``, and how the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``eigenvalues`` ``(frequency, mode)``, the one-sided power spectral density of each mode
        integrated over x, descending; ``total`` ``(frequency)``; ``interval`` ``(frequency, end)``,
        factors of the ends; ``mode_real``, ``mode_imag`` ``(mode_frequency, kept_mode, position)``.
    """
    return _made("modes", ModesOptions, field, options, progress)


class RidgesOptions(SegmentOptions, total=False):
    """The options of ``cascade ridges``."""

    fit: str | Sequence[str]
    window_time: Window
    window_space: Window
    cut: Literal["auto", "frequency", "wavenumber"]
    range: float
    points: int


@documented
def ridges(field: Any, *, progress: Progress = None, **options: Unpack[RidgesOptions]) -> xr.Dataset:
    """Dispersion read off S(k, f): ridges above the noise, their velocities, laws fitted to them.

    Phase velocity 2 pi f / k and group velocity 2 pi df / dk, at peaks of S along k or along f.

    Parameters
    ----------
    **options
        Those of ``cascade ridges``: ``fit`` (``"monatomic"``, ``"diatomic"``, a formula such as
        ``"c*abs(k); c=1"``, or a list), ``segment``, ``overlap``, ``window_time``, ``window_space``,
        ``cut``, ``range`` (dB), ``points``, ``detrend``, ``gaps``, ``significance``, ``threads``, and
        how the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``branch``, ``frequency``, ``wavenumber`` (rad, positive towards +x), ``phase_velocity``,
        ``group_velocity`` with their errors, ``power``, ``noise``, ``width`` of each ``point``;
        ``fit_0_frequency`` ``(fit_0_branch, fit_0_wavenumber)``. Fitted parameters are in the attribute
        ``fits``.
    """
    return _made("ridges", RidgesOptions, field, options, progress)


class SlopeOptions(AverageOptions, total=False):
    """The options of ``cascade slope``."""

    along: Literal["space", "time"]
    band: Range
    breaks: int
    frames: int


@documented
def slope(field: Any, *, progress: Progress = None, **options: Unpack[SlopeOptions]) -> xr.Dataset:
    """The power law of a spectrum over a band, its breaks, and along x its change in time.

    S = a k^n (or a f^n) by least squares in ln S over the band.

    Parameters
    ----------
    **options
        Those of ``cascade slope``: ``band=(from, to)``, which is required: rad per unit of length, or
        along time cycles per unit of time; ``along`` as ``"space"`` or ``"time"``, ``breaks``,
        ``frames``, ``segment``, ``overlap``, ``window``, ``multitaper``, ``detrend``, ``gaps``,
        ``significance``, ``threads``, and how the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``spectrum``, ``compensated`` ``(wavenumber)``, or ``(frequency)`` along time; along x
        ``frame_slope``, ``frame_slope_half``, ``frame_gradient`` ``(frame_time)``. The law with half of
        its interval is the attribute ``law``; ``breaks`` and ``steepening`` beside it.
    """
    return _made("slope", SlopeOptions, field, options, progress)


class SpectrumOptions(AverageOptions, total=False):
    """The options of ``cascade spectrum``."""

    along: Literal["time", "space", "both"]
    periodogram: bool
    equal_weights: bool
    no_jackknife: bool
    space_window: Window
    space_multitaper: str | tuple[float, int]
    subtract_noise: bool


@documented
def spectrum(field: Any, *, progress: Progress = None, **options: Unpack[SpectrumOptions]) -> xr.Dataset:
    """Power spectral densities of all sites, or of all snapshots, with intervals.

    S(f) = 2 dt / K sum |X(f)|^2 over K realisations: segments, tapers (adaptively weighted) and shots,
    windows of unit mean square. Intervals are by chi-square with the degrees of freedom, and by the
    jackknife.

    Parameters
    ----------
    **options
        Those of ``cascade spectrum``: ``along`` as ``"time"``, ``"space"`` or ``"both"`` (then
        ``space_window`` or ``space_multitaper``), ``periodogram``, ``multitaper=(4, 7)``,
        ``equal_weights``, ``no_jackknife``, ``subtract_noise``, ``segment``, ``overlap``, ``window``,
        ``detrend``, ``gaps``, ``significance``, ``threads``, and how the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``spectrum``, ``degrees_of_freedom``, ``low``, ``high``, ``jackknife_low``, ``jackknife_high``
        and of several tapers ``f_statistic`` ``(frequency, position)``, along space
        ``(wavenumber, time)`` beside ``mean_spectrum`` and its interval, along both ``(frequency,
        wavenumber)`` of both signs; NaN where no interval can be stated. Lines that the test finds are
        in the attribute ``line_test``.
    """
    return _made("spectrum", SpectrumOptions, field, options, progress)


class EstimateMethods(FieldMethods):
    """Functions of this module as methods of the accessor of a field."""

    bicoherence = method(bicoherence)
    coherence = method(coherence)
    flux = method(flux)
    increments = method(increments)
    modes = method(modes)
    ridges = method(ridges)
    slope = method(slope)
    spectrum = method(spectrum)
