"""Where every node of a finished mesh is in the CAD model: on a vertex, an edge or a face of it, or inside a cell.

Place in the flow: after a mesh is made, whatever it is made of. One sweep (:mod:`.swept`), columns and cells all give
an :class:`Entities`; refinement, orders above 1, ``like``, periodic pairs ask it and nothing else.

What it promises, of every mesh:

- Nodes are numbered as those of the mesh of order 1, in working units.
- Every edge of every cell has its chain: nodes from its start to its end, rising along its curve. The ends are the
  nodes of its vertices, those between are on its curve and on no other edge's.
- Every vertex has one node, and no two vertices one node, but for a ring that was cut open (below).
- Every face of every cell has its quads, outward from the cell; a face between two cells has them in both. All their
  nodes are on the face, or on edges and vertices of its border.
- A node that is on none of these is inside a cell.
- Of a ring that was cut open to be swept the two sides of the cut are two faces with the same nodes, and what borders
  them twice there: a node there has the key of the lower one.

Keys are those of ``Solid.vertex_keys``, ``edge_keys`` and ``face_keys`` of ``part``, the model as it was meshed: its
cells. Equal keys in two cells mean the same vertex, edge or face. Of these, cuts are faces inside a solid of the model;
:meth:`Entities.is_outside` tells them from the model's own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.finish import by_face
from ..blocks.joined import JoinedMesh
from ..blocks.naming import NamedFaces, Place
from ..brep import Curve, Edge, Face, Part, Surface

VERTEX, EDGE, FACE, CELL = range(4)
"""Dimensions of what a node may be in."""

Projection = Callable[[FloatArray], FloatArray]
"""Takes points (m, 3) near a curve or surface, model units, and returns points (m, 3) on it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Entities:
    """The mesh of a part, by the part's vertices, edges, faces and cells.

    Attributes
    ----------
    part : Part
        As it was meshed: its cells.
    joined : JoinedMesh
        Nodes, hexahedra and quads, each with its cell or face, and the chains of all edges.
    names : NamedFaces
        Of the faces that are no cuts.
    """

    part: Part
    joined: JoinedMesh
    names: NamedFaces

    @property
    def points(self) -> FloatArray:
        """Nodes (n, 3), working units."""
        return self.joined.points

    @property
    def chains(self) -> dict[int, IntArray]:
        """Nodes along every edge, by key, from its start to its end."""
        return self.joined.edge_nodes

    @cached_property
    def edges(self) -> dict[int, Edge]:
        """Edges by key; of several cells the first one's."""
        found: dict[int, Edge] = {}
        for solid in self.part.solids:
            for key, edge in zip(solid.edge_keys.tolist(), solid.edges, strict=True):
                found.setdefault(key, edge)
        return found

    @cached_property
    def vertices(self) -> dict[int, int]:
        """Node of every vertex, by key."""
        found: dict[int, int] = {}
        for solid in self.part.solids:
            for key, edge in zip(solid.edge_keys.tolist(), solid.edges, strict=True):
                if key in self.chains:
                    chain = self.chains[key]
                    found.setdefault(int(solid.vertex_keys[edge.start]), int(chain[0]))
                    found.setdefault(int(solid.vertex_keys[edge.end]), int(chain[-1]))
        return found

    @cached_property
    def faces(self) -> dict[Place, IntArray]:
        """Quads (q, 4) of every face of every cell, outward from the cell."""
        return dict(by_face(self.joined))

    def face(self, place: Place) -> Face:
        """A face of a cell."""
        return self.part.solids[place[0]].faces[place[1]]

    def is_outside(self, place: Place) -> bool:
        """Whether a face is one of the model, or between two of its solids, and no cut."""
        return bool(self.names.of(place))

    @cached_property
    def where(self) -> tuple[IntArray, IntArray]:
        """Dimension (n,) of what every node is in, 0 to 3, and its key (n,); of dimension 3 the number of a cell."""
        n = len(self.points)
        dimensions, keys = np.full(n, CELL, dtype=np.int64), np.zeros(n, dtype=np.int64)
        keys[self.joined.hexes] = self.joined.hex_cells[:, None]
        for (cell, face), quads in self.faces.items():
            dimensions[quads], keys[quads] = FACE, self.part.solids[cell].face_keys[face]
        for key, chain in sorted(self.chains.items(), reverse=True):
            dimensions[chain], keys[chain] = EDGE, key
        for key, node in sorted(self.vertices.items(), reverse=True):
            dimensions[node], keys[node] = VERTEX, key
        return dimensions, keys

    def on_curves(self) -> list[tuple[IntArray, Projection | None]]:
        """Segments (s, 2) along every edge of the model, and what brings points onto it; None where it is straight.

        Where a cut ends on a face of the model there is no edge: the nodes are on the face, and may have moved on it.
        Where a face meets itself there is one: of faces that blends join.
        """
        faces: dict[int, set[object]] = {}
        for place in self.faces:
            if self.is_outside(place):
                solid, own = self.part.solids[place[0]], self._own(place)
                for key in solid.edge_keys[list(solid.faces[place[1]].edges)].tolist():
                    faces.setdefault(key, set()).add(own)
        return [
            (
                np.column_stack([chain[:-1], chain[1:]]),
                None if self.edges[key].kind == "line" else onto_curve(self.part, self.edges[key].curve),
            )
            for key, chain in self.chains.items()
            if len(faces.get(key, ())) > 1 or len(set(self.edges[key].faces)) == 1
        ]

    def on_surfaces(self) -> list[tuple[IntArray, Projection | None]]:
        """Quads (q, 4) of every face of the model, of a contact once, and what brings points onto it; None: plane.

        Pieces of one plane face of the model are one.
        """
        planes: dict[object, list[IntArray]] = {}
        found: list[tuple[IntArray, Projection | None]] = []
        for place, quads in self.faces.items():
            if not self.is_outside(place) or not self.names.first.get(place, True):
                continue  # of an interface one side is enough; a cut is inside, and its middles are free
            face = self.face(place)
            if face.kind == "plane" and not face.tips:
                planes.setdefault(self._own(place), []).append(quads)
            else:
                found.append((quads, onto_surface(self.part, face.surface)))
        return [*found, *((np.concatenate(pieces), None) for pieces in planes.values())]

    def _own(self, place: Place) -> object:
        """What the pieces of one face of the model have in common."""
        return (self.part.owners[place[0]], self.face(place).key or place, place in self.names.between)


def onto_curve(part: Part, curve: Curve) -> Projection:
    """What brings points in model units onto a curve in working units."""

    def project(points: FloatArray) -> FloatArray:
        return part.to_model(curve.evaluate(curve.project((points - part.offset) / part.scale)))

    return project


def onto_surface(part: Part, surface: Surface) -> Projection:
    """What brings points in model units onto a surface in working units."""

    def project(points: FloatArray) -> FloatArray:
        return part.to_model(surface.evaluate(surface.project((points - part.offset) / part.scale)))

    return project
