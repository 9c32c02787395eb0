"""The surface stage: ring nodes on edges and linking sides, quads on the source cap.

Place in the flow: after ``intervals``, before ``projection``. Cells are meshed through a
:class:`Skeleton`, the plane of columns by :func:`mesh_surfaces`.

Method: the counts fix where every vertex stands in a grid of ring nodes times layers (``layout``);
edges divide themselves by layer places and by the affine image of the source loop (``spacing``);
linking sides are filled transfinitely in their parameters (``sides``, ``transfinite``); the source
cap gets quads on exactly the nodes of its loops (``quads``, with gmsh where it has no four sides).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ..arrays import FloatArray
from ..mesh import SurfaceMesh
from ..sweep import Intervals, Sweep
from .background import limited as limited_sizes
from .chains import Chain, ChainPiece, chains_of, divided, say_chains, turned
from .grading import (
    Division,
    fractions_from,
    graded_edges,
    graded_fractions,
    graded_together,
    turned_round,
)
from .matched import Motion, match_sides
from .matching import match_quads
from .memory import Memory
from .opposite import opposite_angles
from .partners import Partners
from .quads import CapBuilder
from .rings import Rings, lay_rings
from .skeleton import CellBoundary, FaceMesh, Skeleton, grid_quads, turn_grid
from .spacing import Fit, fit_linear_parts
from .stars import lay_star, patches_of
from .wall_columns import column_length
from .walls import Walls

__all__ = [
    "CellBoundary",
    "Chain",
    "ChainPiece",
    "Division",
    "FaceMesh",
    "Memory",
    "Motion",
    "Partners",
    "Rings",
    "Skeleton",
    "Walls",
    "chains_of",
    "column_length",
    "divided",
    "fractions_from",
    "graded_fractions",
    "graded_together",
    "grid_quads",
    "lay_rings",
    "lay_star",
    "limited_sizes",
    "match_quads",
    "mesh_surfaces",
    "opposite_angles",
    "patches_of",
    "say_chains",
    "turn_grid",
    "turned",
    "turned_round",
]


def mesh_surfaces(
    sweep: Sweep,
    intervals: Intervals,
    *,
    sizes: Callable[[FloatArray], FloatArray] | None = None,
    divisions: Mapping[int, Division] | None = None,
    alone: Mapping[int, Division] | None = None,
    walls: Walls | None = None,
    matched: Sequence[tuple[frozenset[int], frozenset[int], Motion]] = (),
    fit: Fit = fit_linear_parts,
    memory: Memory | None = None,
) -> SurfaceMesh:
    """Mesh the boundary of a sweep but for its target: the source cap with quads, the linking sides layer by layer.

    Parameters
    ----------
    sweep : Sweep
    intervals : Intervals
        Segments of every edge; the sums on opposite sides of every linking face are equal.
    sizes : callable, optional
        Wanted lengths (m,) at points (m, 3) of the source cap, where they are below the intervals' size.
    divisions : mapping of int to callable, optional
        How edges divide themselves; those that answer them on rectangles follow, rails by the places of the layers.
    alone : mapping of int to callable, optional
        The same of edges that no other edge around the loops follows.
    walls : Walls, optional
        Edges of the source cap along which rows of quads are laid.
    matched : sequence of (frozenset of int, frozenset of int, Motion)
        Sides whose nodes are to be the images of those of others: these, the ones that follow, and the motion.
    fit : callable
        As in :func:`~.rings.lay_rings`.
    memory : Memory, optional
        Faces of the source cap that were meshed before, with the same sweep, size and `sizes`; those meshed now are
        added.

    Returns
    -------
    SurfaceMesh
        Working units. Nodes on CAD vertices are these, bit for bit; nodes of the rings lie on their
        edges and faces.

    Raises
    ------
    SurfaceMeshError
        The counts do not fit together, or a face cannot be meshed; names the face.
    """
    counts = dict(enumerate(intervals.counts.tolist()))
    asked = divided(divisions or {}, counts)
    own = divided(alone or {}, counts)
    graded = {**graded_edges(sweep, intervals, asked), **own}
    rings = lay_rings(sweep, intervals, graded, {**asked, **own}, fit=fit)
    layout = rings.layout
    for one, other, motion in matched:
        match_sides(layout, rings.points, rings.node_vertices, (one, other), motion)
    ring = rings.points[0].copy()
    loops = [layout.columns(j, 0, n) for j, n in enumerate(layout.loop_sizes)]
    opposite = opposite_angles(sweep, rings.node_vertices[[0, -1]])
    around = {e for loop in sweep.target_loops for e, _ in loop}
    cap = CapBuilder(sweep, intervals, ring, loops, opposite, sizes=sizes, graded=graded, memory=memory, walls=walls)
    return SurfaceMesh(
        source=cap.build(),
        rings=rings.points,
        side_faces=rings.side_faces,
        node_edges=rings.node_edges,
        node_vertices=rings.node_vertices,
        target_edge_points={
            t: sweep.solid.edges[t].curve.evaluate(rings.fractions[t])
            for t, _ in sweep.target_edges.values()
            if t in rings.fractions and t not in around
        },
        notes=(*rings.notes, *cap.notes),
    )
