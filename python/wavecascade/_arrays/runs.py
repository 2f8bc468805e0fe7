"""Runs of chains in memory: datasets, or dictionaries of arrays, that hold a whole run."""

from __future__ import annotations

from typing import Any

import numpy as np

from wavecascade import _native
from wavecascade._arrays.results import checksum

#: Attribute with the checksum of the arrays as `simulate` returned them.
_SUM = "arrays_crc32"


def is_run(data: Any) -> bool:
    """Whether these arrays are those of a run, or a part of them."""
    attrs = data.get("attrs", {}) if isinstance(data, dict) else getattr(data, "attrs", {})
    return str(attrs.get("schema", "")).startswith("cascade.run/") and "scene" in attrs


def seal(data: Any) -> Any:
    """A new run with the checksum of its arrays, which goes to files with it."""
    attrs = data["attrs"] if isinstance(data, dict) else data.attrs
    attrs[_SUM] = f"{checksum(_arrays(data)):08x}"
    return data


def is_whole(data: Any) -> bool:
    """Whether a run has the arrays that it was returned with; in the program's files, their shape."""
    attrs = data["attrs"] if isinstance(data, dict) else data.attrs
    if _SUM in attrs:
        return bool(attrs[_SUM] == f"{checksum(_arrays(data)):08x}")
    velocity = data["velocity"] if "velocity" in data else None
    return velocity is not None and attrs.get("shape") == " x ".join(map(str, velocity.shape))


def run_of(data: Any) -> _native.Run | None:
    """The run of these arrays; ``None`` where they are none.

    Raises
    ------
    ValueError
        For arrays that were changed or cut since.
    """
    if not is_run(data):
        return None
    if not is_whole(data):
        raise ValueError(
            "run: expected the arrays as they were returned, found others: they were changed, cut or "
            "exchanged; simulate anew, or take the file"
        )
    attrs = data["attrs"] if isinstance(data, dict) else data.attrs
    texts = {str(name): value for name, value in attrs.items() if isinstance(value, str)}
    numbers = {name: np.ascontiguousarray(one, np.float64) for name, one in _arrays(data).items()}
    return _native.Run(numbers, texts)


def _arrays(data: Any) -> dict[str, Any]:
    variables = data if isinstance(data, dict) else data.variables
    named = {str(name): np.asarray(getattr(one, "values", one)) for name, one in variables.items()}
    return {name: one for name, one in named.items() if one.dtype.kind in "fiu" and one.ndim > 0}
