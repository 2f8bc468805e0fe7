"""Keys of scenes, as keywords."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict

from wavecascade._keywords.options import Measure


class SceneKeys(TypedDict, total=False):
    """What a chain is, how it starts, and what is kept of it; ``cascade scene`` explains each."""

    sites: int
    ends: Literal["wall", "free", "fixed", "periodic"]
    law: str
    laws: Sequence[str]
    law_file: str | os.PathLike[str]
    exponent: float
    alpha: float
    beta: float
    steepness: float
    precompression: Measure
    gravity: float
    ground_cell: float | Sequence[float]
    ground_law: str
    resonator_mass: float | Sequence[float]
    resonator_frequency: float | Sequence[float]
    resonator_stiffness: float | Sequence[float]
    resonator_damping: float | Sequence[float]
    stiffness_ratio: float
    first_contact: Literal["soft", "stiff"]
    coefficient_cell: float | Sequence[float]
    coefficients: Sequence[float]
    coefficient_taper: float
    coefficient_spread: float
    striker_coefficient: float
    wall_coefficient: float
    left_wall_coefficient: float
    mass_ratio: float
    mass_cell: float | Sequence[float]
    masses: Sequence[float]
    mass_taper: float
    mass_spread: float
    striker_mass: Measure
    seed: int
    defect: Sequence[Mapping[str, object]]
    units: Literal["none", "si"]
    material: Literal["quartz", "steel", "ptfe"]
    young: Measure
    poisson: float
    density: Measure
    shape: Literal["sphere", "cylinder"]
    radius: Measure
    length: Measure
    angle: Measure
    second_angle: Measure
    angle_cell: float | Sequence[float]
    ellipse: Literal["exact", "approximate"]
    striker_radius: Measure
    striker_material: Literal["quartz", "steel", "ptfe"]
    wall_radius: Measure
    wall_material: Literal["quartz", "steel", "ptfe"]
    striker_velocity: Measure
    striker_velocity_spread: float
    velocities: Sequence[float]
    displacements: Sequence[float]
    resonator_displacements: Sequence[float]
    resonator_velocities: Sequence[float]
    state: str
    mode: int
    modes: Sequence[int]
    mode_energy: float
    mode_amplitude: Measure
    drive: Literal["force", "wall", "wall-velocity", "displacement", "velocity"]
    drive_site: int
    drive_waveform: Literal["sine", "half-sine", "tone-burst", "chirp", "noise", "values"]
    drive_amplitude: float
    drive_frequency: Measure
    drive_end_frequency: Measure
    drive_cycles: float
    drive_band: Sequence[float]
    drive_seed: int
    drive_duration: Measure
    drive_file: str
    drive_times: Sequence[float]
    drive_values: Sequence[float]
    dashpot: float
    tangent: Measure
    drag: float
    tolerance: float
    scheme: Literal["nystrom", "runge-kutta", "velocity-verlet", "symplectic-4", "symplectic-6"]
    step: Measure
    estimate_error: bool
    end_time: Measure
    samples: int
    record: Sequence[Literal["displacement", "force", "energy_passed"]]
    memory: Measure


class SweepOwn(TypedDict, total=False):
    """What a sweep takes beside the keys of scenes."""

    members: int
    out: str | os.PathLike[str]
    part: str
    threads: int


class SweepOptions(SceneKeys, SweepOwn, total=False):
    """The options of ``cascade sweep``."""


class AttenuateOwn(TypedDict, total=False):
    """What attenuation takes beside them."""

    against: str
    angles: str | Sequence[str]
    ratios: float | str | Sequence[float]
    bodies: int
    sense: Literal["chain", "wall", "both"]
    lengths: int | str | Sequence[int]
    contacts: Literal["soft", "stiff"]
    fit: Literal["aicc", "cross-validation"]
    target: float
    vary: Mapping[str, object] | str | Sequence[str]
    no_extremes: bool
    measured: str | os.PathLike[str]
    measured_field: bool
    band_edge_frequency: float
    out: str | os.PathLike[str]
    threads: int


class AttenuateOptions(SceneKeys, AttenuateOwn, total=False):
    """The options of ``cascade attenuate``."""
