"""Where the energy of a wave goes: the spectral cascade of a velocity field v(t, x).

Functions on arrays of NumPy, xarray and Dask with the results of the program ``cascade``, to the bit::

    import wavecascade as wc

    spectra = wc.analyze(velocity, dt="10 us", dx="2 mm")
    spectra.spacetime_spectrum.plot()
"""

from importlib.util import find_spec as _find_spec

from wavecascade import distributed, fft
from wavecascade._commands import estimates as _estimates
from wavecascade._commands.analysis import (
    analyze,
    filter,
    inspect,
    open,
    plan,
    report,
    spatial_spectrum,
    temporal_spectrum,
)
from wavecascade._commands.chains import (
    attenuate,
    budget,
    compare,
    design,
    fit,
    localize,
    plan_sensors,
    simulate,
    sweep,
    triads,
)
from wavecascade._commands.estimates import *  # noqa: F403
from wavecascade._commands.laws import law
from wavecascade._commands.parts import combine, partial
from wavecascade._keywords.words import CascadeWarning
from wavecascade._native import Partial
from wavecascade._native import version as __version__

__all__ = [
    "CascadeWarning",
    "Partial",
    "__version__",
    "analyze",
    "attenuate",
    "budget",
    "combine",
    "compare",
    "design",
    "distributed",
    "fft",
    "filter",
    "fit",
    "inspect",
    "law",
    "localize",
    "open",
    "partial",
    "plan",
    "plan_sensors",
    "report",
    "simulate",
    "spatial_spectrum",
    "sweep",
    "temporal_spectrum",
    "triads",
]
__all__ += _estimates.__all__

if _find_spec("xarray") is not None:
    from wavecascade._accessor import FieldAccessor as FieldAccessor
    from wavecascade._accessor import ResultAccessor as ResultAccessor
