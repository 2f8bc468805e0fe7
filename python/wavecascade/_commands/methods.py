"""Functions on fields as methods of their accessor."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


class FieldMethods:
    """A field, the first argument of its methods."""

    _field: Any


def method(function: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[FieldMethods, P], R]:
    """A function on fields as a method, with its keywords."""

    @functools.wraps(function)
    def of_field(self: FieldMethods, /, *others: P.args, **options: P.kwargs) -> R:
        return function(self._field, *others, **options)

    return of_field
