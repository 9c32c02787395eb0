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
_SAME = 1e-9
"""1 - cosine of directions that are the same."""
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
    """

    direction: FloatArray
    caps: dict[int, int]
    walls: tuple[int, ...]
    steepest: float


def sample_normals(solid: Solid) -> list[FloatArray]:
    """Outward normals (m, 3) of every face: one of a plane, else those at places all over it."""
    return [face.normal[None] if face.kind == "plane" else _normals_of(face) for face in solid.faces]


def _normals_of(face: Face) -> FloatArray:
    surface = face.surface
    loops = [
        np.concatenate([surface.edge_uv(e, _ALONG_EDGES[:: 1 if forward else -1]) for e, forward in loop.directed])
        for loop in face.loops
    ]
    border = np.concatenate(loops)
    low, high = border.min(axis=0), border.max(axis=0)
    steps = (np.arange(_GRID) + 0.5) / _GRID
    grid = low + np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    return surface.normals(np.concatenate([border, grid[_is_inside(grid, loops)]]))


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
    for face, own in zip(solid.faces, normals, strict=True):
        cosines = own @ direction
        low, high = float(cosines.min()), float(cosines.max())
        if max(-low, high) <= WALL:
            walls.append(face.id)
        elif low >= STEEPEST or high <= -STEEPEST:
            caps[face.id] = 1 if low > 0 else -1
            steepest = min(steepest, max(low, -high))
        elif low < -WALL and high > WALL:
            return f"{face.label()} turns from facing along it to facing against it"
        else:
            lean = np.degrees(np.arcsin(max(min(abs(low), abs(high)), 0.0)))
            return f"{face.label()} is neither along nor across it: it leans {lean:.3g} degrees from it at its steepest"
    for edge in solid.edges:
        a, b = edge.faces
        if caps.get(a, 0) * caps.get(b, 0) < 0 and edge.dihedral < np.pi:
            one, other = solid.faces[a].label(), solid.faces[b].label()
            return f"{one} and {other} run out on each other at {edge.label()}: no layer fits between them there"
    return Sides(direction=direction, caps=caps, walls=tuple(walls), steepest=steepest)
