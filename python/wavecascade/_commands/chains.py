"""Chains of bodies in contact: simulated, swept, budgeted."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from wavecascade import _native
from wavecascade._arrays.fields import is_path, source
from wavecascade._arrays.results import dataset, frame, hold, summary_attrs, warn
from wavecascade._arrays.runs import run_of, seal
from wavecascade._commands.documented import documented
from wavecascade._keywords.advice import advising
from wavecascade._keywords.options import (
    BudgetOptions,
    CompareOptions,
    DesignOptions,
    FieldOptions,
    FitOptions,
    LocalizeOptions,
    PlanOptions,
    TriadsOptions,
)
from wavecascade._keywords.scene import (
    AttenuateOptions,
    AttenuateOwn,
    SceneKeys,
    SweepOptions,
    SweepOwn,
)
from wavecascade._keywords.words import Progress, measured, observed, one_word, words

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Scene = Mapping[str, object] | str | os.PathLike[str] | None

_KEYS = frozenset(_native.scene_keys())
_SWEEP = frozenset(SweepOwn.__annotations__) | {"vary"}
_ATTENUATE = frozenset(AttenuateOwn.__annotations__)


def _toml(value: Any) -> str:
    """A value of a scene as TOML."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, str) or measured(value):
        return json.dumps(one_word(value))
    if (isinstance(value, (Sequence, np.ndarray)) and np.ndim(value) != 0) or isinstance(value, list):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return one_word(value)


def _scene(scene: Scene) -> tuple[str | None, list[str]]:
    """A scene as its text, or as words that name its file."""
    if scene is None:
        return None, []
    if isinstance(scene, str) and "=" in scene:
        return scene, []
    if is_path(scene):
        return None, [os.fspath(scene)]
    if not isinstance(scene, Mapping):
        raise TypeError(
            "scene: expected keys as a dictionary, a path, or the text of a scene, found "
            f"{type(scene).__name__}"
        )
    unknown = [key for key in scene if key not in _KEYS]
    if unknown:
        raise TypeError(f"scene: {unknown[0]!r} is no key of scenes")
    lines = [f"{key} = {_toml(value)}" for key, value in scene.items() if value is not None]
    return "\n".join(lines), []


def _merged(scene: Scene, keys: dict[str, Any], own: frozenset[str]) -> tuple[Scene, dict[str, Any]]:
    """Keys of scenes among keywords go to a scene that is no file."""
    if scene is not None and not isinstance(scene, Mapping):
        return scene, keys
    of_scene = {key: value for key, value in keys.items() if key in _KEYS and key not in own}
    rest = {key: value for key, value in keys.items() if key not in of_scene}
    base = dict(scene) if isinstance(scene, Mapping) else {}
    return {**base, **of_scene}, rest


@documented
def simulate(
    scene: Scene = None,
    *,
    gradient: Sequence[str] = (),
    lyapunov: bool = False,
    progress: Progress = None,
    **keys: Unpack[SceneKeys],
) -> xr.Dataset:
    """Integrate a chain of bodies in nearest-neighbour contact to a stated tolerance.

    m_j a_j = F(d_{j-1,j}) - F(d_{j,j+1}), with the contact law F = c d^1.5 for overlaps d > 0, or any
    other: ``law="d - 0.2*d^3"``, ``laws=[...]`` along the chain, :func:`law` of a function.

    Parameters
    ----------
    scene
        Keys of a scene as a dictionary, or the path of a scene file.
    gradient
        Keys with respect to which derivatives of the run are returned: ``["young", "mass_cell[1]"]``.
    lyapunov
        Whether the report holds the largest Lyapunov exponent, with its convergence.
    **keys
        Keys of the scene, over those of ``scene``: ``sites=40, stiffness_ratio=4.9``. ``cascade
        scene`` prints all.

    Returns
    -------
    xarray.Dataset or dict
        The arrays of a run file: ``velocity``, ``displacement`` and, with losses, ``energy_lost``
        ``(time, position)``; ``force`` and ``energy_passed`` ``(time, contact_position)``; with a
        drive ``energy_input`` ``(time)``; with resonators ``resonator_displacement`` and
        ``resonator_velocity`` ``(time, position)``; ``mass`` ``(position)``, ``contact_coefficient``
        ``(contact_position)``; with a gradient ``gradient_velocity``, ``gradient_displacement``
        ``(parameter, time, position)``, per unit of each key, and ``gradient_error`` ``(parameter)``,
        over the largest derivative. The scene and the report of the run are attributes. :func:`budget`,
        :func:`compare` and :func:`triads` take it as it is, also from a file of ``to_netcdf``.
    """
    scene, rest = _merged(scene, dict(keys), frozenset())
    text, file = _scene(scene)
    rest |= {"gradient": list(gradient) or None, "lyapunov": lyapunov or None}
    said = words("simulate", rest, ("gradient", "lyapunov"), file, _KEYS)
    found = _native.simulate(text, said, observed(progress))
    warn(found)
    run = dataset(found, {})
    if gradient and not isinstance(run, dict):
        run = run.assign_coords(parameter=list(gradient))
    return seal(run)


