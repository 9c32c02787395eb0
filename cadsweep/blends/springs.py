"""Where a face springs from its neighbour: tangent edges, and how much each side bends across them.

Place in the flow: what :mod:`.finding` knows of a solid.

Method: the curvature of a face across an edge, from its normals a short way inside. Pieces of one rounding bend alike
on both sides of the edge between them and are taken together; a rounding bends more than what it springs from.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Solid
from ..disjoint import DisjointSets

TANGENT = 0.05
"""Largest angle between faces, radians, at an edge that is smooth."""
FRACTIONS = np.array([0.02, 0.25, 0.5, 0.75, 0.98])
"""Where an edge is sampled, as shares of its length: not at its very ends, where patches may come to a point."""
_STEP = 1e-3
"""How far inside a normal is taken, as a share of the edge: curvature is off by as much of itself."""
_ALIKE = 0.05
"""Curvatures that differ by a smaller share of the larger are of one rounding."""
_MORE = 1.2
"""A rounding bends this many times as much as what it springs from."""
_FLAT = 0.02
"""Curvature, times the solid's size, below which a face is flat: a radius of fifty solids."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Side:
    """One face at one of its edges, sampled at :data:`FRACTIONS`.

    Attributes
    ----------
    points, normals, inward : (m, 3) float64
        Places on the edge; unit normals of the face, out of the solid; unit directions in the face, away from the edge.
    bends : (m,) float64
        Curvature of the face across the edge, one over length: positive where the solid is convex.
    """

    points: FloatArray
    normals: FloatArray
    inward: FloatArray
    bends: FloatArray

    @property
    def bend(self) -> float:
        """The middle one of the curvatures."""
        return float(np.median(self.bends))


@dataclass(frozen=True, kw_only=True, eq=False)
class Springs:
    """Smooth edges of a solid, and the groups of faces that bend as one.

    Attributes
    ----------
    sides : dict
        (edge id, face id) to what is there, of the smooth edges alone.
    group_of : list of int
        For every face the smallest id of its group.
    """

    solid: Solid
    sides: dict[tuple[int, int], Side]
    group_of: list[int]

    def borders(self, group: int) -> dict[int, tuple[int, int]]:
        """Edges of a group with other groups: the edge's id to the faces ``(inside, outside)``."""
        found = {}
        for edge in self.solid.edges:
            own = [self.group_of[f] == group for f in edge.faces]
            if own[0] != own[1]:
                found[edge.id] = edge.faces if own[0] else (edge.faces[1], edge.faces[0])
        return found

    def springs(self, edge: int, inside: int, outside: int) -> bool:
        """Whether the inside face is a rounding that ends at this edge, as far as its curvature says."""
        if (edge, inside) not in self.sides:
            return False
        ours, theirs = self.sides[edge, inside].bend, self.sides[edge, outside].bend
        return abs(ours) > _MORE * abs(theirs) + _FLAT / self.solid.size


def find_springs(solid: Solid) -> Springs:
    """Measure a solid's smooth edges, and put together the faces that are pieces of one rounding."""
    sides = {}
    for face in solid.faces:
        for loop in face.loops:
            for e, forward in loop.directed:
                if abs(solid.edges[e].dihedral - pi) < TANGENT:
                    sides[e, face.id] = _measured(solid, face, e, forward=forward)
    sets = DisjointSets(range(len(solid.faces)))
    for edge in solid.edges:
        first, second = edge.faces
        if (edge.id, first) in sides and _one_rounding(
            solid, edge.faces, sides[edge.id, first], sides[edge.id, second]
        ):
            low, high = sorted((sets.find(first), sets.find(second)))
            sets.merge(high, low)
    return Springs(solid=solid, sides=sides, group_of=[sets.find(face.id) for face in solid.faces])


def joined(solid: Solid, edges: list[int]) -> list[list[int]]:
    """Runs of edges that hang together at vertices."""
    at: dict[int, list[int]] = defaultdict(list)
    for e in edges:
        for vertex in {solid.edges[e].start, solid.edges[e].end}:
            at[vertex].append(e)
    left, runs = set(edges), []
    while left:
        waiting, run = [min(left)], set[int]()
        while waiting:
            e = waiting.pop()
            if e not in run:
                run.add(e)
                waiting += [*at[solid.edges[e].start], *at[solid.edges[e].end]]
        left -= run
        runs.append(sorted(run))
    return runs


def _measured(solid: Solid, face: Face, edge: int, *, forward: bool) -> Side:
    curve = solid.edges[edge].curve
    uv = face.surface.edge_uv(edge, FRACTIONS)
    normals = face.surface.normals(uv)
    ahead = curve.evaluate(FRACTIONS + _STEP) - curve.evaluate(FRACTIONS - _STEP)
    ahead *= (1.0 if forward else -1.0) / np.linalg.norm(ahead, axis=1, keepdims=True)
    inward = np.cross(normals, ahead)  # material is on the left
    by_u, by_v = face.surface.derivatives(uv)
    step = _STEP * solid.edges[edge].length
    along = np.array([
        np.linalg.lstsq(np.column_stack([u, v]), step * b, rcond=None)[0]
        for u, v, b in zip(by_u, by_v, inward, strict=True)
    ])  # fmt: skip
    turned = face.surface.normals(uv + along) - normals
    bends = np.einsum("ij,ij->i", turned, inward) / step
    return Side(points=curve.evaluate(FRACTIONS), normals=normals, inward=inward, bends=bends)


def _one_rounding(solid: Solid, faces: tuple[int, int], first: Side, second: Side) -> bool:
    if solid.faces[faces[0]].key and solid.faces[faces[0]].key == solid.faces[faces[1]].key:
        return True
    most = max(abs(first.bend), abs(second.bend))
    return most > _FLAT / solid.size and abs(first.bend - second.bend) < _ALIKE * most


__all__ = ["FRACTIONS", "TANGENT", "Side", "Springs", "find_springs", "joined"]
