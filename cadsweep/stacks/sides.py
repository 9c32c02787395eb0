"""Faces as a direction sees them: walls along it, caps across it, and those that are neither.

Place in the flow: first step of :mod:`cadsweep.stacks`.

Method: normals are sampled on the edges of every face and inside it, once; a direction is then a matrix product.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Solid

WALL = 1e-6
"""Cosine between a normal and the direction up to which a face lies along it: a part in a million of its height."""
STEEPEST = 0.05
"""Cosine below which a cap is too steep to carry layers: some 3 degrees from the direction."""
ROUNDED = 1e-3
"""Cosine up to which a cap may run along the direction at an edge, as a rounding does that is tangent to a wall."""
ROUNDED_LEAN = 0.35
"""Steepest cosine of a rounding's quads: `MOST_ACROSS` chords of a quarter of a circle, at equal steps in the plane."""
LEAST_ACROSS = 2
MOST_ACROSS = 3
"""Quads from the wall to the end of a rounding: of more, the one at the wall would be too steep."""
_SAME = 1e-9
"""1 - cosine of directions that are the same."""
_TOLD = 1e-3
"""Degrees below which a lean is none to speak of."""
_ALONG_EDGES = np.linspace(0.0, 1.0, 9)
_GRID = 9


@dataclass(frozen=True, kw_only=True, eq=False)
class Sides:
    """Every face of a solid as one direction sees it.

    Attributes
    ----------
    direction : (3,) float64
    caps : dict of int to int
        Faces that a line along the direction crosses once: 1 where it leaves the solid, -1 where it enters.
    walls : tuple of int
    steepest : float
        Least cosine between a cap's normal and the direction: 1 where all caps are flat.
    rounded : tuple of int
        The caps that turn until they run along the direction, at an edge.
    """

    direction: FloatArray
    caps: dict[int, int]
    walls: tuple[int, ...]
    steepest: float
    rounded: tuple[int, ...] = ()


def sample_normals(solid: Solid) -> list[FloatArray]:
    """Outward normals (m, 3) of every face: one of a plane, else those at places all over it."""
    return [face.normal[None] if face.kind == "plane" else _normals_of(face) for face in solid.faces]


def _normals_of(face: Face) -> FloatArray:
    border = np.concatenate(_border(face))
    return face.surface.normals(np.concatenate([border, _inner_places(face)]))


def _border(face: Face) -> list[FloatArray]:
    """Parameters (m, 2) along every loop."""
    return [
        np.concatenate([face.surface.edge_uv(e, _ALONG_EDGES[:: 1 if forward else -1]) for e, forward in loop.directed])
        for loop in face.loops
    ]


def _inner_places(face: Face) -> FloatArray:
    """Parameters (m, 2) all over a face."""
    loops = _border(face)
    low, high = np.concatenate(loops).min(axis=0), np.concatenate(loops).max(axis=0)
    steps = (np.arange(_GRID) + 0.5) / _GRID
    grid = low + np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    return np.asarray(grid[_is_inside(grid, loops)])


def _rounding(face: Face, direction: FloatArray) -> int:
    """Side of a face that is a cap but for edges along which it runs along the direction; 0 where it is none."""
    surface = face.surface
    cosines = []
    for loop in face.loops:
        for e, _ in loop.directed:
            # At its ends an edge may touch the line along which the face is tangent to a wall.
            along = surface.normals(surface.edge_uv(e, _ALONG_EDGES[1:-1])) @ direction
            if float(np.abs(along).max()) > ROUNDED:
                cosines.append(along)
    cosines.append(surface.normals(_inner_places(face)) @ direction)
    everything = np.concatenate(cosines)
    if not len(everything) or float(np.abs(everything).min()) < STEEPEST:
        return 0
    sides = np.unique(np.sign(everything))
    return int(sides[0]) if len(sides) == 1 else 0


