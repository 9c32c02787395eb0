"""Wishes that are more than a number: how segments are graded along an edge.

Foundation: fields of :class:`cadsweep.options.SweepOptions` hold them, as values of these classes or as mappings with
the same keys (a study file's tables), and are checked through :func:`edge_bias`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from numbers import Real
from typing import Any

from .errors import InputError

SYMMETRIC = ("both", "middle")
"""Values of `towards` that need no face: fine at both ends, fine in the middle."""
MOST_RATIO = 1e4


@dataclass(frozen=True, kw_only=True)
class EdgeBias:
    """Grading of the segments of an edge.

    Attributes
    ----------
    towards : str or (float, float, float)
        Where segments are short: at the end that is nearer to a face (name, id or selector), to a vertex
        (``"vertices:>X"``, a CadQuery selector) or to a point (x, y, z) in model units; ``"both"`` ends, or the
        ``"middle"``.
    ratio : float or None
        Length of the longest segment over the shortest.
    first : float or None
        Length of the shortest segment instead, model units; the ratio follows from the number of segments.
    """

    towards: Any
    ratio: float | None = None
    first: float | None = None

    def __post_init__(self) -> None:
        if (self.ratio is None) == (self.first is None):
            raise InputError("a bias needs either a ratio or a first length, one of the two")
        if self.ratio is not None:
            check_positive("the ratio of a bias", self.ratio)
            if not 1.0 <= self.ratio <= MOST_RATIO:
                raise InputError(
                    f"the ratio of a bias is the longest segment over the shortest, from 1 to {MOST_RATIO:g}, "
                    f"not {self.ratio!r}"
                )
        if self.first is not None:
            check_positive("the first length of a bias", self.first)
        if isinstance(self.towards, Sequence) and not isinstance(self.towards, str):
            if len(self.towards) != 3 or not all(_is_number(c) for c in self.towards):
                raise InputError(f"a bias goes towards a point of three coordinates, not {self.towards!r}")
        elif isinstance(self.towards, bool) or not isinstance(self.towards, str | int) or self.towards == "":
            raise InputError(f"a bias goes towards a face, a vertex, a point, 'both' or 'middle', not {self.towards!r}")
        if self.first is not None and self.towards == "middle":
            raise InputError("a first length is at an end of an edge: with towards='middle' give a ratio")


def edge_bias(what: str, value: Any) -> EdgeBias:
    """Read what is asked of edges; `what` is how messages name the wish.

    Raises
    ------
    InputError
        It is neither an :class:`EdgeBias` nor a mapping with its keys; says which key is wrong.
    """
    found: EdgeBias = _read(EdgeBias, what, value)
    return found


def check_positive(name: str, value: Any) -> None:
    """Refuse what is not a positive, finite number."""
    if not _is_number(value) or value <= 0:
        raise InputError(f"{name} must be a positive, finite number, not {value!r}")


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def _read(kind: Any, what: str, value: Any) -> Any:
    """A value of a class here, or a mapping of its fields, as a value of the class."""
    if isinstance(value, kind):
        return value
    known = {own.name: own for own in fields(kind)}
    if not isinstance(value, Mapping):
        raise InputError(f"{what} must be a {kind.__name__} or a table of {', '.join(known)}, not {value!r}")
    for key in value:
        if key not in known:
            raise InputError(f"{what}: there is no '{key}'; there are {', '.join(known)}")
    try:
        return kind(**value)
    except (InputError, TypeError) as error:
        raise InputError(f"{what}: {error}") from error
