"""Chains of bodies in contact: simulated, swept, budgeted."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from wavecascade import _native
from wavecascade._arrays.fields import is_path, source
from wavecascade._arrays.results import dataset, frame, held, hold, summary_attrs, warn
from wavecascade._keywords.options import (
    ATTENUATE,
    SWEEP,
    TRANSMIT,
    BudgetOptions,
    FieldOptions,
    LocalizeOptions,
    TriadsOptions,
)
from wavecascade._keywords.words import Progress, observed, one_word, words

Scene = Mapping[str, object] | str | os.PathLike[str] | None

_KEYS = frozenset(_native.scene_keys())


def _toml(value: Any) -> str:
    """A value of a scene as TOML."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, str):
        return json.dumps(value)
    if (isinstance(value, (Sequence, np.ndarray)) and np.ndim(value) != 0) or isinstance(value, list):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return one_word(value)


def _scene(scene: Scene) -> tuple[str | None, list[str]]:
    """A scene as its text, or as words that name its file."""
    if scene is None:
        return None, []
    if not isinstance(scene, Mapping):
        return None, [os.fspath(scene)]
    unknown = [key for key in scene if key not in _KEYS]
    if unknown:
        raise TypeError(f"scene: {unknown[0]!r} is no key of scenes")
    lines = [f"{key} = {_toml(value)}" for key, value in scene.items() if value is not None]
    return "\n".join(lines), []


def _merged(scene: Scene, keys: dict[str, Any], own: frozenset[str]) -> tuple[Scene, dict[str, Any]]:
    """Keys of scenes among keywords go to a scene that is no file."""
    if is_path(scene):
        return scene, keys
    of_scene = {key: value for key, value in keys.items() if key in _KEYS and key not in own}
    rest = {key: value for key, value in keys.items() if key not in of_scene}
    base = dict(scene) if isinstance(scene, Mapping) else {}
    return {**base, **of_scene}, rest


def simulate(scene: Scene = None, *, progress: Progress = None, **keys: Any) -> Any:
    """Integrate a chain of bodies in nearest-neighbour contact to a stated tolerance.

    m_j a_j = F(d_{j-1,j}) - F(d_{j,j+1}), with the contact law F = c d^p for overlaps d > 0.

    Parameters
    ----------
    scene
        Keys of a scene as a dictionary, or the path of a scene file.
    progress
        As for :func:`analyze`.
    **keys
        Keys of the scene, over those of ``scene``: ``sites=40, stiffness_ratio=4.9``. ``cascade
        scene`` prints all.

    Returns
    -------
    xarray.Dataset or dict
        The arrays of a run file: ``velocity``, ``displacement``, ``force``, ``energy_passed`` and
        others over ``time`` and ``position`` or ``contact_position``. The scene and the report of
        the run are attributes; :func:`budget` takes it as it is.

    Raises
    ------
    ValueError
        For keys that are invalid or contradict each other.
    """
    scene, rest = _merged(scene, keys, frozenset())
    text, file = _scene(scene)
    said = words("simulate", rest, (), file, _KEYS)
    found = _native.simulate(text, said, observed(progress))
    warn(found, stacklevel=3)
    out = dataset(found, {})
    hold(out, "run", found["run"])
    return out


def _handle(run: Any) -> Any:
    """The run of :func:`simulate` behind its arrays, if they are one's."""
    return held(run, "run", "run")


