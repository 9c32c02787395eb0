"""Faces as a direction sees them: walls along it, caps across it, and those that are neither.

Place in the flow: first step of :mod:`cadsweep.stacks`.

Method: normals are sampled on the edges of a face and inside it, once; a direction is then a matrix product.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..brep import Edge, Face, Solid
from ..errors import NotSweepableError
from .normals import Normals

WALL = 1e-6
"""Cosine between a normal and the direction up to which a face lies along it: a part in a million of its height."""
UPRIGHT = 5e-5
"""Lean up to which an edge between two walls lies along the direction, as a share of its length."""
STEEPEST = 0.05
"""Cosine below which a cap is too steep to carry layers: some 3 degrees from the direction."""
ROUNDED = 1e-3
"""Cosine up to which a cap may run along the direction at an edge, as a rounding does that is tangent to a wall."""
ROUNDED_LEAN = 0.35
"""Steepest cosine of a rounding's quads: `MOST_ACROSS` chords of a quarter of a circle, at equal steps in the plane."""
LEAST_ACROSS = 2
MOST_ACROSS = 3
"""Quads from the wall to the end of a rounding: of more, the one at the wall would be too steep."""
_ALONG = np.linspace(0.0, 1.0, 5)
"""Where an edge is looked at."""
_SAME = 1e-9
"""1 - cosine of directions that are the same."""
SMOOTH = 1e-3
"""Angle from pi up to which two faces go on into each other."""
_TOLD = 1e-3
"""Degrees below which a lean is none to speak of."""


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
    steepest_cap : int or None
        The cap that has it; None where all caps are flat.
    rounded : tuple of int
        The caps that turn until they run along the direction, at an edge.
    """

    direction: FloatArray
    caps: dict[int, int]
    walls: tuple[int, ...]
    steepest: float
    steepest_cap: int | None = None
    rounded: tuple[int, ...] = ()


def find_stations(solid: Solid, sides: Sides) -> tuple[int, ...]:
    """Edges between two walls that do not run along the direction: layers must end at them."""
    return tuple(
        edge.id
        for edge in solid.edges
        if not sides.caps.keys() & set(edge.faces) and not _runs_along(edge, sides.direction)
    )


def _runs_along(edge: Edge, direction: FloatArray) -> bool:
    """Whether all of an edge lies along a direction; an arc may only begin and end so."""
    points = edge.curve.evaluate(_ALONG)
    offsets = points - points[0]
    across = offsets - np.outer(offsets @ direction, direction)
    return float(np.linalg.norm(across, axis=1).max()) <= UPRIGHT * float(np.linalg.norm(offsets, axis=1).max())


def read_sides(normals: Normals, direction: FloatArray) -> Sides:
    """Tell walls from caps along a direction.

    Raises
    ------
    NotSweepableError
        A face is neither, or runs out on another; says which one and why.
    """
    solid = normals.solid
    caps: dict[int, int] = {}
    walls: list[int] = []
    candidates: list[Face] = []
    leans: dict[int, float] = {}
    # Planes first: they cost nothing, and one that leans ends it.
    for face in sorted(solid.faces, key=lambda face: face.kind != "plane"):
        low, high = _range(normals, face, direction)
        if max(-low, high) <= WALL:
            walls.append(face.id)
        elif low >= STEEPEST or high <= -STEEPEST:
            caps[face.id] = 1 if low > 0 else -1
            leans[face.id] = max(low, -high)
        elif low < -ROUNDED and high > ROUNDED:
            raise NotSweepableError(_turns(face))
        elif face.kind == "plane":
            raise NotSweepableError(_leans(face, max(low, -high)))
        else:
            _refuse_turning(normals, face, direction)
            candidates.append(face)
    for face in candidates:
        caps[face.id] = _rounding(normals, face, direction)
        leans[face.id] = ROUNDED_LEAN
    steepest_cap = min(leans, key=lambda f: leans[f], default=None)
    if steepest_cap is not None and leans[steepest_cap] >= 1.0 - _SAME:
        steepest_cap = None
    for edge in solid.edges:
        a, b = edge.faces
        if caps.get(a, 0) * caps.get(b, 0) < 0 and edge.dihedral < np.pi:
            one, other = solid.faces[a].label(), solid.faces[b].label()
            raise NotSweepableError(
                f"{one} and {other} run out on each other at {edge.label()}: no layer fits between them there"
            )
    return Sides(
        direction=direction,
        caps=dict(sorted(caps.items())),
        walls=tuple(sorted(walls)),
        steepest=min([*leans.values(), 1.0]),
        steepest_cap=steepest_cap,
        rounded=tuple(face.id for face in candidates),
    )


def _range(normals: Normals, face: Face, direction: FloatArray) -> tuple[float, float]:
    """Least and greatest cosine between a face's normals and the direction."""
    axis = normals.axes.get(face.id)
    if axis is not None and float(np.linalg.norm(axis - (axis @ direction) * direction)) <= WALL:
        return 0.0, 0.0
    cosines = normals.of(face) @ direction
    return float(cosines.min()), float(cosines.max())


def _turns(face: Face) -> str:
    return f"{face.label()} turns from facing along it to facing against it"


def _leans(face: Face, cosine: float) -> str:
    lean = np.degrees(np.arcsin(np.clip(cosine, 0.0, 1.0)))
    how = f"it leans {lean:.3g} degrees from it at its steepest" if lean > _TOLD else "in places it runs along it"
    return f"{face.label()} is neither along nor across it: {how}"


def _refuse_turning(normals: Normals, face: Face, direction: FloatArray) -> None:
    """Refuse a face that goes on into one that faces the other way, as one half of a bore across the direction does."""
    solid, own = normals.solid, normals.of(face) @ direction
    for e in dict.fromkeys(face.edges):
        edge = solid.edges[e]
        if abs(edge.dihedral - np.pi) > SMOOTH:
            continue
        other = solid.faces[edge.faces[edge.faces[0] == face.id]]
        low, high = _range(normals, other, direction)
        if (low < -ROUNDED and own.max() > ROUNDED) or (high > ROUNDED and own.min() < -ROUNDED):
            raise NotSweepableError(_turns(face))


def _rounding(normals: Normals, face: Face, direction: FloatArray) -> int:
    """Side of a face that is a cap but for edges along which it runs along the direction.

    Raises
    ------
    NotSweepableError
        It is steep elsewhere, too.
    """
    # At its ends an edge may touch the line along which the face is tangent to a wall.
    cosines = [own[1:-1] @ direction for own in normals.on_edges(face).values()]
    cosines = [own for own in cosines if float(np.abs(own).max()) > ROUNDED]
    everything = np.concatenate([*cosines, normals.inside(face) @ direction])
    if not len(everything) or float(np.abs(everything).min()) < STEEPEST or np.ptp(np.sign(everything)) > 0:
        raise NotSweepableError(_leans(face, float(np.abs(everything).min(initial=1.0))))
    return int(np.sign(everything[0]))
