"""Faces of a solid that are pieces of one face of the model, taken as one: a seam is no line that a mesh must have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import IntArray
from ..brep import Edge, Solid

_SEAM = 1e-3
"""Angle from pi, radians, up to which two pieces of one face run into each other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Merged:
    """The faces of a solid, those along seams united under the least id of them.

    Attributes
    ----------
    of_face : (n_faces,) int64
        The face that stands for each.
    edges : sequence of Edge
        All that are no seams.
    euler : dict of int to int
        Euler number of every united face.
    """

    of_face: IntArray
    edges: Sequence[Edge]
    euler: dict[int, int]

    def sides(self, edge: Edge) -> tuple[int, int]:
        """The united faces beside an edge, ascending."""
        low, high = sorted(int(self.of_face[face]) for face in edge.faces)
        return low, high


def merge_seams(solid: Solid) -> Merged:
    """Unite the faces of a solid along its seams."""
    of_face = np.arange(len(solid.faces))
    for edge in solid.edges:
        one, other = (solid.faces[face] for face in edge.faces)
        if one.key and one.key == other.key and abs(edge.dihedral - pi) < _SEAM:
            low, high = sorted(of_face[[one.id, other.id]].tolist())
            of_face[of_face == high] = low
    euler: dict[int, int] = {}
    for united in np.unique(of_face).tolist():
        own = [solid.faces[face] for face in np.flatnonzero(of_face == united)]
        edges = {edge for face in own for edge in face.edges}
        vertices = {vertex for edge in edges for vertex in (solid.edges[edge].start, solid.edges[edge].end)}
        euler[united] = len(vertices) - len(edges) + sum(2 - len(face.loops) for face in own)
    edges_left = [edge for edge in solid.edges if of_face[edge.faces[0]] != of_face[edge.faces[1]]]
    return Merged(of_face=of_face, edges=edges_left, euler=euler)