def _is_inside(places: FloatArray, loops: list[FloatArray]) -> np.ndarray:
    """Which places (m, 2) an even-odd walk finds inside of closed polygons."""
    inside = np.zeros(len(places), dtype=bool)
    x, y = places[:, :1], places[:, 1:]
    for loop in loops:
        a, b = loop, np.roll(loop, -1, axis=0)
        crosses = (a[:, 1] > y) != (b[:, 1] > y)
        rise = np.where(b[:, 1] == a[:, 1], 1.0, b[:, 1] - a[:, 1])
        at = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
        inside ^= (crosses & (x < at)).sum(axis=1) % 2 == 1
    return inside


def find_directions(solid: Solid, normals: list[FloatArray]) -> list[FloatArray]:
    """Directions worth a look: normals of planes, axes of cylinders and cones, straight edges; each once."""
    found: list[FloatArray] = []
    for face, own in zip(solid.faces, normals, strict=True):
        if face.kind == "plane":
            found.append(face.normal)
        elif face.kind in ("cylinder", "cone", "extrusion") and len(own) > 2:
            # The normals of all three lie on a circle about the axis.
            _, spread, axes = np.linalg.svd(own - own.mean(axis=0))
            if spread[1] > 1e-6 and spread[2] < 1e-6 * spread[0]:
                found.append(axes[2])
    found += [edge.tangents[0] for edge in solid.edges if edge.kind == "line"]
    kept: list[FloatArray] = []
    for direction in found:
        unit = direction / np.linalg.norm(direction)
        if all(abs(unit @ other) < 1.0 - _SAME for other in kept):
            # Upwards along its greatest coordinate, so that a part and its mirror image are seen alike.
            kept.append(unit * np.sign(unit[np.argmax(np.abs(unit).round(6))]))
    return kept


def find_stations(solid: Solid, sides: Sides) -> tuple[int, ...]:
    """Edges between two walls that do not run along the direction: layers must end at them."""
    return tuple(
        edge.id
        for edge in solid.edges
        if not sides.caps.keys() & set(edge.faces)
        and abs(edge.tangents[0] @ sides.direction) < (1.0 - _SAME) * float(np.linalg.norm(edge.tangents[0]))
    )


def read_sides(solid: Solid, direction: FloatArray, normals: list[FloatArray]) -> Sides | str:
    """Tell walls from caps along a direction, or say which face is neither or runs out on another, and why."""
    caps: dict[int, int] = {}
    walls: list[int] = []
    steepest = 1.0
    ranges = [(float(cosines.min()), float(cosines.max())) for cosines in (own @ direction for own in normals)]
    rounded = []
    for face, (low, high) in zip(solid.faces, ranges, strict=True):
        if max(-low, high) <= WALL:
            walls.append(face.id)
        elif low >= STEEPEST or high <= -STEEPEST:
            caps[face.id] = 1 if low > 0 else -1
            steepest = min(steepest, max(low, -high))
        elif low < -ROUNDED and high > ROUNDED:
            return f"{face.label()} turns from facing along it to facing against it"
        elif (side := _rounding(face, direction)) != 0:
            caps[face.id] = side
            rounded.append(face.id)
            steepest = min(steepest, ROUNDED_LEAN)
        else:
            lean = np.degrees(np.arcsin(np.clip(max(low, -high), 0.0, 1.0)))
            tilt = (
                f"it leans {lean:.3g} degrees from it at its steepest" if lean > _TOLD else "in places it runs along it"
            )
            return f"{face.label()} is neither along nor across it: {tilt}"
    for edge in solid.edges:
        a, b = edge.faces
        if caps.get(a, 0) * caps.get(b, 0) < 0 and (edge.dihedral < np.pi or {a, b}.intersection(rounded)):
            one, other = solid.faces[a].label(), solid.faces[b].label()
            return f"{one} and {other} run out on each other at {edge.label()}: no layer fits between them there"
    return Sides(direction=direction, caps=caps, walls=tuple(walls), steepest=steepest, rounded=tuple(rounded))
