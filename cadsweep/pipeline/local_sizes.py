"""Sizes that change from place to place: a function of the points, or places with a size each.

Around a place the size grows at `GROWTH` up to that of the part. Edges get as many segments as the sizes along them
ask for, and are divided by them; edges of the two caps that answer each other, and rails of one span, by the least
size of them all at one height, so that rows and layers stay straight.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import scipy

from .. import cad
from ..arrays import FloatArray
from ..asked import LocalSize, local_size
from ..brep import Part, Solid
from ..errors import InputError
from ..options import SweepOptions
from ..surface import Division
from ..sweep import Sweep
from .biases import everywhere

Field = Callable[[FloatArray], FloatArray]
"""Wanted lengths (m,) at points (m, 3), working units."""

GROWTH = 1.3
"""Length of a segment over that of its neighbour towards a place."""
_SAMPLES = 400
"""Places along an edge where the size is asked for."""
_ACROSS = 33
"""Places across a side at which the size is looked at."""
_VARIES = 1.05
"""Greatest size along an edge over the least from which on it is divided unevenly."""
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
    edges = everywhere(
        part, word, lambda own, name: cad.select_edges_of(own, name)[1], lambda solid, e: (e, solid.edges[e])
    )
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    return np.concatenate([edge.curve.evaluate(at) for edge in dict(edges).values()])


def divide_by_sizes(sweep: Sweep, field: Field) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes of all edges of a sweep, and the divisions of those along which the size changes."""
    solid = sweep.solid
    sizes: dict[int, float] = {}
    divisions: dict[int, Division] = {}
    on_sides = _along_sides(sweep, field)
    for group in _groups(sweep):
        rows = [_along(solid, e, forward, field) for e, forward in group.items()]
        rows += [row if forward == up else row[::-1] for e, forward in group.items() for up, row in on_sides.get(e, ())]
        along = np.min(rows, axis=0)
        steps = 2.0 / (along[1:] + along[:-1])
        run = np.concatenate([[0.0], np.cumsum(steps)]) / len(steps)  # segments a unit length
        for e, forward in group.items():
            sizes[e] = 1.0 / float(run[-1])
            if along.max() > _VARIES * along.min():
                places = run / run[-1]
                divisions[e] = partial(_by_density, places=places if forward else 1.0 - places[::-1])
    return sizes, divisions


def _along_sides(sweep: Sweep, field: Field) -> dict[int, list[tuple[bool, FloatArray]]]:
    """Least sizes across each side at every height, by its left rail, and whether that runs upwards."""
    found: dict[int, list[tuple[bool, FloatArray]]] = {}
    t = np.linspace(0.0, 1.0, _SAMPLES + 1)
    s = np.linspace(0.0, 1.0, _ACROSS)[:, None, None]
    for side in sweep.linking_sides:
        chains = (side.bottom, side.right, side.top, side.left)
        if any(len(chain) != 1 for chain in chains):
            continue
        curves = [sweep.solid.edges[chain[0][0]].curve for chain in chains]
        forward = [chain[0][1] for chain in chains]
        left, right = (curves[j].evaluate(t if forward[j] else 1.0 - t) for j in (3, 1))
        bottom, top = (curves[j].evaluate((s if forward[j] else 1.0 - s).ravel())[:, None] for j in (0, 2))
        high = t[:, None]
        corners = (1 - s) * ((1 - high) * left[0] + high * left[-1]) + s * ((1 - high) * right[0] + high * right[-1])
        patch = (1 - s) * left + s * right + (1 - high) * bottom + high * top - corners  # Coons
        least = field(patch.reshape(-1, 3)).reshape(_ACROSS, -1).min(axis=0)
        found.setdefault(side.left[0][0], []).append((forward[3], least))
    return found


def _by_density(n: int, *, places: FloatArray) -> FloatArray:
    fractions = np.interp(np.linspace(0.0, 1.0, n + 1), places, np.linspace(0.0, 1.0, len(places)))
    fractions[0], fractions[-1] = 0.0, 1.0
    return np.asarray(fractions)


def _along(solid: Solid, edge: int, forward: bool, field: Field) -> FloatArray:
    found = field(solid.edges[edge].curve.evaluate(np.linspace(0.0, 1.0, _SAMPLES + 1)))
    return found if forward else found[::-1]


def _groups(sweep: Sweep) -> list[Mapping[int, bool]]:
    """Edges that divide themselves alike, and whether each runs the way of the first."""
    pairs: list[tuple[tuple[int, bool], tuple[int, bool]]] = []
    for side in sweep.linking_sides:
        for one, other in ((side.bottom, side.top), (side.left, side.right)):
            if len(one) == len(other) == 1:
                pairs.append((one[0], other[0]))
    for loops in zip(*sweep.spans, strict=False):  # rails of different loops
        directions = _directions(sweep)
        whole = [span[0] for span in loops if span and span[0] in directions]
        pairs += [((whole[0], directions[whole[0]]), (e, directions[e])) for e in whole[1:]]
    neighbours: dict[int, list[tuple[int, bool]]] = {edge.id: [] for edge in sweep.solid.edges}
    for (a, a_forward), (b, b_forward) in pairs:
        neighbours[a].append((b, a_forward == b_forward))
        neighbours[b].append((a, a_forward == b_forward))
    groups: list[Mapping[int, bool]] = []
    seen: set[int] = set()
    for edge in neighbours:
        if edge in seen:
            continue
        group = {edge: True}
        waiting = [edge]
        while waiting:
            present = waiting.pop()
            for other_edge, same in neighbours[present]:
                if other_edge not in group:
                    group[other_edge] = group[present] == same
                    waiting.append(other_edge)
        seen |= group.keys()
        groups.append(group)
    return groups


def _directions(sweep: Sweep) -> dict[int, bool]:
    """Whether each rail runs from the source to the target."""
    return {e: forward for side in sweep.linking_sides for e, forward in (*side.left, *side.right)}
