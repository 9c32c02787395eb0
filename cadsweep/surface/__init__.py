"""The surface stage: ring nodes on edges and linking sides, quads on the source cap.

Place in the flow: after ``intervals``, before ``projection``. :func:`mesh_surfaces` is the entry for one sweep; a part
of several cells is meshed through a :class:`Skeleton`.

Method: the counts fix where every vertex stands in a grid of ring nodes times layers (``layout``);
edges divide themselves by layer places and by the affine image of the source loop (``spacing``);
linking sides are filled transfinitely in their parameters (``sides``, ``transfinite``); the source
cap gets quads on exactly the nodes of its loops (``quads``, with gmsh where it has no four sides).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ..arrays import FloatArray
from ..mesh import QuadMesh, SurfaceMesh
from ..sweep import Intervals, Sweep
from .background import limited as limited_sizes
from .cap_heights import keep_heights
from .chains import Chain, ChainPiece, chains_of, divided, say_chains, turned
from .grading import (
    Division,
    fractions_from,
    grade_places,
    graded_edges,
    graded_fractions,
    graded_together,
    turned_round,
)
from .matched import Motion, match_caps, match_sides
from .matching import match_quads
from .memory import Memory
from .opposite import opposite_angles
from .partners import Partners
from .quads import CapBuilder
from .sides import RingBuilder
from .skeleton import CellBoundary, FaceMesh, Skeleton, grid_quads, turn_grid
from .spacing import Fit, fit_linear_parts, place_layers
from .stars import lay_star, patches_of
from .sweep_grid import build_grid
from .target import divide_target_edges
from .thickness import thin_share
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
    "Skeleton",
    "Walls",
    "chains_of",
    "column_length",
    "divided",
    "fractions_from",
    "graded_fractions",
    "graded_together",
    "grid_quads",
    "lay_star",
    "limited_sizes",
    "match_quads",
    "mesh_surfaces",
    "patches_of",
    "say_chains",
    "turn_grid",
    "turned",
    "turned_round",
]

_THIN_SHARE = 0.2
"""Part of a cap's outline with one quad to the other side from which on the mesh's notes say so."""


def mesh_surfaces(
    sweep: Sweep,
    intervals: Intervals,
    *,
    bias: float | Sequence[float] | None = None,
    fractions: Sequence[float] | None = None,
    sizes: Callable[[FloatArray], FloatArray] | None = None,
    divisions: Mapping[int, Division] | None = None,
    alone: Mapping[int, Division] | None = None,
    walls: Walls | None = None,
    cap_heights: Mapping[bool, FloatArray] | None = None,
    matched: Sequence[tuple[frozenset[int], frozenset[int], Motion]] = (),
    matched_caps: Motion | None = None,
    fit: Fit = fit_linear_parts,
    memory: Memory | None = None,
) -> SurfaceMesh:
    """Mesh the boundary of a sweep: the source cap with quads, the linking sides layer by layer.

    Parameters
    ----------
    sweep : Sweep
    intervals : Intervals
        Segments of every edge; the sums on opposite sides of every linking face are equal.
    bias : float, (float, float) or None
        Grading of the layers within each span between stations: thickness of the last over the
        first, or a pair, of the middle over the first and over the last.
    fractions : (n_layers + 1,) or None
        Explicit places of the layers from 0 to 1, instead of `bias`.
    sizes : callable, optional
        Wanted lengths (m,) at points (m, 3) of the source cap, where they are below the intervals' size.
    divisions : mapping of int to callable, optional
        How edges divide themselves; those that answer them on rectangles follow, rails by the places of the layers.
    alone : mapping of int to callable, optional
        The same of edges that no other edge around the loops follows.
    walls : Walls, optional
        Edges of the source cap along which rows of quads are laid.
    cap_heights : mapping of bool to (n,) float64, optional
        Heights of the layers along the source (True) and the target, where these are walls.
    matched : sequence of (frozenset of int, frozenset of int, Motion)
        Sides whose nodes are to be the images of those of others: these, the ones that follow, and the motion.
    matched_caps : Motion, optional
        What carries the source to the target, where the last ring is to be the image of the first.
    fit : callable
        ``fit(source_ring (b, 3), rings (m, b, 3))``: linear parts (m, 3, 3) of the affine maps by
        which ring nodes follow the source loop.
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
    layout = build_grid(sweep, intervals)
    places = place_layers(sweep, layout, bias=bias, fractions=fractions)
    counts = dict(enumerate(intervals.counts.tolist()))
    asked = divided(divisions or {}, counts)
    graded = graded_edges(sweep, intervals, asked)
    own = divided(alone or {}, counts)
    asked, graded = {**asked, **own}, {**graded, **own}
    places = grade_places(layout, places, {e: asked[e] for e in asked if e in layout.edges})
    builder = RingBuilder(sweep, layout, places, fit, graded=graded, fixed=asked)
    builder.build()
    loops = [layout.columns(j, 0, n) for j, n in enumerate(layout.loop_sizes)]
    side_faces, node_edges, node_vertices = builder.labels()
    keep_heights(sweep, builder.rings, side_faces, node_edges, cap_heights or {})
    if matched_caps is not None:
        match_caps(builder.rings, matched_caps)
    for one, other, motion in matched:
        match_sides(layout, builder.rings, node_vertices, (one, other), motion)
    opposite = opposite_angles(sweep, node_vertices[[0, -1]])
    ring = builder.rings[0].copy()
    cap = CapBuilder(sweep, intervals, ring, loops, opposite, sizes=sizes, graded=graded, memory=memory, walls=walls)
    source = cap.build()
    return SurfaceMesh(
        source=source,
        rings=builder.rings,
        side_faces=side_faces,
        node_edges=node_edges,
        node_vertices=node_vertices,
        target_edge_points=divide_target_edges(sweep, source, cap.fractions, builder.rings, fit),
        notes=(*builder.notes, *cap.notes, *_thickness_notes(source, layout.n_layers)),
    )


def _thickness_notes(source: QuadMesh, n_layers: int) -> list[str]:
    """Say where the part has one hexahedron through a thickness, which is too stiff where it bends."""
    notes = []
    if n_layers == 1:
        notes.append("one layer of hexahedra from source to target: too stiff to bend, take layers=2 or more")
    share = thin_share(source.points, source.quads, source.loops)
    if share > _THIN_SHARE:
        notes.append(
            f"along {share:.0%} of the source's outline the wall is one hexahedron thick: too stiff to bend, "
            "take a smaller size"
        )
    return notes