@documented
def budget(
    run: Any, scene: Scene = None, *, progress: Progress = None, **options: Unpack[BudgetOptions]
) -> xr.Dataset:
    """Energy budgets of a chain: in real space, over wavenumbers, by frequency, over scales.

    Parameters
    ----------
    run
        What :func:`simulate` returned, also from a file of NetCDF or another process, or the path of a
        run file; with ``scene``, a measured field of velocities as for :func:`analyze`.
    scene
        The chain that a measured field is a record of.
    **options
        The options of ``cascade budget``: ``only``, ``filter``, ``scales``, ``band_edge_frequency``,
        and for a measured field ``start``, ``noise``, ``gain_error``, and how it is read.

    Returns
    -------
    xarray.Dataset or dict
        Over ``time``: ``kinetic_energy``, ``contact_energy``, ``lost_energy``, ``input_energy``;
        ``site_energy``, ``energy_lost`` ``(time, position)``; ``energy_flux``, ``energy_passed``
        ``(time, contact_position)``; ``left_behind`` ``(contact_position)``. Over ``wavenumber``:
        ``energy_spectrum``, ``transfer``, ``loss_spectrum``, ``input_spectrum``, ``spectral_flux``,
        ``integrated_spectral_flux`` ``(time, wavenumber)``; ``low_wavenumber_energy``,
        ``band_edge_flux``, ``wavenumber_centroid`` ``(time)``; of dimers ``acoustic_spectrum``,
        ``optical_spectrum`` over ``cell_wavenumber``, ``optical_energy``, ``optical_transfer``. Over
        ``frequency``: ``power_flow``, ``cumulative_power_flow`` ``(frequency, contact_position)``,
        ``low_frequency_passed``, ``high_frequency_passed``. Over ``scale``: ``scale_flux``,
        ``scale_flux_in_time``, ``integrated_scale_flux``, ``scale_sigma``,
        ``scale_cutoff_wavenumber``. Of a measured field also ``velocity``, ``displacement``,
        ``overlap``, ``force``, and errors of all as ``..._error``. By how much each budget fails to
        close is the attribute ``closure``.
    """
    typed: dict[str, Any] = dict(options)
    text, file = _scene(scene)
    handle = None if scene is not None or is_path(run) else run_of(run)
    moved: Any = None
    if handle is not None:
        name = "run"
    elif scene is None and not is_path(run):
        raise ValueError(
            "run: expected what `simulate` returned, the path of a run file, or a "
            f"field beside `scene`, found {type(run).__name__}"
        )
    else:
        moved = source(run, typed)
        name = os.fspath(moved[0]) if isinstance(moved, list) else "field"
    typed |= {"scene": file[0] if file else "scene" if text is not None else None}
    allowed = frozenset(BudgetOptions.__annotations__) | frozenset(FieldOptions.__annotations__)
    said = words("budget", typed, allowed | {"scene"}, [name])
    with advising(allowed, moved):
        sources = [moved] if handle is None else []
        runs = [] if handle is None else [handle]
        found = _native.found(said, observed(progress), sources, text, runs)
    warn(found)
    out = dataset(found, summary_attrs(found["summary"], ("schema", "closure", "measurement", "units")))
    hold(out, found["page"])
    return out


