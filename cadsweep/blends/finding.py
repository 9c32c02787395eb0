r"""Blends found by geometry: what bends between two smooth borders, whatever its surface is called.

Place in the flow: ``cadsweep info`` lists them.

Method: a group of faces (:mod:`.springs`) whose smooth borders are two runs of edges with what bends less, and which
turns one way between them, replaces an edge; a patch with three and more such neighbours replaces a corner::

        support                 plane   spring
    ______________                 ______.____
                  \  blend               .    \ corner
    - - spring - - |               blend .     |
                   | support       ______.____ |
                   |

No blends, though they look so from one side: full rounds and the ends of slots, which turn too far to replace an edge;
walls that are bent, whose inside and outside are one thickness apart (:mod:`.bent`).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from .bent import bent_walls
from .springs import Side, Springs, find_springs, joined

_LEAST, _MOST = 0.15, 0.75 * pi
"""How far a blend turns, radians: less is no edge, more leaves a tip below 45 degrees where it is taken away."""
_LEAST_SINE = 0.01
"""Below, the chord says nothing of the radius: what turns so little is no blend anyway."""
_SAME = 0.03
"""Radii of a blend that differ by a smaller share are one."""


@dataclass(frozen=True, kw_only=True)
class Blend:
    """A rounding that replaces an edge, or a patch that replaces a corner.

    Attributes
    ----------
    kind : str
        ``"edge"`` or ``"corner"``.
    faces : tuple of int
        Face ids: pieces of one rounding.
    supports : tuple of tuple of int
        Of an edge, the faces on either side; of a corner, all faces around it.
    convex : bool
        Whether material was taken away.
    radii : (float, float)
        The smallest and the largest along its borders, working units; equal where the radius is constant. Of a corner
        the radius where it bends most, twice.
    turn : float
        Angle between the supports' normals, radians; of a corner 0.
    """

    kind: str
    faces: tuple[int, ...]
    supports: tuple[tuple[int, ...], ...]
    convex: bool
    radii: tuple[float, float]
    turn: float = 0.0

    def described(self, solid: Solid) -> dict[str, Any]:
        """The row of ``cadsweep info``: faces by the numbers that a user knows, radii in model units."""
        known = {face.id: face.known for face in solid.faces}
        return {
            "kind": self.kind,
            "convex": self.convex,
            "faces": [known[f] for f in self.faces],
            "supports": [[known[f] for f in side] for side in self.supports],
            "radii": [radius * solid.units.scale for radius in self.radii],
        }


def find_blends(solid: Solid) -> list[Blend]:
    """Find the blends of a solid.

    Parameters
    ----------
    solid : Solid

    Returns
    -------
    list of Blend
        Edges first, each by its lowest face; no face is in two of them.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> from cadsweep.blends import find_blends
    >>> plate = cs.load(cq.Workplane().box(10, 8, 2).edges("|Z").fillet(1)).solids[0]
    >>> [(blend.kind, blend.convex, round(blend.radii[0] * plate.units.scale, 6)) for blend in find_blends(plate)]
    [('edge', True, 1.0), ('edge', True, 1.0), ('edge', True, 1.0), ('edge', True, 1.0)]
    """
    springs = find_springs(solid)
    candidates = {group: found for group in sorted(set(springs.group_of)) if (found := _springing(springs, group))}
    for group, edges in list(candidates.items()):
        runs = joined(solid, list(edges))
        # What turns too far, or carries roundings itself, is no blend, and its neighbours must not take it for one.
        if len(runs) == 2 and _is_one_way(springs, edges):
            is_blend = _LEAST <= _across(springs, edges, runs)[0] <= _MOST
        else:
            is_blend = not _carries(springs, group)
        if not is_blend:
            del candidates[group]
    edge_blends, corners = list[Blend](), list[Blend]()
    borders = list[tuple[bool, list[Side], list[int]]]()
    for group, edges in candidates.items():
        sides = springs.borders(group)
        blended = [e for e, (_, outside) in sides.items() if springs.group_of[outside] in candidates
                   and (e, outside) in springs.sides]  # fmt: skip
        runs = joined(solid, [e for e in edges if e not in blended])
        faces = tuple(f for f, own in enumerate(springs.group_of) if own == group)
        convex = springs.sides[next(iter(edges.items()))].bend > 0
        if len(runs) == 2 and _is_one_way(springs, edges):
            turn, radii = _across(springs, edges, runs)
            supports = tuple(tuple(sorted({sides[e][1] for e in run})) for run in runs)
            if not _LEAST <= turn <= _MOST or supports[0] == supports[1]:
                continue
            blend = Blend(kind="edge", faces=faces, supports=supports, convex=convex, radii=radii, turn=turn)
            ends = [e for run in runs for e in run]
            edge_blends.append(blend)
            borders.append((convex, [springs.sides[e, edges[e]] for e in ends], ends))
        elif len({springs.group_of[sides[e][1]] for e in blended}) >= 3:
            around = tuple((f,) for f in sorted({outside for _, outside in sides.values()}))
            bend = max((springs.sides[e, f].bend for e, f in edges.items()), key=abs)
            radius, convex = 1.0 / abs(bend), bend > 0
            corners.append(Blend(kind="corner", faces=faces, supports=around, convex=convex, radii=(radius, radius)))
    bent = bent_walls(solid, borders)
    return [blend for j, blend in enumerate(edge_blends) if j not in bent] + corners


def _springing(springs: Springs, group: int) -> dict[int, int]:
    """Edges, and the group's face at each, at which the group springs from others; empty where it is no rounding."""
    found = {e: f for e, (f, other) in springs.borders(group).items() if springs.springs(e, f, other)}
    return found if len(found) >= 2 else {}


