"""The boundary of a cell, as far as it is known before its inside is placed: what projection takes.

Place in the flow: after the sides and the source cap of a cell are meshed on the :class:`~.skeleton.Skeleton`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import IntArray
from ..mesh import QuadMesh, SurfaceMesh
from ..sweep import Intervals, Sweep
from .opposite import opposite_angles
from .rings import lay_rings
from .skeleton import Skeleton
from .sweep_grid import SweepGrid, build_grid


@dataclass(frozen=True, kw_only=True, eq=False)
class CellBoundary:
    """The boundary of a cell as far as it is known before its inside is placed.

    Attributes
    ----------
    layout : SweepGrid
    rings : (n_layers + 1, b) int64
        Nodes of every layer's ring, numbers of the whole part.
    source : QuadMesh
        In local numbers: the ring comes first.
    nodes : (n,) int64
        The number in the whole part of every source node.
    """

    layout: SweepGrid
    rings: IntArray
    source: QuadMesh
    nodes: IntArray


def mesh_boundary(sweep: Sweep, counts: Intervals) -> SurfaceMesh:
    """Mesh the source and the linking sides of one sweep that stands alone.

    Raises
    ------
    SurfaceMeshError
        The counts do not fit together, or a face cannot be meshed with them.
    """
    rings = lay_rings(sweep, counts, {}, {})
    skeleton = Skeleton([sweep.solid], [counts], rings={0: rings})
    for side in sweep.linking_sides:
        skeleton.lay_grid(0, side)
    skeleton.lay_source(0, sweep, opposite_angles(sweep, rings.layout.labels()[2][[0, -1]]))
    return surface_mesh(boundary_of(skeleton, 0, sweep), skeleton, 0, sweep)


def boundary_of(skeleton: Skeleton, cell: int, sweep: Sweep) -> CellBoundary:
    """Collect the rings and the source cap of a cell, whose sides and source faces are meshed.

    Raises
    ------
    SurfaceMeshError
        The counts do not fit together.
    """
    layout = build_grid(sweep, skeleton.intervals[cell])
    rings = np.full((layout.n_layers + 1, layout.n_ring), -1, dtype=np.int64)
    keys = skeleton.solids[cell].edge_keys
    for placed in layout.edges.values():
        own = skeleton.edges[int(keys[placed.edge])]
        rings[layout.nodes(placed)] = own if placed.forward else own[::-1]
    for side in layout.sides:
        rings[layout.block(side)] = skeleton.grid_of(cell, side.side)
    assert (rings >= 0).all(), "the sides tile the rings"
    quads = [skeleton.quads_of(cell, f)[:, ::-1] for f in sweep.source]
    faces = np.repeat(np.array(sweep.source, dtype=np.int64), [len(q) for q in quads])
    every = np.concatenate(quads)
    inside = np.setdiff1d(every, rings[0])
    nodes = np.concatenate([rings[0], inside])
    loops = [layout.columns(j, 0, n) for j, n in enumerate(layout.loop_sizes)]
    order = np.argsort(nodes, kind="stable")

    def local_of(ids: IntArray) -> IntArray:
        return order[np.searchsorted(nodes, ids, sorter=order)]

    number = dict(zip(nodes.tolist(), range(len(nodes)), strict=True))
    edge_nodes = {
        e: np.array([number[v] for v in skeleton.edges[int(keys[e])].tolist()], dtype=np.int64)
        for f in sweep.source
        for e in skeleton.solids[cell].faces[f].edges
    }
    source = QuadMesh(
        points=skeleton.points[nodes],
        quads=local_of(every),
        faces=faces,
        loops=tuple(loops),
        edge_nodes=edge_nodes,
        walls=tuple(
            replace(rows, ring=local_of(rows.ring), nodes=local_of(rows.nodes)) for rows in skeleton.rows.get(cell, ())
        ),
    )
    return CellBoundary(layout=layout, rings=rings, source=source, nodes=nodes)


def surface_mesh(boundary: CellBoundary, skeleton: Skeleton, cell: int, sweep: Sweep) -> SurfaceMesh:
    """The cell's boundary as projection takes it."""
    layout, source = boundary.layout, boundary.source
    keys = sweep.solid.edge_keys
    points = skeleton.points
    on_loops = {edge for loop in sweep.source_loops for edge, _ in loop}
    inner = {
        target: points[skeleton.edges[int(keys[target])]]
        for edge, (target, _) in sweep.target_edges.items()
        if edge in source.edge_nodes and edge not in on_loops
    }
    side_faces, node_edges, node_vertices = layout.labels()
    return SurfaceMesh(
        source=source,
        rings=points[boundary.rings],
        side_faces=side_faces,
        node_edges=node_edges,
        node_vertices=node_vertices,
        target_edge_points=inner,
    )
