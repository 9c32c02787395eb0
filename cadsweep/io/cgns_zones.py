"""Which zones a CGNS file has, and what is in each: one for a mesh, or one a part where parts have interfaces.

Place in the flow: for :mod:`.cgns`, before it writes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import IntArray, distinct
from ..contacts import solids_of
from ..lattice import quad_lexicographic
from .labels import LabelledMesh

RESERVED = ("Zone", "GridCoordinates", "ZoneBC", "ZoneType", "UserData", "ZoneGridConnectivity", "Base")
"""Names of nodes that stand beside those of parts and boundaries."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ZonePiece:
    """The part of a mesh that is one zone.

    Attributes
    ----------
    name : str
        Of the zone.
    parts : dict of int to str
        Blocks of hexes in it, and what each is called.
    nodes : (n,) int64
        Its nodes, ascending.
    hexes : (m,) int64
    quads : (q,) int64
        Rows of the mesh's quads that are sides of its hexes.
    turned : (q,) bool
        Those that turn the other way than the zone sees them.
    contacts : dict of str to (str, str)
        Interfaces of the mesh that become connectivities, and their parts.
    is_part : bool
        Whether the mesh has other zones.
    """

    name: str
    parts: dict[int, str]
    nodes: IntArray
    hexes: IntArray
    quads: IntArray
    turned: np.ndarray
    contacts: dict[str, tuple[str, str]]
    is_part: bool

    def numbered(self, cells: IntArray) -> IntArray:
        """Cells (c, k) by the zone's own numbers of nodes; nonsense for those of other zones."""
        if not self.is_part:
            return cells
        return np.searchsorted(self.nodes, cells)


def zone_pieces(mesh: LabelledMesh) -> list[ZonePiece]:
    """The zones of a mesh."""
    names = mesh.volumes.exclusive_names()
    found = ((name, solids_of(name, names)) for name in mesh.faces.names)
    contacts = {name: solids for name, solids in found if solids is not None and name not in mesh.volumes.names}
    if not contacts or any(len(own) != 1 for own in mesh.volumes.members):
        rows = np.arange(len(mesh.quads))
        return [
            ZonePiece(
                name="Zone",
                parts=dict(enumerate(names)),
                nodes=np.arange(len(mesh.points)),
                hexes=np.arange(len(mesh.hexes)),
                quads=rows,
                turned=np.zeros(len(rows), dtype=bool),
                contacts={},
                is_part=False,
            )
        ]
    block_of = {name: block for block, name in enumerate(names)}
    first = mesh.volumes.of_cell[mesh.sides[0]]
    second = np.full(len(mesh.quads), -1, dtype=np.int64)
    for name, solids in contacts.items():
        second[mesh.faces.named(name)] = block_of[solids[1]]
    pieces = []
    for block, name in enumerate(names):
        ids = mesh.volumes.cells(block)
        rows = np.flatnonzero((first == block) | (second == block))
        pieces.append(
            ZonePiece(
                name=_free(name, {*mesh.faces.names, "Base"}),
                parts={block: name},
                nodes=distinct(mesh.hexes[ids]),
                hexes=ids,
                quads=rows,
                turned=second[rows] == block,
                contacts=contacts,
                is_part=True,
            )
        )
    return pieces


def turned_quads(quads: IntArray) -> IntArray:
    """Quads (q, 4, 8 or (p + 1)^2) that turn the other way: their two axes change places."""
    order = 2 if quads.shape[1] == 8 else int(quads.shape[1] ** 0.5) - 1
    numbers = quad_lexicographic(order)
    turned = np.empty_like(numbers)
    turned[numbers] = numbers.reshape(order + 1, order + 1).T.ravel()
    return quads[:, turned[: quads.shape[1]]]


def _free(name: str, taken: set[str]) -> str:
    """The name, changed where a family beside the zone has it."""
    found, count = name, 1
    while found in taken:
        count += 1
        found = f"{name[:24]}_{count}"
    return found
