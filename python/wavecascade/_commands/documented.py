"""Docstrings of functions of fields: what all of them say is written here."""

from __future__ import annotations

import inspect
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
    For options or samples that do not fit.
OSError
    For a file that cannot be read."""


def documented(function: F) -> F:
    """Adds the errors to a docstring, and the parameters ``field`` and ``progress`` where it has none."""
    text = inspect.getdoc(function)
    # There is none under `python -OO`.
    if text is not None:
        summary, sections = text.split(_PARAMETERS)
        if not sections.startswith("field\n"):
            sections = _FIELD + sections
        if "\nprogress\n" not in sections:
            sections = sections.replace("\n**options\n", f"\n{_PROGRESS}**options\n")
        function.__doc__ = summary + _PARAMETERS + sections + _RAISES
    return function
