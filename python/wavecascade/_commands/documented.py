"""Docstrings of functions: what all of them say is written here."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

_PARAMETERS = "\n\nParameters\n----------\n"
_FIELD = "field\n    As for :func:`bicoherence`.\n"
_PROGRESS = "progress\n    As for :func:`analyze`.\n"
_RAISES = """

Raises
------
ValueError
    For options, keys or samples that do not fit.
OSError
    For a file that cannot be read."""


def documented(function: F) -> F:
    """Adds to a docstring what it leaves out: ``field``, ``progress`` and the errors."""
    text = inspect.getdoc(function)
    # There is none under `python -OO`.
    if text is not None:
        summary, sections = text.split(_PARAMETERS)
        names = inspect.signature(function).parameters
        if "field" in names and not sections.startswith("field"):
            sections = _FIELD + sections
        if "progress" in names and not re.search(r"^progress$", sections, re.MULTILINE):
            sections = re.sub(r"^(?=\*\*)", _PROGRESS, sections, count=1, flags=re.MULTILINE)
        function.__doc__ = summary + _PARAMETERS + sections + _RAISES
    return function