@documented
def compare(
    first: Any, second: Any, *, progress: Progress = None, **options: Unpack[CompareOptions]
) -> pd.DataFrame | xr.Dataset:
    """The energy budgets of two runs, or a measured field against a run at its places and times.

    Parameters
    ----------
    first
        A run as for :func:`budget`, or a field as for :func:`analyze`.
    second
        A run; beside a field also keys of a scene as a dictionary, or the path of a scene. Of two runs,
        edges and windows that are chosen for the first hold for both.
    **options
        Those of ``cascade compare``; of runs ``only``, ``filter``, ``scales`` and so on; of a field
        ``bodies=[3, 7, 11]``, ``within="5%"``, ``threads``, and how it is read.

    Returns
    -------
    pandas.DataFrame, xarray.Dataset or dict
        Of runs a row for each number that both have, by its path in ``summary.json``: ``first``,
        ``second`` and their ``difference``; the whole is the attribute ``summary``, in JSON. Of a field
        ``measured``, ``run``, ``residual`` ``(time, body)``; ``arrival_measured``, ``arrival_run``,
        ``peak_measured``, ``peak_run`` ``(body)``; ``energy_ratio_low``, ``energy_ratio_high``,
        ``correlation`` ``(band)``; the attribute ``answer`` says where they agree and where they part.
    """
    handle = None if is_path(first) else run_of(first)
    if handle is None and not (is_path(first) and _native.is_run_file(os.fspath(first))):
        return _compare_field(first, second, dict(options), progress)
    runs: list[Any] = []
    names = []
    for which, run in (("first", first), ("second", second)):
        handle = None if is_path(run) else run_of(run)
        if handle is None and not is_path(run):
            raise ValueError(
                f"{which}: expected a run, or the path of a run file, found {type(run).__name__}"
            )
        runs.append(handle)
        names.append(os.fspath(run) if handle is None else which)
    said = words("compare", dict(options), frozenset(BudgetOptions.__annotations__), names)
    whole = _native.found(said, observed(progress), runs=runs)
    read = json.loads(whole["summary"])
    found = {side: dict(_leaves(read[side])) for side in ("first", "second", "difference")}
    rows = list(found["difference"])
    columns = {side: np.array([found[side][row] for row in rows]) for side in found}
    return frame({"number": np.array(rows), **columns}, {"summary": whole["summary"]}, whole["page"])


def _made(found: dict[str, Any]) -> xr.Dataset:
    """What the native half found; what the arrays hold is no attribute."""
    warn(found)
    out = dataset(found, summary_attrs(found["summary"], without={name for name, *_ in found["arrays"]}))
    named = {"parameter", "key"}.intersection(getattr(out, "dims", ()))
    for dim in named.difference(getattr(out, "coords", ())):
        keys = json.loads(out.attrs.get("values") or out.attrs["keys"])
        out = out.assign_coords({dim: [key["name"] for key in keys]})
    hold(out, found["page"])
    return out


def _compare_field(field: Any, run: Any, typed: dict[str, Any], progress: Progress) -> xr.Dataset:
    """A measured field against a run, or the chain of a scene."""
    handle = None if is_path(run) else run_of(run)
    own = frozenset(CompareOptions.__annotations__) - frozenset(BudgetOptions.__annotations__)
    text, file = (handle.scene, []) if handle is not None else _scene(run)
    return _of_field("compare", field, (text, file or ["run"]), typed, own | {"threads"}, progress)


def _of_field(
    command: str,
    field: Any,
    scene: tuple[str | None, list[str]],
    typed: dict[str, Any],
    own: frozenset[str],
    progress: Progress,
) -> xr.Dataset:
    """A command on a field and the scene of a chain: its text, or words that name its file."""
    of: Any = source(field, typed)
    name = os.fspath(of[0]) if isinstance(of, list) else "field"
    allowed = own | frozenset(FieldOptions.__annotations__)
    with advising(allowed, of):
        said = words(command, typed, allowed, [name, *scene[1]])
        found = _native.found(said, observed(progress), [of], scene[0])
    return _made(found)


