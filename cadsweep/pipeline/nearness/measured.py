"""How far the mesh of cells is off the CAD faces, face by face, and what its solids lose of volume and area.

Nodes lie on their faces, so a mesh is off where its quads sag: at the middles of their sides and their own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray
from ...blocks.cells import CellBlocks
from ...blocks.finish import by_face
from ...blocks.joined import JoinedMesh, neighbours_of
from ...blocks.naming import NamedFaces
from ...blocks.reference import make_references
from ...brep import Part
from ...options import SweepOptions
from ...quality import volume_and_area
from ...quality.deviation import quad_sags, side_sags
from ...quality.rims import is_rim, off_edges
from .nearer import COARSE, LOST_SIZED, MARGIN, coarse, is_loose, limit_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """How far a mesh is off what is asked for.

    Attributes
    ----------
    shortfall : float
        In limits: above 1 it is too far.
    needed : dict of (int, int) to float
        How many times finer the quads should be on faces that are too far off, by cell and face.
    sags : dict of (int, int) to float
        How far each curved face is off, working units, by cell and face.
    """

    shortfall: float
    needed: dict[tuple[int, int], float]
    sags: dict[tuple[int, int], float]

    def beyond(self, rounds: int) -> Found:
        """More than is asked for, after some rounds: a mesher answers in whole quads, here and there."""
        return replace(self, needed={place: needed * MARGIN**rounds for place, needed in self.needed.items()})

    @property
    def most_needed(self) -> float:
        """How many times finer quads should be where they are farthest off."""
        return max(self.needed.values())

    @property
    def distance(self) -> float:
        """How far any face is off, working units."""
        return max(self.sags.values(), default=0.0)


def keeps_shape(part: Part, joined: JoinedMesh | CellBlocks, options: SweepOptions) -> bool:
    """Whether a mesh of the size that is asked for is near enough as it is, no tolerance being asked for."""
    if options.tolerance is not None or options.size is None:
        return False
    return is_loose(options) or all(max(map(abs, lost)) <= LOST_SIZED for lost in _lost(part, joined).values())


def check_coarse_solids(part: Part, joined: JoinedMesh | CellBlocks, names: NamedFaces, options: SweepOptions) -> None:
    """Refuse a mesh of which a solid is another one; what is still to be curved or refined comes nearer.

    Raises
    ------
    CoarseMeshError
        Names the solid that is farthest off.
    """
    if is_loose(options):
        return
    worst, said = COARSE, ""
    several = len(part.models) > 1
    suspects = {owner: lost for owner, lost in _lost(part, joined).items() if max(map(abs, lost)) > COARSE}
    references = make_references(part, names) if suspects else {}
    for owner, (volume, area) in suspects.items():
        name = part.models[owner].name
        doubt = references[name].volume_doubt / (part.models[owner].volume * part.scale**3)
        off = max(abs(volume) - doubt, abs(area))
        if off > worst:
            who, alone = (f"of '{name}' ", f" (--size {name}=S gives it a size of its own)") if several else ("", "")
            worst = off
            said = f"the volume {who}is {volume:+.1%} off the CAD's and the area {area:+.1%}{alone}"
    if said:
        raise coarse(said)


def _lost(part: Part, joined: JoinedMesh | CellBlocks) -> dict[int, tuple[float, float]]:
    """By solid of the model: its mesh's volume and area over the CAD's, less one."""
    owners = np.array(part.owners, dtype=np.int64)
    on_cut = np.zeros((len(part.solids), max(len(solid.faces) for solid in part.solids)), dtype=np.bool_)
    for (cell, face), (other, _) in neighbours_of(part).items():
        on_cut[cell, face] = owners[other] == owners[cell]
    meshed = np.zeros_like(on_cut)
    meshed[joined.quad_cells, joined.quad_faces] = True
    exposed = meshed & ~on_cut
    areas = np.zeros(len(part.models))
    for cell, face in zip(*np.nonzero(exposed), strict=True):
        areas[owners[cell]] += part.solids[cell].faces[face].area
    found = {}
    own = owners[joined.quad_cells]
    order = np.argsort(own, kind="stable")
    starts = np.flatnonzero(np.diff(own[order], prepend=-1))
    for rows in np.split(order, starts[1:]) if len(order) else ():
        owner, quads = int(own[rows[0]]), joined.quads[rows]
        volume, area = volume_and_area(joined.points, quads)
        seen = exposed[joined.quad_cells[rows], joined.quad_faces[rows]]
        if not seen.all():  # the rest lies on cuts
            _, area = volume_and_area(joined.points, quads[seen])
        found[owner] = volume / part.models[owner].volume - 1.0, area / float(areas[owner]) - 1.0
    return found


def measure(part: Part, joined: JoinedMesh | CellBlocks, options: SweepOptions) -> Found:
    """How far a mesh is off what is asked for, and which faces are to blame."""
    off = _sags(part, joined)
    lost = _lost(part, joined) if options.tolerance is None else {}
    shortfall = 0.0
    needed: dict[tuple[int, int], float] = {}
    for (cell, face), sag in off.items():
        limit = limit_of(options, scale=part.scale, size=part.solids[cell].size)
        much = limit.shortfall(sag, *lost.get(part.owners[cell], ()))
        shortfall = max(shortfall, much)
        if much > 1.0:
            needed[cell, face] = float(np.sqrt(MARGIN * much))
    return Found(
        shortfall=shortfall,
        needed=needed,
        sags=off,
    )


def boundary_distance(
    part: Part, joined: JoinedMesh | CellBlocks, names: NamedFaces, found: Found | None = None
) -> float:
    """Greatest distance of the boundary's and the contacts' quads from their curved faces, working units.

    `found`: how far the mesh is off its faces, where that is known.
    """
    sags = _sags(part, joined) if found is None else found.sags
    return max((sag for place, sag in sags.items() if names.of(place)), default=0.0)


def _sags(part: Part, joined: JoinedMesh | CellBlocks) -> dict[tuple[int, int], float]:
    """How far the quads on every curved face, by cell and face, are off it."""
    found: dict[tuple[int, int], float] = {}
    for (cell, face), quads in by_face(joined):
        own = part.solids[cell].faces[face]
        if own.kind != "plane":
            sags = (
                side_sags(own, joined.points[quads[:, :4]])
                if joined.roles.get((cell, face)) == "side"
                else quad_sags(own.surface, joined.points[quads[:, :4]])
            )
            found[cell, face] = float(sags.max())
    beyond = neighbours_of(part)
    for cell, solid in enumerate(part.solids):
        segments = {}
        for edge in solid.edges:
            # What a cut ends at goes on beyond it, and is no rim of the part.
            own_nodes = joined.edge_nodes.get(int(solid.edge_keys[edge.id]))
            # One along columns that ends where nothing else does has no nodes of its own; it is straight.
            if own_nodes is not None and is_rim(edge) and not any((cell, face) in beyond for face in edge.faces):
                nodes = joined.points[own_nodes]
                segments[edge.id] = nodes[:-1], nodes[1:]
        for e, off in off_edges(solid, segments).items():
            for place in ((cell, face) for face in solid.edges[e].faces):
                if place in found:
                    found[place] = max(found[place], off)
    return found


def quads_off(part: Part, joined: JoinedMesh, limit: float) -> tuple[FloatArray, FloatArray]:
    """Middles (n, 3) of the boundary's quads that are off their curved faces, and lengths (n,) at which they would not.

    Chords are off as the squares of their lengths.
    """
    places, lengths = [np.zeros((0, 3))], [np.zeros(0)]
    for (cell, face), quads in by_face(joined):
        own = part.solids[cell].faces[face]
        if own.kind != "plane":
            corners = joined.points[quads[:, :4]]
            sags = quad_sags(own.surface, corners)
            off = sags > limit
            longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
            places.append(corners[off].mean(axis=1))
            lengths.append(longest[off] * np.sqrt(limit / sags[off]))
    return np.concatenate(places), np.concatenate(lengths)


def edge_sag(part: Part, joined: JoinedMesh | CellBlocks, cell: int, edge: int) -> float:
    """Greatest distance of the middles of an edge's segments from it."""
    solid = part.solids[cell]
    if solid.edges[edge].kind == "line":
        return 0.0
    nodes = joined.points[joined.edge_nodes[int(solid.edge_keys[edge])]]
    return float(np.max(solid.edges[edge].curve.distance((nodes[1:] + nodes[:-1]) / 2)))
