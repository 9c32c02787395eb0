"""A mesh of several cells in one numbering: hexahedra, whose they are, and which face every boundary quad lies on.

Place in the flow: ``pipeline`` makes it, from blocks that were meshed on one skeleton (so that shared nodes have one
number from the beginning) or from a stack; :mod:`.finish` gives it names and turns it into a
:class:`~cadsweep.mesh.HexMesh`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ..arrays import FloatArray, IntArray
from ..brep import Part
from ..cells import BlockStructure, SweptStructure


@dataclass(frozen=True, kw_only=True, eq=False)
class JoinedMesh:
    """Hexahedra of the cells of a part.

    Attributes
    ----------
    points : (n, 3) float64
        Working units.
    hexes : (m, 8) int64
    hex_cells : (m,) int64
        Cell of every hexahedron.
    quads : (q, 4) int64
        Boundary of every cell, outward from it: a quad between two cells stands here twice, once a cell.
    quad_cells, quad_faces : (q,) int64
        The cell, and its own id of the face.
    roles : mapping of (cell, face), or (cell, face, patch of it), to str
        ``"source"``, ``"target"`` or ``"side"``: what unnamed boundaries are called by.
    edge_nodes : mapping of edge key to (k,) int64
        Nodes along every edge of the cells, from its start to its end.
    blocks : tuple of BlockStructure
        Which of the hexahedra are layers of quads, in their order, where that is known.
    structure : SweptStructure or None
        Where they are the layers of one sweep.
    columns : tuple of int
        How many hexahedra every column of a stack has, one column after the other.
    """

    points: FloatArray
    hexes: IntArray
    hex_cells: IntArray
    quads: IntArray
    quad_cells: IntArray
    quad_faces: IntArray
    roles: Mapping[Any, str] = field(default_factory=dict)
    edge_nodes: dict[int, IntArray] = field(default_factory=dict)
    blocks: tuple[BlockStructure, ...] = ()
    structure: SweptStructure | None = None
    columns: tuple[int, ...] = ()

    @property
    def n_hexes(self) -> int:
        """Hexahedra of all cells."""
        return len(self.hexes)

    def moved(self, points: FloatArray) -> JoinedMesh:
        """The same mesh with its nodes elsewhere."""
        return replace(self, points=points)


def neighbours_of(part: Part) -> dict[tuple[int, int], tuple[int, int]]:
    """The cell and face on the other side of every face that two cells share."""
    users: dict[int, list[tuple[int, int]]] = {}
    for cell, solid in enumerate(part.solids):
        for face, key in enumerate(solid.face_keys.tolist()):
            users.setdefault(key, []).append((cell, face))
    pairs = [own for own in users.values() if len(own) == 2]
    return {one: other for pair in pairs for one, other in (pair, pair[::-1])}
