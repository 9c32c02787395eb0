"""Planes beside a hole that crosses an extrusion: through inner edges of the profile, along the hole.

Place in the flow: candidates of :mod:`.cutters`. A hole across a bar of any profile (a T-slot, an angle, a rail) needs
a slab of its own with nothing else in it: then the slab is swept along the hole, what is on either side along the bar.
The faces at the inner edges of the profile, extended, may lean towards the hole and run into it; a plane along both the
edge and the hole does not.

Elsewhere (the foot of a hexagon on a flange) they part what other cutters would leave whole: they have no credit then.

Not handled: profiles without an inner edge on one side of the hole get a plane on the other side alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi

import numpy as np

from ...arrays import FloatArray
from ...brep import Edge, Solid
from .axes import Axis, find_axes, is_hollow
from .central import Cutter, plane_tool
from .crossings import FLAT

CLEAR = 1.05
"""Distance of a plane from the axis, in radii, from which on it leaves the hole alone."""
ALONG = 1e-9
"""1 - cosine of directions that are the same."""
LEAST_TURN = 1e-3
"""Sine of the angle between an edge and a hole from which on they are not parallel."""
SAME = 1e-6
"""Distance, as a share of the cell's size, up to which two planes are one."""
MOST = 4
"""Pairs of planes of one cell, those through the longest edges first."""


def beside_holes(solid: Solid) -> list[Cutter]:
    """For every hole the planes next to it on either side, through edges that are re-entrant."""
    inner = [edge for edge in solid.edges if edge.kind == "line" and edge.dihedral > pi + FLAT]
    if not inner:
        return []
    found: dict[tuple[int, ...], Cutter] = {}
    for axis in find_axes(solid):
        if _is_hole(solid, axis):
            for key, cutter in _beside(solid, axis, inner):
                found.setdefault(key, cutter)
    return sorted(found.values(), key=lambda cutter: -cutter.weight)[:MOST]


def _beside(solid: Solid, axis: Axis, inner: Sequence[Edge]) -> Iterator[tuple[tuple[int, ...], Cutter]]:
    """The planes of each direction, and the edges that they go through."""
    for normal in _normals(axis, inner):
        own = [edge for edge in inner if abs(float(edge.tangents[0] @ normal)) < FLAT]
        off = np.array([normal @ (edge.midpoint - axis.place) for edge in own])
        clear = CLEAR * axis.radius
        sides = off[off > clear], off[off < -clear]
        places = [float(side[np.argmin(np.abs(side))]) for side in sides if len(side)]
        through = [k for k in range(len(own)) if any(abs(off[k] - place) < SAME * solid.size for place in places)]
        if places:
            yield (
                tuple(own[k].id for k in through),
                Cutter(
                    reason=f"planes beside {axis.label}, through inner edges and along it",
                    tools=tuple(plane_tool(solid, normal, axis.place + place * normal) for place in places),
                    weight=sum(own[k].length for k in through),
                    leads=any(_is_of_profile(solid, own[k]) for k in through),
                ),
            )


def _is_of_profile(solid: Solid, edge: Edge) -> bool:
    """Whether an edge runs from one end of the solid to the other, as those of an extruded profile do."""
    along = solid.vertices @ edge.tangents[0]
    return edge.length > (1.0 - SAME) * float(np.ptp(along))


def _normals(axis: Axis, inner: Sequence[Edge]) -> list[FloatArray]:
    """Unit vectors square to the hole and to inner edges that do not run along it."""
    found: list[FloatArray] = []
    for edge in inner:
        normal = np.cross(edge.tangents[0], axis.direction)
        length = float(np.linalg.norm(normal))
        if length < LEAST_TURN:
            continue
        normal /= length
        if not any(abs(float(normal @ other)) > 1.0 - ALONG for other in found):
            found.append(normal)
    return found


def _is_hole(solid: Solid, axis: Axis) -> bool:
    """Whether the cylinder is seen from inside."""
    face = solid.faces[min(axis.faces)]
    return is_hollow(face, solid.edges[face.edges[0]].midpoint, axis.place, axis.direction)


__all__ = ["beside_holes"]
