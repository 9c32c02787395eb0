"""The mesh of one sweep seen as that of a part of one cell.

Place in the flow: ``pipeline`` makes the :class:`~.entities.Entities` of a sweep of it, when somebody asks for them.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.block import FactoredMesh
from ..blocks.joined import JoinedMesh
from ..blocks.naming import name_sweep
from ..brep import Part
from ..cells import SweptStructure, sweep_hexes
from ..mesh import SurfaceMesh
from ..segments import segments_by_edge
from ..sweep import Sweep
from .entities import Entities


def sweep_entities(part: Part, sweep: Sweep, surfaces: SurfaceMesh, factored: FactoredMesh) -> Entities:
    """Where the nodes of a sweep's mesh are, numbered as there: layer by layer."""
    structure = factored.structure
    n, n_layers = structure.n_nodes, structure.n_layers
    points = factored.working_points()
    joined = JoinedMesh(
        points=points,
        hexes=sweep_hexes(structure.quads, n, n_layers, periodic=structure.periodic),
        hex_cells=np.zeros(n_layers * len(structure.quads), dtype=np.int64),
        quads=sweep_quads(structure),
        quad_cells=np.zeros(2 * len(structure.quads) + surfaces.side_faces.size, dtype=np.int64),
        quad_faces=np.concatenate([surfaces.source.faces, target_faces(sweep, surfaces), surfaces.side_faces.ravel()]),
        edge_nodes=_chains(sweep, surfaces, points),
    )
    return Entities(part=part, joined=joined, names=name_sweep(sweep))


def sweep_quads(structure: SweptStructure) -> IntArray:
    """Quads of source, target and sides, outward; the last layer of a closed ring is its first."""
    n, n_layers = structure.n_nodes, structure.n_layers
    ring = np.concatenate(structure.loops)
    following = np.concatenate([np.roll(loop, -1) for loop in structure.loops])
    low = np.arange(n_layers)[:, None] * n
    sides = np.stack([ring + low, following + low, following + low + n, ring + low + n], axis=-1).reshape(-1, 4)
    quads = np.concatenate([structure.quads[:, ::-1], structure.quads + n_layers * n, sides])
    return quads % (n_layers * n) if structure.periodic else quads


def target_faces(sweep: Sweep, surfaces: SurfaceMesh) -> IntArray:
    """Face (q,) of every quad of the target cap."""
    found = np.full(len(surfaces.source.quads), sweep.target[0], dtype=np.int64)
    if len(sweep.target) > 1:
        for face, there in sweep.target_faces.items():
            found[surfaces.source.faces == face] = there
    return found


def _chains(sweep: Sweep, surfaces: SurfaceMesh, points: FloatArray) -> dict[int, IntArray]:
    """Nodes along every edge, by key, from its start to its end."""
    solid = sweep.solid
    vertices = _vertices(sweep, surfaces)
    chains = {}
    for edge, segments in segments_by_edge(sweep, surfaces).items():
        start, end = vertices[solid.edges[edge].start], vertices[solid.edges[edge].end]
        inside = np.setdiff1d(segments, [start, end]) % len(points)
        at = solid.edges[edge].curve.project(points[inside])
        chain = [start, *inside[np.argsort(at, kind="stable")].tolist(), end]
        chains[int(solid.edge_keys[edge])] = np.array(chain, dtype=np.int64) % len(points)
    return chains


def _vertices(sweep: Sweep, surfaces: SurfaceMesh) -> dict[int, int]:
    """Node on every vertex; the last layer of a closed ring has numbers of its own."""
    source, n = surfaces.source, len(surfaces.source.points)
    last = (len(surfaces.rings) - 1) * n
    nodes = np.arange(len(surfaces.rings))[:, None] * n + np.concatenate(source.loops)
    on = surfaces.node_vertices >= 0
    found = dict(zip(surfaces.node_vertices[on].tolist(), nodes[on].tolist(), strict=True))
    for edge, chain in source.edge_nodes.items():
        ends = chain[[0, -1]].tolist()
        found |= dict(zip(_ends(sweep, edge), ends, strict=True))
        there, forward = sweep.target_edges.get(edge, (-1, True))
        if there in surfaces.target_edge_points:
            beyond = [end + last for end in ends[:: 1 if forward else -1]]
            found |= dict(zip(_ends(sweep, there), beyond, strict=True))
    return found


def _ends(sweep: Sweep, edge: int) -> tuple[int, int]:
    return sweep.solid.edges[edge].start, sweep.solid.edges[edge].end