def _carries(springs: Springs, group: int) -> bool:
    """Whether more springs from a group, by length, than it springs from others: a hub's wall with a rounded foot."""
    own = theirs = 0.0
    for e, (inside, outside) in springs.borders(group).items():
        length = springs.solid.edges[e].length
        own += length * springs.springs(e, inside, outside)
        theirs += length * springs.springs(e, outside, inside)
    return theirs > own


def _is_one_way(springs: Springs, inside: dict[int, int]) -> bool:
    """Whether a group bends to one side at all its borders; a patch between convex and concave ones need not."""
    bends = np.concatenate([springs.sides[e, f].bends for e, f in inside.items()])
    return bool((bends > 0).all() or (bends < 0).all())


def _across(springs: Springs, inside: dict[int, int], runs: list[list[int]]) -> tuple[float, tuple[float, float]]:
    """How far a rounding turns from one border to the other, and its radii: each from the chord and the turn there."""
    turns, radii = [], []
    for e in runs[0]:
        side = springs.sides[e, inside[e]]
        for j in range(len(side.points)):
            over = [_over(springs.solid, side, j, other, inside[other]) for other in runs[1]]
            turn, chord = min(over, key=lambda found: found[1])
            turns.append(turn)
            radii.append(chord / (2.0 * max(np.sin(0.5 * turn), _LEAST_SINE)))
    return float(np.median(turns)), _told(np.array(radii))


def _over(solid: Solid, side: Side, j: int, edge: int, face: int) -> tuple[float, float]:
    """Turn and chord from a place on one border to the nearest of an edge of the other, where `face` bends."""
    place = side.points[j : j + 1]
    fraction = solid.edges[edge].curve.project(place)
    there = solid.edges[edge].curve.evaluate(fraction)
    surface = solid.faces[face].surface
    normal = surface.normals(surface.edge_uv(edge, fraction))[0]
    way = 1.0 if side.bend > 0 else -1.0
    turn = float(np.arctan2(way * (normal @ side.inward[j]), normal @ side.normals[j])) % (2.0 * pi)
    return turn, float(np.linalg.norm(there - place))


def _told(radii: FloatArray) -> tuple[float, float]:
    """The smallest and the largest of radii; their middle twice where they are one."""
    low, high, middle = float(radii.min()), float(radii.max()), float(np.median(radii))
    return (middle, middle) if high - low < _SAME * high else (low, high)


__all__ = ["Blend", "find_blends"]
