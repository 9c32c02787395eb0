"""Sizes that change from place to place: a function of the points, or places with a size each.

Around a place the size grows at `GROWTH` up to that of the part. How edges are divided by such sizes is the subject of
:mod:`.size_divisions`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import scipy

from ... import cad
from ...arrays import FloatArray
from ...asked import LocalSize, local_size
from ...brep import Part
from ...errors import InputError
from ...options import SweepOptions
from .biases import everywhere

Field = Callable[[FloatArray], FloatArray]
"""Wanted lengths (m,) at points (m, 3), working units."""

GROWTH = 1.3
"""Length of a segment over that of its neighbour towards a place."""
_SAMPLES = 400
"""Places along an edge among which the nearest one is looked for."""
_ASKED = 8
"""Places, the nearest ones, whose sizes are asked at a point."""
_LEAST = 1e-4
"""Size, in sizes of the part, below which a function is taken to be wrong."""


def size_field(part: Part, options: SweepOptions, size: float) -> Field | None:
    """The sizes that are wanted, nowhere above `size`; None where they are the same everywhere.

    Raises
    ------
    InputError
        A place that nothing is called, or a function that gives no positive numbers.
    """
    asked = options.local_sizes
    if asked is None:
        return None
    if callable(asked):
        return partial(_by_function, part=part, function=asked, size=size)
    fields = [_around(part, local_size(f"local size {j}", value), size) for j, value in enumerate(asked, 1)]
    return lambda points: np.min([field(points) for field in fields], axis=0)


def _by_function(points: FloatArray, *, part: Part, function: Callable[[FloatArray], Any], size: float) -> FloatArray:
    found = np.asarray(function(part.to_model(points)), dtype=float)
    if found.shape != (len(points),) or not (found > _LEAST * part.scale * part.solids[0].size).all():
        raise InputError(
            f"local_sizes must give a positive length for each of {len(points)} points (n, 3), not an array of shape "
            f"{found.shape}, least {np.min(found, initial=np.inf):.3g}"
        )
    return np.minimum(found / part.scale, size)


def _around(part: Part, asked: LocalSize, size: float) -> Field:
    if isinstance(asked.at, str | int):
        tree = scipy.spatial.cKDTree(_places(part, asked.at))
    else:
        tree = scipy.spatial.cKDTree((np.array([asked.at], dtype=float) - part.offset) / part.scale)
    own, radius = asked.size / part.scale, asked.radius / part.scale

    def sizes(points: FloatArray) -> FloatArray:
        away = np.maximum(tree.query(points)[0] - radius, 0.0)
        return np.asarray(np.minimum(own + (GROWTH - 1.0) * away, size))

    return sizes


def _places(part: Part, word: str | int) -> FloatArray:
    """Points close to each other on the edges, or the edges of the faces, or at the vertices of a name."""
    if str(word).startswith("vertices:"):
        found = everywhere(part, word, cad.select_vertices, lambda solid, v: (solid.vertex_keys[v], solid.vertices[v]))
        return np.array(list(dict(found).values()))

    def select(own: Part, name: Any) -> tuple[int, ...]:
        return cad.select_edges_of(own, name)[1]

    edges = everywhere(part, word, select, lambda solid, e: (solid.edge_keys[e], solid.edges[e]))
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    return np.concatenate([edge.curve.evaluate(at) for edge in dict(edges).values()])


@dataclass(frozen=True, kw_only=True)
class FoundSizes:
    """The sizes of a whole model as a function of points (n, 3), model units: its names mean nothing in one solid."""

    part: Part
    field: Field

    def __call__(self, points: FloatArray) -> FloatArray:
        """Lengths (n,) in model units; infinite where no place asks for any."""
        return self.field((points - self.part.offset) / self.part.scale) * self.part.scale


def no_larger_than(field: Field, part: Part, options: SweepOptions) -> SweepOptions:
    """The options with local sizes, as a function, that are nowhere above those of a field."""
    asked = size_field(part, options, np.inf)
    least = field if asked is None else lambda points: np.minimum(asked(points), field(points))
    return replace(options, local_sizes=FoundSizes(part=part, field=least))


def growing_from(places: FloatArray, sizes: FloatArray) -> Field:
    """Sizes (n,) at places (n, 3), and larger ones away from them."""
    tree = scipy.spatial.cKDTree(places)
    n = min(_ASKED, len(places))

    def field(points: FloatArray) -> FloatArray:
        away, which = (found.reshape(len(points), n) for found in tree.query(points, k=n))
        return np.asarray((sizes[which] + (GROWTH - 1.0) * away).min(axis=1))

    return field


def for_all_solids(part: Part, options: SweepOptions) -> SweepOptions:
    """The options with places that are found in the whole model, before its solids are meshed one by one."""
    if options.local_sizes is None or callable(options.local_sizes):
        return options
    field = size_field(part, options, np.inf)
    assert field is not None, "there are places"
    return replace(options, local_sizes=FoundSizes(part=part, field=field))


def noting_large(part: Part, options: SweepOptions) -> Part:
    """The part, with a note where a size is asked for that is larger than all of it: the unit may be another."""
    corners = np.concatenate([solid.vertices for solid in part.solids])
    wide = max(float(np.linalg.norm(np.ptp(corners, axis=0))), *(solid.size for solid in part.solids)) * part.scale
    if options.size is None or options.size <= wide:
        return part
    note = f"size {options.size:g} is larger than the whole part, whose diagonal is {wide:.4g}: is the unit right?"
    return replace(part, notes=(*part.notes, note))


def with_largest_size(part: Part, options: SweepOptions) -> SweepOptions:
    """The options with the largest value of a function as the size, where none is given: it is the function's all over.

    Raises
    ------
    InputError
        The function gives no positive numbers.
    """
    if options.size is not None or not callable(options.local_sizes):
        return options
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    places = np.concatenate([edge.curve.evaluate(at) for solid in part.solids for edge in solid.edges])
    most = float(_by_function(places, part=part, function=options.local_sizes, size=np.inf).max())
    return replace(options, size=most * part.scale) if np.isfinite(most) else options
