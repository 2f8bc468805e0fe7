"""Averages in parts: sums over blocks of a record, and the result of all of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, Unpack

from wavecascade import _native
from wavecascade._arrays.fields import shots
from wavecascade._arrays.results import warn
from wavecascade._commands.estimates import CoherenceOptions, SpectrumOptions, arranged, opened
from wavecascade._keywords.options import FieldOptions, PartialOptions
from wavecascade._keywords.words import Progress, observed, words

if TYPE_CHECKING:
    import xarray as xr

Divided = Literal["spectrum", "coherence"]

_OPTIONS: dict[str, Any] = {
    "spectrum": SpectrumOptions,
    "coherence": CoherenceOptions,
}


def words_of(estimate: str, options: Mapping[str, object], names: Iterable[str]) -> list[str]:
    """The words of the command of an estimate that is summed in parts."""
    if estimate not in _OPTIONS:
        raise ValueError(f"estimate: expected spectrum or coherence, found {estimate!r}")
    allowed = frozenset(_OPTIONS[estimate].__annotations__) | frozenset(FieldOptions.__annotations__)
    return words(estimate, options, allowed | {"part"}, names)


def partial(
    field: Any,
    estimate: Divided = "spectrum",
    *,
    part: str | tuple[int, int] | None = None,
    first: int | None = None,
    times: int | None = None,
    progress: Progress = None,
    **options: Unpack[PartialOptions],
) -> _native.Partial:
    """Sums over some of the segments of a record, for :func:`combine`.

    A partial is the state of the averages: sums over its segments, in their order. What the whole is
    does not depend on how it was divided but for rounding.

    Parameters
    ----------
    field
        As for :func:`spectrum` and :func:`coherence`, the whole of it or a block.
    estimate
        ``"spectrum"`` or ``"coherence"``.
    part
        ``"3/64"`` or ``(3, 64)``: the segments of the third of 64 parts, whose samples alone are read.
    first, times
        Of a block ``(time, site)``, where nothing else is at hand: the index of its first sample in
        the record, and the samples of the record. The segments that lie in it are summed; blocks that
        hold every segment once share what neighbouring segments share. Coordinates and ``t0`` are
        those of the block.
    progress
        As for :func:`analyze`.
    **options
        Those of :func:`spectrum` along time, or of :func:`coherence`. There is no jackknife.

    Returns
    -------
    Partial
        The sums. It can be pickled, and :meth:`Partial.save` and :meth:`Partial.load` write and read the
        file of ``cascade spectrum --part``.

    Raises
    ------
    ValueError
        For options or samples that do not fit, and a block that holds no segment.
    OSError
        For a file that cannot be read.
    """
    given: dict[str, object] = dict(options)
    fields = shots(field, given, given.pop("shot_dim", None))
    place = None
    if (first is None) != (times is None):
        raise ValueError("first: expected it together with times, the samples of the record, found one")
    if first is not None and times is not None:
        if part is not None or len(fields) != 1:
            raise ValueError("first: expected a block of one record, without part, found more")
        if first < 0 or times < 1:
            raise ValueError(f"first: expected samples from 0 on, found {first} of {times}")
        place = (int(first), int(times))
    sources, typed = opened(fields, given)
    if part is not None:
        typed["part"] = part if isinstance(part, str) else "/".join(map(str, part))
    said = words_of(estimate, typed, ["field"] * len(sources))
    return _native.partial(sources, said, place, observed(progress))


def combine(partials: Iterable[_native.Partial], *, memory: int | str | None = None) -> xr.Dataset:
    """The result of all segments, of partials in any order.

    It is that of one call over everything but for rounding: of :func:`spectrum` with
    ``no_jackknife=True`` or of :func:`coherence`, and of ``cascade spectrum --merge`` and so on.

    Parameters
    ----------
    partials
        Those of :func:`partial`, or of :meth:`Partial.load`.
    memory
        Bytes, or a size such as ``"2 GB"``, that the partials and the result may take; by default half of
        the free memory, beside the partials.

    Returns
    -------
    xarray.Dataset or dict
        The arrays of :func:`spectrum` or :func:`coherence`. There are no noise floors, and intervals
        of a jackknife are NaN.

    Raises
    ------
    ValueError
        For segments that are missing or there twice, and for partials of different fields or options.
    MemoryError
        For a result that needs more.
    """
    found = _native.combine(list(partials), None if memory is None else str(memory))
    warn(found)
    return arranged(found)
