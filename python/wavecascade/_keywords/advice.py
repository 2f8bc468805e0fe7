"""What errors advise: only what the function takes."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager

#: Options of files, which arrays do not have.
OF_FILES = ("variable", "header", "time_column", "delays", "read", "position_from")
#: A keyword as texts name it: `gaps=interpolate`, `layout`.
_KEYWORD = re.compile(r"`([a-z][a-z0-9_]*)(?:=[^`]*)?`")


@contextmanager
def advising(allowed: Collection[str], opened: object) -> Iterator[None]:
    """Takes advice out of errors that names an option which the function refuses."""
    taken = set(allowed) if isinstance(opened, list) else set(allowed) - set(OF_FILES)
    try:
        yield
    except Exception as error:
        if hasattr(error, "__notes__"):
            error.__notes__ = [note for note in error.__notes__ if _is_taken(note, taken)]
        if "found a Zarr store" in str(error):
            error.add_note("open it with xarray.open_zarr(path), and give one of its DataArrays")
        raise


def _is_taken(note: str, taken: Collection[str]) -> bool:
    named = _KEYWORD.findall(note)
    return not named or any(name in taken for name in named)
