"""Wishes that are more than a number: how segments are graded along an edge, and layers along walls.

Foundation: fields of :class:`cadsweep.options.SweepOptions` hold them, as values of these classes or as mappings with
the same keys (a study file's tables), and are checked through :func:`edge_bias` and :func:`wall_layers`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any

from .errors import InputError

if TYPE_CHECKING:  # the command line checks options without numpy
    from .arrays import FloatArray

SYMMETRIC = ("both", "middle")
"""Values of `towards` that need no face: fine at both ends, fine in the middle."""
MOST_RATIO = 1e4
MOST_GROWTH = 10.0
"""Height of a layer over that of the one before: more is a slip."""
MOST_LAYERS = 1000


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

    Examples
    --------
    >>> import cadsweep as cs
    >>> cs.EdgeBias(towards="both", ratio=4).ratio
    4
    >>> cs.EdgeBias(towards="both")
    Traceback (most recent call last):
    cadsweep.errors.InputError: a bias needs either a ratio or a first length, one of the two
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
        raise InputError(f"{what} must be a table of {', '.join(known)}, or cadsweep.{kind.__name__}, not {value!r}")
    for key in value:
        if key not in known:
            raise InputError(f"{what}: there is no '{key}'", try_=f"one of {', '.join(known)}")
    try:
        return kind(**value)
    except (InputError, TypeError) as error:
        raise InputError(f"{what}: {error}") from error


@dataclass(frozen=True, kw_only=True)
class WallLayers:
    """Layers of hexahedra along a wall, thin at it and growing away from it.

    Attributes
    ----------
    first : float
        Height of the first layer, model units.
    growth : float
        Height of each layer over that of the one before, at least 1.
    n : int
        Number of layers.

    Examples
    --------
    >>> import cadsweep as cs
    >>> layers = cs.WallLayers(first=0.05, growth=1.2, n=8)
    >>> layers.first * layers.growth  # the second one
    0.06
    """

    first: float
    growth: float = 1.2
    n: int = 8

    def __post_init__(self) -> None:
        check_positive("the first height of wall layers", self.first)
        check_positive("the growth of wall layers", self.growth)
        if not 1.0 <= self.growth <= MOST_GROWTH:
            raise InputError(f"the growth of wall layers must lie between 1 and {MOST_GROWTH:g}, not {self.growth!r}")
        if isinstance(self.n, bool) or not isinstance(self.n, Integral) or not 1 <= self.n <= MOST_LAYERS:
            raise InputError(
                f"the number of wall layers must be a whole number from 1 to {MOST_LAYERS}, not {self.n!r}"
            )


def wall_layers(what: str, value: Any) -> WallLayers:
    """Read what is asked of a wall; `what` is how messages name the wish.

    Raises
    ------
    InputError
        It is neither a :class:`WallLayers` nor a mapping with its keys; says which key is wrong.
    """
    found: WallLayers = _read(WallLayers, what, value)
    return found


def layer_heights(first: FloatArray, growth: FloatArray, n: int, room: FloatArray) -> FloatArray:
    """Distances (c, n) of the layers' nodes from the wall, thinned where there is less `room` (c,) than they want.

    The first height is kept as long as n such layers fit: the growth gives way. Else all layers are thinned alike.
    """
    import numpy as np

    wanted = first * growth_sum(growth, n)
    total = np.minimum(wanted, room)
    low, high = np.ones_like(total), np.asarray(growth, dtype=float)
    for _ in range(60):
        middle = (low + high) / 2
        over = first * growth_sum(middle, n) > total
        high, low = np.where(over, middle, high), np.where(over, low, middle)
    grown = np.where(total >= wanted, growth, low)
    steps = np.arange(n)
    heights: FloatArray = np.cumsum(first[:, None] * grown[:, None] ** steps, axis=1)
    return heights * np.minimum(1.0, total / heights[:, -1])[:, None]


def growth_sum(growth: FloatArray, n: int) -> FloatArray:
    """Thickness of n layers in heights of the first one."""
    import numpy as np

    total: FloatArray = (np.asarray(growth)[..., None] ** np.arange(n)).sum(axis=-1)
    return total


@dataclass(frozen=True, kw_only=True)
class LocalSize:
    """A size at a place; away from it sizes grow to that of the part.

    Attributes
    ----------
    at : (float, float, float) or str
        A point in model units; or the edges of a name, id or selector, the edges of its faces (``"faces:inlet"``), or
        vertices (``"vertices:>X"``).
    radius : float
        Distance up to which the size holds, model units.
    size : float
        Wanted edge length, model units.

    Examples
    --------
    >>> import cadsweep as cs
    >>> cs.LocalSize(at=(0, 0, 10), radius=2.0, size=0.5).size
    0.5
    """

    at: Any
    radius: float = 0.0
    size: float

    def __post_init__(self) -> None:
        check_positive("the size at a place", self.size)
        if not _is_number(self.radius) or self.radius < 0:
            raise InputError(f"the radius around a place must be a number of at least 0, not {self.radius!r}")
        if isinstance(self.at, Sequence) and not isinstance(self.at, str):
            if len(self.at) != 3 or not all(_is_number(c) for c in self.at):
                raise InputError(f"a place is a point of three coordinates or a name, not {self.at!r}")
        elif isinstance(self.at, bool) or not isinstance(self.at, str | int) or self.at == "":
            raise InputError(f"a place is a point of three coordinates or a name, not {self.at!r}")


def local_size(what: str, value: Any) -> LocalSize:
    """Read a size at a place; `what` is how messages name it.

    Raises
    ------
    InputError
        It is neither a :class:`LocalSize` nor a mapping with its keys; says which key is wrong.
    """
    found: LocalSize = _read(LocalSize, what, value)
    return found
