"""The sites of a field that a task takes, and errors that name them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

#: How an error says that samples are not finite, and where it found something.
_NOT_FINITE = ": expected finite samples, found "
_PLACE = re.compile(r"(?<=time row )(\d+), site (\d+)")


@dataclass(frozen=True)
class Reference:
    """A record that others are compared with, and its site, if it is of one."""

    record: Any
    site: int | None


@dataclass(frozen=True)
class Columns:
    """What the columns of a block are: sites of a field, perhaps behind a reference."""

    sites: Sequence[int]
    is_compared: bool
    #: The site of the reference.
    reference: int | None

    @classmethod
    def of(cls, sites: Sequence[int], reference: Reference | None) -> Columns:
        """Of these sites behind this reference."""
        return cls(sites, reference is not None, None if reference is None else reference.site)

    def explained(self, message: str, block: npt.NDArray[Any], first: int) -> str:
        """An error of a block whose first sample is ``first``, with the sites of the field."""
        if _NOT_FINITE in message:
            return self._not_finite(message, ~np.isfinite(block), first)
        return _PLACE.sub(lambda found: f"{found[1]}, {self._name(int(found[2]))}", message)

    def _name(self, column: int) -> str:
        if not self.is_compared:
            return f"site {self.sites[column]}"
        if column > 0:
            return f"site {self.sites[column - 1]}"
        return "the reference" if self.reference is None else f"site {self.reference}"

    def _not_finite(self, message: str, bad: npt.NDArray[np.bool_], first: int) -> str:
        """The same words for what is not finite in the field; a site counts once."""
        name = message.split(_NOT_FINITE)[0]
        sites = list(self.sites)
        if self.is_compared and self.reference is None and bad[:, 0].any():
            times = np.flatnonzero(bad[:, 0])
            return (
                f"reference{_NOT_FINITE}{len(times)} that are not (NaN or infinite), "
                f"the first at time row {first + times[0]}"
            )
        if self.is_compared and self.reference is not None and self.reference not in sites:
            sites = [self.reference, *sites]
        elif self.is_compared:
            bad = bad[:, 1:]
        if not bad.any():
            return message
        time = int(bad.any(axis=1).argmax())
        site = min(sites[column] for column in np.flatnonzero(bad[time]))
        affected = bad.any(axis=0).sum()
        return (
            f"{name}{_NOT_FINITE}{bad.sum()} that are not (NaN or infinite), the first at time row "
            f"{first + time}, site {site}; {affected} of {len(sites)} sites of this task are affected"
        )