def _leaves(tree: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """Each number of nested objects with its path."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from _leaves(value, f"{path}.{key}" if path else key)
    elif isinstance(tree, (int, float)) and not isinstance(tree, bool):
        yield path, tree


@documented
def triads(run: Any, *, progress: Progress = None, **options: Unpack[TriadsOptions]) -> xr.Dataset:
    """Which wavenumbers feed which: transfers by triads k = p + q, where the law is quadratic.

    T(k|p,q) = N b / 3 Re[r_k* d(r_p r_q)/dt - 2 dr_k*/dt r_p r_q] of a chain with the force a r + b r^2,
    over a window of time.

    Parameters
    ----------
    run
        What :func:`simulate` returned, or the path of a run file.
    **options
        Those of ``cascade triads``: ``window_samples=(first, end)``, ``memory``, ``threads``.

    Returns
    -------
    xarray.Dataset or dict
        ``transfer`` and on a lattice ``umklapp`` ``(wavenumber, partner)``; ``gained``, ``change``,
        ``flux`` ``(wavenumber)``; ``flux_of_group`` ``(group, wavenumber)``. What the triads say is in
        attributes.
    """
    typed: dict[str, Any] = dict(options)
    handle = None if is_path(run) else run_of(run)
    moved: Any = source(run, typed) if handle is None else None
    name = os.fspath(moved[0]) if isinstance(moved, list) else "run"
    allowed = frozenset(TriadsOptions.__annotations__) | frozenset(FieldOptions.__annotations__)
    said = words("triads", typed, allowed, [name])
    sources = [moved] if handle is None else []
    runs = [] if handle is None else [handle]
    found = _native.found(said, observed(progress), sources, runs=runs)
    return _made(found)


@documented
def fit(
    field: Any,
    scene: Scene,
    *,
    free: str | Sequence[str] | Mapping[str, Any],
    progress: Progress = None,
    **options: Unpack[FitOptions],
) -> xr.Dataset:
    """The chain that did what was measured: keys with intervals, and what noise does not explain.

    Least squares of the records less those of a run. Intervals are of ``H^-1 (J^T S J) H^-1`` with
    ``H = J^T J`` and S the covariance of the noise, estimated from what is left.

    Parameters
    ----------
    field
        The records, as for :func:`analyze`.
    scene
        Keys of a scene as a dictionary, or the path of a scene file.
    free
        Keys to fit, as ``"young=50GPa..90GPa"``, a list of them, or ``{"young": (50e9, 90e9)}`` with None
        for keys without bounds.
    **options
        Those of ``cascade fit``: ``bodies=[3, 7, 11]``, ``free_time_shift``, ``free_gains``,
        ``gain_error``, ``starts``, ``seed``, ``threads``, and how the field is read.

    Returns
    -------
    xarray.Dataset or dict
        ``measured``, ``fitted``, ``residual`` ``(time, body)``; ``value``, ``low``, ``high``, ``start``
        ``(parameter)``, ``correlation`` ``(parameter, other)``; ``residual_spectrum`` ``(frequency)``.
        The values with their names are the attribute ``values``; ``misfit``, ``undetermined``, ``answer``
        beside it.
    """
    typed: dict[str, Any] = {**options, "free": _free(free)}
    own = frozenset(FitOptions.__annotations__) | {"free"}
    return _of_field("fit", field, _scene(scene), typed, own, progress)


def _free(free: str | Sequence[str] | Mapping[str, Any]) -> str | Sequence[str]:
    """Free keys as they are typed."""
    if not isinstance(free, Mapping):
        return free
    ends = (
        (key, bounds if bounds is None else [one_word(end) for end in bounds])
        for key, bounds in free.items()
    )
    return [key if bounds is None else f"{key}={'..'.join(bounds)}" for key, bounds in ends]


@documented
def design(
    scene: Scene,
    *,
    free: str | Sequence[str] | Mapping[str, Any],
    progress: Progress = None,
    **options: Unpack[DesignOptions],
) -> xr.Dataset:
    """The chain for which a measure of its run is least or largest.

    Parameters
    ----------
    scene
        Keys of a scene as a dictionary, or the path of a scene file.
    free
        Keys to vary, as ``"angle=2..90"``, ``"radius=5mm|10mm"``, ``"coefficients[]=0.2..5"``, a list
        of them, or ``{"angle": (2, 90)}``.
    **options
        Those of ``cascade design``: ``minimize="peak_force_last"`` or ``maximize``,
        ``at_most="total_mass=0.5"``, ``tolerance="coefficients=10%"``, ``judge``, ``members``,
        ``tries``, ``seed``, ``threads``.

    Returns
    -------
    xarray.Dataset or dict
        ``search`` and ``random``, the best measure after so many tries; ``time_after``,
        ``force_after``, and the same ``before``; ``value_after`` ``(key)``. The values with their names
        are the attribute ``values``, the scene found is ``scene``; ``answer`` beside it.
    """
    return _of_scene("design", scene, free, dict(options), DesignOptions, progress)


@documented
def plan_sensors(
    scene: Scene,
    *,
    free: str | Sequence[str] | Mapping[str, Any],
    sensors: int,
    progress: Progress = None,
    **options: Unpack[PlanOptions],
) -> xr.Dataset:
    """Where, how long and how fast to measure, so that records determine keys of a scene best.

    Fisher information of runs at the values of the scene; errors are halves of 95 % intervals over the
    values, of a fit without bias (Cramer and Rao).

    Parameters
    ----------
    scene
        Keys of a scene as a dictionary, or the path of a scene file.
    free
        Keys to determine, as for :func:`fit`.
    sensors
        Number of bodies, or of forces contacts, that are measured.
    **options
        Those of ``cascade plan``: ``noise="2%"`` or a value, ``quantity``, ``bodies``,
        ``free_time_shift``, ``free_gains``, ``gain_error``, ``rate``, ``criterion``, ``threads``.

    Returns
    -------
    xarray.Dataset or dict
        ``error``, ``error_even``, ``error_all`` ``(key)``; ``error_by_sensors`` ``(sensors, key)``,
        ``error_by_time`` ``(time, key)``, ``error_by_rate`` ``(rate, key)``; ``information``
        ``(body, key)``. The chosen ``bodies``, ``duration``, ``sampling_rate`` and ``keys`` are
        attributes, ``answer`` beside them.
    """
    typed: dict[str, Any] = {**options, "sensors": sensors}
    return _of_scene("plan", scene, free, typed, PlanOptions, progress)


def _of_scene(
    command: str, scene: Scene, free: Any, typed: dict[str, Any], options: type, progress: Progress
) -> xr.Dataset:
    """A command on the free keys of a scene."""
    text, file = _scene(scene)
    typed["free"] = _free(free)
    allowed = frozenset(options.__annotations__) | {"free", "sensors"}
    with advising(allowed, file):
        said = words(command, typed, allowed, file or ["scene.toml"])
        found = _native.found(said, observed(progress), scene=text)
    return _made(found)


def _cell(text: str) -> Any:
    """A number or a truth of a table; nothing is not known."""
    try:
        return json.loads(text) if text else None
    except ValueError:
        return text


def _table(text: str, texts: Collection[str] = ()) -> dict[str, Any]:
    """The columns of a table in CSV, these as texts."""
    header, *rows = csv.reader(io.StringIO(text))
    columns: dict[str, Any] = {}
    for name, cells in zip(header, zip(*rows, strict=True) if rows else [()] * len(header), strict=True):
        values = list(cells if name in texts else map(_cell, cells))
        lacking: Any = "" if any(isinstance(one, str) for one in values) else np.nan
        columns[name] = np.asarray([lacking if one is None else one for one in values])
    return columns


@documented
def sweep(
    scene: Scene = None,
    *,
    vary: Mapping[str, object] | str | Sequence[str] | None = None,
    progress: Progress = None,
    **keys: Unpack[SweepOptions],
) -> pd.DataFrame:
    """Simulate all combinations of parameter values in parallel, to one table.

    Parameters
    ----------
    scene
        As for :func:`simulate`.
    vary
        Values of keys: ``{"stiffness_ratio": [1, 2, 4.9]}``, or as for the program,
        ``"stiffness_ratio=1:120:400log"``. The last key is the fastest.
    **keys
        Keys of the scene; ``members=50``, an ensemble of so many seeds at each combination;
        ``threads``; ``out``, a directory in which finished members are kept, so that an interrupted
        sweep resumes there, and ``part="2/4"`` of it.

    Returns
    -------
    pandas.DataFrame or dict
        A row for each member: the keys and the columns of ``table.csv``. ``failure`` says why a
        member has no result. ``attrs["ensembles"]`` holds, where the seed varies, the spread of each
        column at each combination of the other keys.
    """
    scene, rest = _merged(scene, dict(keys), _SWEEP)
    text, file = _scene(scene)
    said = words("sweep", rest if vary is None else {**rest, "vary": vary}, _SWEEP, file, _KEYS)
    table, ensembles, scene_text, page = _native.sweep(text, said, observed(progress))
    attrs = {"scene": scene_text, "ensembles": json.loads(ensembles)}
    return frame(_table(table, {"failure"}), attrs, page)


@documented
def localize(
    *, progress: Progress = None, **options: Unpack[LocalizeOptions]
) -> pd.DataFrame | xr.Dataset:
    """The ratios at which a dimer carries a localized wave that sheds no energy, and the wave.

    Parameters
    ----------
    **options
        The options of ``cascade localize``: ``order=range(1, 9)`` or ``"1..8"``, ``alternation``,
        ``exponent``, ``direct=True``; ``profile=2`` for the wave of that order, ``launch=2`` for its
        travel along a chain.

    Returns
    -------
    pandas.DataFrame, or xarray.Dataset for one wave
        The table of orders, or the arrays of ``wave.npz`` or ``launch.npz``.
    """
    said = words("localize", dict(options), frozenset(LocalizeOptions.__annotations__))
    found = _native.found(said, observed(progress))
    summary = found["summary"]
    if found["csv"] is not None:
        return frame(_table(found["csv"]), {"summary": summary}, found["page"])
    out = dataset(found, {"summary": summary})
    hold(out, found["page"])
    return out


@documented
def attenuate(
    scenes: Scene | Sequence[str | os.PathLike[str]] = None,
    *,
    progress: Progress = None,
    **keys: Unpack[AttenuateOptions],
) -> pd.DataFrame:
    """Follow the pulse of a struck chain against its length, or to the wall against a key of its scene.

    Parameters
    ----------
    scenes
        Paths of scene files to compare, or keys of one scene.
    **keys
        The options of ``cascade attenuate``: ``angles``, ``ratios=[4.9]``, ``bodies``, ``sense``,
        ``target``; ``against="stiffness_ratio=1:100:45log"`` with ``vary`` and ``no_extremes=True``;
        ``measured`` (the path of a measured curve, of a field of velocities with
        ``measured_field=True``, or ``"VALUE=FIELD"`` against a key), and keys of scenes.

    Returns
    -------
    pandas.DataFrame or dict
        The columns of ``curves.csv``; ``summary.json`` is the attribute ``summary``.
    """
    text = None
    if scenes is None or isinstance(scenes, (str, os.PathLike, Mapping)):
        scene, rest = _merged(scenes, dict(keys), _ATTENUATE)
        text, files = _scene(scene)
    else:
        rest, files = dict(keys), [os.fspath(one) for one in scenes]
    said = words("attenuate", {**rest, "quiet": True}, _ATTENUATE | {"quiet"}, files, _KEYS)
    found = _native.found(said, observed(progress), scene=text or None)
    return frame(_table(found["csv"]), {"summary": found["summary"]}, found["page"])