def budget(
    run: Any, scene: Scene = None, *, progress: Progress = None, **options: Unpack[BudgetOptions]
) -> Any:
    """Energy budgets of a chain: in real space, over wavenumbers, by frequency, over scales.

    Parameters
    ----------
    run
        What :func:`simulate` returned in this process, or the path of a run file; with ``scene``, a
        measured field of velocities as for :func:`analyze`.
    scene
        The chain that a measured field is a record of.
    progress
        As for :func:`analyze`.
    **options
        The options of ``cascade budget``: ``only``, ``filter``, ``scales``, ``band_edge_frequency``,
        and for a measured field ``start``, ``noise``, ``gain_error``, and how it is read.

    Returns
    -------
    xarray.Dataset or dict
        The arrays of ``budget.npz``; by how much each budget fails to close is an attribute.

    Raises
    ------
    ValueError
        For options that do not fit, or a dataset that is no run.
    """
    typed: dict[str, Any] = dict(options)
    text, file = _scene(scene)
    handle = _handle(run)
    moved: Any
    if handle is not None and scene is None:
        moved, name = handle, "run"
    elif scene is None and not is_path(run):
        raise ValueError(
            "run: expected what `simulate` returned in this process, the path of a run file, or a "
            f"field beside `scene`, found {type(run).__name__}"
        )
    else:
        moved = source(run, typed)
        name = os.fspath(moved[0]) if isinstance(moved, list) else "field"
    typed |= {"scene": file[0] if file else "scene" if text is not None else None}
    allowed = frozenset(BudgetOptions.__annotations__) | frozenset(FieldOptions.__annotations__)
    said = words("budget", typed, allowed | {"scene"}, [name])
    found = _native.budget(moved, text, said, observed(progress))
    warn(found, stacklevel=3)
    return dataset(found, summary_attrs(found["summary"], ("closure", "measurement", "units")))


def triads(run: Any, *, progress: Progress = None, **options: Unpack[TriadsOptions]) -> Any:
    """Which wavenumbers feed which: transfers by triads k = p + q, where the law is quadratic.

    T(k|p,q) = N b / 3 Re[r_k* d(r_p r_q)/dt - 2 dr_k*/dt r_p r_q] of a chain with the force a r + b r^2,
    over a window of time.

    Parameters
    ----------
    run
        What :func:`simulate` returned, or the path of a run file.
    progress
        As for :func:`analyze`.
    **options
        Those of ``cascade triads``: ``window_samples=(first, end)``, ``memory``, ``threads``.

    Returns
    -------
    xarray.Dataset or dict
        ``transfer`` and on a lattice ``umklapp`` ``(wavenumber, partner)``; ``gained``, ``change``,
        ``flux`` ``(wavenumber)``; ``flux_of_group`` ``(group, wavenumber)``. What the triads say is in
        attributes.

    Raises
    ------
    ValueError
        For a law without a quadratic term, options that do not fit, or a dataset that is no run.
    OSError
        For a file that cannot be read.
    """
    typed: dict[str, Any] = dict(options)
    handle = _handle(run)
    moved: Any = source(run, typed) if handle is None else handle
    name = os.fspath(moved[0]) if isinstance(moved, list) else "run" if handle is not None else "field"
    allowed = frozenset(TriadsOptions.__annotations__) | frozenset(FieldOptions.__annotations__)
    found = _native.triads(moved, words("triads", typed, allowed, [name]), observed(progress))
    warn(found, stacklevel=3)
    return dataset(found, summary_attrs(found["summary"], without={name for name, *_ in found["arrays"]}))


def _number(text: str) -> Any:
    """A cell as a number, if it is one; nothing is not known."""
    if text == "":
        return np.nan
    try:
        return float(text)
    except ValueError:
        return text


def sweep(
    scene: Scene = None,
    *,
    vary: Mapping[str, object] | str | Sequence[str],
    progress: Progress = None,
    **keys: Any,
) -> Any:
    """Simulate all combinations of parameter values in parallel, to one table.

    Parameters
    ----------
    scene
        As for :func:`simulate`.
    vary
        Values of keys: ``{"stiffness_ratio": [1, 2, 4.9]}``, or as for the program,
        ``"stiffness_ratio=1:120:400log"``. The last key is the fastest.
    progress
        As for :func:`analyze`.
    **keys
        Keys of the scene; ``threads``; ``out``, a directory in which finished members are kept, so
        that an interrupted sweep resumes there, and ``part="2/4"`` of it.

    Returns
    -------
    pandas.DataFrame or dict
        A row for each member: the keys and the columns of ``table.csv``. ``failure`` says why a
        member has no result.

    Raises
    ------
    ValueError
        For keys or values that are invalid.
    """
    scene, rest = _merged(scene, keys, SWEEP)
    text, file = _scene(scene)
    said = words("sweep", {**rest, "vary": vary}, SWEEP, file, _KEYS)
    read = json.loads(_native.sweep(text, said, observed(progress)))
    columns: dict[str, Any] = {}
    for i, key in enumerate(read["keys"]):
        columns[key] = [_number(values[i]) for values, _, _ in read["rows"]]
    for name in read["columns"]:
        cells = [measures.get(name) for _, measures, _ in read["rows"]]
        columns[name] = [np.nan if cell is None else cell for cell in cells]
    columns["failure"] = [failure or "" for _, _, failure in read["rows"]]
    return frame({name: np.asarray(cells) for name, cells in columns.items()}, {"scene": read["scene"]})


