"""Keywords of the functions: the options of the program, with ``_`` for ``-``."""

from __future__ import annotations

import datetime
import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol, TypedDict

import numpy as np


class Quantity(Protocol):
    """A number with a unit, as of pint."""

    @property
    def magnitude(self) -> Any: ...
    @property
    def units(self) -> Any: ...


#: A number, in the unit that its place implies, or with its own: ``"10 us"``, of pint, or a duration.
Measure = float | str | Quantity | np.timedelta64 | datetime.timedelta
Range = str | slice | tuple[Measure | None, Measure | None] | Sequence[Measure | None]
#: A name, ``("kaiser", 8)``, or the samples of one segment.
Window = str | tuple[str, float] | Sequence[float] | np.ndarray[Any, Any]
Sites = str | slice | tuple[int, int] | Sequence[int]
StrPath = str | os.PathLike[str]
Gaps = Literal["refuse", "interpolate", "mask", "leave-out"]


class FieldOptions(TypedDict, total=False):
    """How a field is read; what is stated here overrides the array, the sidecar and the file."""

    layout: Literal["time-site", "site-time"]
    dt: Measure
    rate: Measure
    fs: Measure
    dx: Measure
    t0: Measure
    x0: Measure
    time_unit: str
    space_unit: str
    unit: str
    quantity: Literal["velocity", "displacement", "acceleration", "strain-rate", "force"]
    variable: str
    time_dim: str
    space_dim: str
    at: Mapping[str, object] | str | Sequence[str]
    select: Mapping[str, object] | str | Sequence[str]
    jitter: float | str
    resample: str
    delays: Literal["refuse", "align", "ignore"]
    header: Literal["detect", "present", "absent"]
    time_column: int | str
    read: Literal["map", "copy"]
    memory: int | str


class OpenOptions(FieldOptions, total=False):
    """The same for several files with one record each."""

    position_from: StrPath
    channel: str | int
    reference: str
    least_correlation: float
    equal_positions: Literal["refuse", "average"]


class AnalyzeOptions(OpenOptions, total=False):
    """The options of ``cascade analyze``."""

    sites: Sites
    times: Range
    until_arrival: bool
    arrival_threshold: float
    without_sites: int | Sequence[int]
    gaps: Gaps
    detrend_field: Literal["none", "mean"]
    detrend_space: Literal["none", "mean", "linear"]
    detrend_time: Literal["none", "mean", "linear"]
    window_time: Window
    window_space: Window
    scaling: Literal["energy", "density", "spectrum"]
    segment: int
    overlap: int | float | str
    pad_time: int
    pad_space: int
    reference_site: int
    reference_time: Measure
    band_edge_frequency: Measure
    band_edge_wavenumber: Measure
    front_window: Measure
    least_move: float
    periodic: bool
    noise: float
    subtract_noise: bool
    direction_band: Range
    short_time_sites: int | Sequence[int]
    short_time_times: float | Sequence[float]
    short_time_segment: int
    short_time_hop: int
    short_space_segment: int
    short_space_hop: int
    short_time_window: Window
    dispersion: str | Sequence[str]
    dispersion_constants: str
    only: str | Sequence[str]
    precision: Literal["f64", "f32"]
    threads: int
    show_frequency: Range | float
    show_wavenumber: Range | float
    show_time: Range | float
    show_space: Range | float


class FilterOptions(FieldOptions, total=False):
    """The options of ``cascade filter``."""

    frequency: Range
    wavenumber: Range
    speed: Range
    towards: Literal["plus-x", "minus-x", "nowhere"]
    pad: bool
    threads: int


class EstimateOptions(FieldOptions, total=False):
    """Options of all estimates."""

    significance: float
    threads: int


class ShotOptions(EstimateOptions, total=False):
    """Of estimates of repeated records."""

    shot_dim: str


class SegmentOptions(ShotOptions, total=False):
    """How a record gives several realisations."""

    segment: int
    overlap: int | float | str
    detrend: Literal["none", "mean", "linear"]
    gaps: Gaps


class TripleOptions(SegmentOptions, total=False):
    """The same under one window."""

    window: Window


class AverageOptions(TripleOptions, total=False):
    """The same under one window or several tapers."""

    multitaper: str | tuple[float, int]


class DividedOptions(AverageOptions, total=False):
    """Those of the estimates that are summed in parts."""

    equal_weights: bool


class PartialOptions(DividedOptions, total=False):
    """The same, with a reference by its index."""

    reference: int


class BudgetOptions(FieldOptions, total=False):
    """The options of ``cascade budget``."""

    only: str | Sequence[str]
    modes: bool
    from_samples: bool
    filter: Literal["gaussian", "box", "sharp"]
    scales: float | Sequence[float]
    map_scale: float
    band_edge_frequency: Measure
    band_edge_wavenumber: Measure
    between: str | Sequence[str]
    window_samples: Sites
    window_sites: Sites
    threads: int
    start: int
    missing: int | Sequence[int]
    noise: float
    offset: float
    gain_error: float | str | Sequence[float]
    coefficient_error: float | str | Sequence[float]
    mass_error: float | str | Sequence[float]
    repetitions: int
    drift: Literal["none", "constant", "linear"]


class CompareOptions(BudgetOptions, total=False):
    """The options of ``cascade compare``."""

    bodies: int | Sequence[int]
    within: float | str


class TriadsOptions(TypedDict, total=False):
    """The options of ``cascade triads``."""

    window_samples: Sites
    memory: int | str
    threads: int


class FitOptions(FieldOptions, total=False):
    """The options of ``cascade fit``."""

    bodies: int | Sequence[int]
    free_time_shift: bool
    free_gains: bool
    gain_error: float | str
    starts: int
    seed: int
    resume: str
    threads: int


class PlanOptions(TypedDict, total=False):
    """The options of ``cascade plan``."""

    noise: float | str
    quantity: Literal["velocity", "displacement", "acceleration", "force"]
    bodies: int | Sequence[int]
    free_time_shift: bool
    free_gains: bool
    gain_error: float | str
    rate: float | str
    criterion: Literal["volume", "worst"]
    threads: int


class DesignOptions(TypedDict, total=False):
    """The options of ``cascade design``."""

    minimize: str
    maximize: str
    at_most: str | Sequence[str]
    tolerance: str | Sequence[str]
    judge: Literal["worst", "mean"]
    members: int
    tries: int
    seed: int
    threads: int


class LocalizeOptions(TypedDict, total=False):
    """The options of ``cascade localize``."""

    order: int | str | range
    alternation: Literal["stiffness", "mass"]
    exponent: float
    direct: bool
    angles: bool
    ellipse: Literal["approximate", "exact"]
    material: str
    young: float | str
    poisson: float
    radius: float | str
    profile: int
    launch: int
    cells: int
    threads: int