def _table(text: str) -> dict[str, Any]:
    """The columns of a table in CSV."""
    rows = list(csv.reader(io.StringIO(text)))
    header, cells = rows[0], rows[1:]
    return {name: np.asarray([_number(row[i]) for row in cells]) for i, name in enumerate(header)}


def localize(*, progress: Progress = None, **options: Unpack[LocalizeOptions]) -> Any:
    """The ratios at which a dimer carries a localized wave that sheds no energy, and the wave.

    Parameters
    ----------
    progress
        As for :func:`analyze`.
    **options
        The options of ``cascade localize``: ``order=range(1, 9)`` or ``"1..8"``, ``alternation``,
        ``exponent``, ``direct=True``; ``profile=2`` for the wave of that order, ``launch=2`` for its
        travel along a chain.

    Returns
    -------
    pandas.DataFrame, or xarray.Dataset for one wave
        The table of orders, or the arrays of ``wave.npz`` or ``launch.npz``.

    Raises
    ------
    ValueError
        For options that do not fit, and a wave that is not found.
    """
    said = words("localize", dict(options), frozenset(LocalizeOptions.__annotations__))
    found = _native.localize(said, observed(progress))
    summary = found["summary"]
    if found["csv"] is not None:
        return frame(_table(found["csv"]), {"summary": summary})
    return dataset(found, {"summary": summary})


def attenuate(
    scenes: Scene | Sequence[str | os.PathLike[str]] = None,
    *,
    progress: Progress = None,
    **keys: Any,
) -> Any:
    """Follow the pulse of a struck chain against its length, and fit a law of attenuation.

    Parameters
    ----------
    scenes
        Paths of scene files to compare, or keys of one scene.
    progress
        As for :func:`analyze`.
    **keys
        The options of ``cascade attenuate``: ``angles``, ``ratios=[4.9]``, ``bodies``, ``sense``,
        ``target``, ``best_at``, ``measured`` (the path of a measured curve, or with
        ``measured_field=True`` of a field of velocities), and keys of scenes.

    Returns
    -------
    pandas.DataFrame or dict
        The columns of ``curves.csv``; ``attenuation.json`` is the attribute ``summary``.

    Raises
    ------
    ValueError
        For options or keys that do not fit.
    """
    files: list[str] = []
    if isinstance(scenes, Mapping):
        keys = {**scenes, **keys}
    elif isinstance(scenes, (str, os.PathLike)):
        files = [os.fspath(scenes)]
    elif scenes is not None:
        files = [os.fspath(one) for one in scenes]
    said = words("attenuate", {**keys, "quiet": True}, ATTENUATE | {"quiet"}, files, _KEYS)
    text, summary = _native.attenuate(said, observed(progress))
    return frame(_table(text), {"summary": summary})


def transmit(scene: Scene = None, *, progress: Progress = None, **keys: Any) -> Any:
    """Follow the pulse to the wall behind a chain against a key of its scene.

    Parameters
    ----------
    scene
        As for :func:`simulate`.
    progress
        As for :func:`analyze`.
    **keys
        The options of ``cascade transmit``: ``over="stiffness_ratio=1:100:45log"``, ``vary``,
        ``no_extremes=True``, ``measured`` (the path of a measured curve, or ``"VALUE=FIELD"``), and
        keys of scenes.

    Returns
    -------
    pandas.DataFrame or dict
        The columns of ``curves.csv``; ``transmission.json`` is the attribute ``summary``.

    Raises
    ------
    ValueError
        For options or keys that do not fit.
    """
    scene, rest = _merged(scene, keys, TRANSMIT)
    text, file = _scene(scene)
    said = words("transmit", {**rest, "quiet": True}, TRANSMIT | {"quiet"}, file, _KEYS)
    table, summary = _native.transmit(text, said, observed(progress))
    return frame(_table(table), {"summary": summary})
