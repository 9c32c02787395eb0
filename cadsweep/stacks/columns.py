"""From an arrangement to a stack: the caps over every cell in order, and the sweep of the prism.

Place in the flow: third step of :mod:`cadsweep.stacks`, after ``cad`` has made the arrangement.
"""

from __future__ import annotations

import numpy as np

from ..brep import Solid
from ..errors import CadError
from ..stack import Arrangement, Stack
from ..sweep import DirectedEdge, LinkingSide, Sweep
from .along import heights_on_face
from .limits import find_limit, find_upright_limit
from .sides import Sides


def make_stack(solid: Solid, sides: Sides, stations: tuple[int, ...], arrangement: Arrangement) -> Stack:
    """Put the caps over every cell in order.

    Parameters
    ----------
    solid : Solid
    sides : Sides
    stations : tuple of int
        Edges between two walls that do not run along the direction.
    arrangement : Arrangement

    Raises
    ------
    CadError
        Caps do not alternate between entering and leaving the solid over a cell, or one covers no cell.
    """
    heights: list[dict[int, float]] = [{} for _ in arrangement.bottoms]
    under: dict[int, list[int]] = {}
    for c, caps in enumerate(arrangement.caps):
        for f in caps:
            under.setdefault(f, []).append(c)
    for f in sides.caps:
        cells = under.get(f)
        if not cells:
            raise CadError(
                f"{solid.faces[f].label()} is too narrow to be seen along the columns: leave it out of the model, or "
                "make it wider"
            )
        found = heights_on_face(solid.faces[f], sides.direction, arrangement.places[cells])
        for c, height in zip(cells, found.tolist(), strict=True):
            heights[c][f] = height
    columns = []
    for c, own in enumerate(heights):
        order = sorted(own, key=lambda f: own[f])
        if [sides.caps[f] for f in order] != [-1, 1] * (len(order) // 2):
            place = solid.units.place(arrangement.places[c])
            named = ", ".join(solid.faces[f].label() for f in order[:4]) or "none"
            raise CadError(
                f"the faces over ({place}), lowest first {named}, do not enter and leave the solid in turn: do two of "
                "them run into each other there? Repair the model in its CAD program"
            )
        columns.append(tuple(zip(order[::2], order[1::2], strict=True)))
    by_height = sorted(sides.caps, key=lambda f: float(solid.faces[f].center @ sides.direction))
    return Stack(
        solid=solid,
        direction=sides.direction,
        source=tuple(f for f in by_height if sides.caps[f] < 0),
        target=tuple(f for f in reversed(by_height) if sides.caps[f] > 0),
        walls=sides.walls,
        stations=stations,
        rounded=sides.rounded,
        arrangement=arrangement,
        plan=prism_sweep(arrangement, sides),
        columns=tuple(columns),
        score=_score(arrangement, sides),
        limit=find_limit(solid, sides),
        upright_limit=find_upright_limit(solid, sides, arrangement),
    )


def _score(arrangement: Arrangement, sides: Sides) -> float:
    """Worst scaled Jacobian to expect: as if the sharpest corner lay under the steepest cap."""
    faces = arrangement.prism.faces
    angles = [angle for f in arrangement.bottoms for loop in faces[f].loops for angle in loop.angles]
    sharpest = min([*angles, np.pi / 2])
    return float(np.sin(sharpest) * sides.steepest)


def prism_sweep(arrangement: Arrangement, sides: Sides) -> Sweep:
    """The sweep of an arrangement's prism from its bottom to its top."""
    solid = arrangement.prism
    top_edges = arrangement.top_edges
    caps = {*arrangement.bottoms, *arrangement.tops}
    linking = [_side(solid, f.id, top_edges) for f in solid.faces if f.id not in caps]
    ends: dict[int, tuple[int, DirectedEdge, LinkingSide]] = {}
    for side in linking:
        ((e, forward),) = side.bottom
        start, end = (solid.edges[e].start, solid.edges[e].end)[:: 1 if forward else -1]
        assert start not in ends, "no prism is made over a rim that touches itself"
        ends[start] = (end, (e, forward), side)
    loops: list[list[LinkingSide]] = []
    while ends:
        vertex = next(iter(ends))
        loop = []
        while vertex in ends:
            vertex, _, side = ends.pop(vertex)
            loop.append(side)
        loops.append(loop)
    # The outer loop has the greatest extent.
    loops.sort(key=lambda loop: -_extent(solid, loop))
    height = float(np.mean([solid.edges[side.left[0][0]].length for side in linking]))
    spans = tuple((tuple(sorted({e for side in loop for e, _ in side.left + side.right})),) for loop in loops)
    return Sweep(
        solid=solid,
        source=arrangement.bottoms,
        target=arrangement.tops,
        linking_sides=tuple(side for loop in loops for side in loop),
        source_loops=tuple(tuple(side.bottom[0] for side in loop) for loop in loops),
        target_loops=tuple(tuple(side.top[0] for side in loop) for loop in loops),
        rails=tuple(sorted({e for (span,) in spans for e in span})),
        spans=spans,
        span_lengths=tuple((height,) for _ in loops),
        target_faces=dict(zip(arrangement.bottoms, arrangement.tops, strict=True)),
        target_edges={e: (top, _same_way(solid, e, top, sides)) for e, top in top_edges.items()},
    )


def _side(solid: Solid, face: int, top_edges: dict[int, int]) -> LinkingSide:
    """A side of the prism: its own loop runs along the bottom, up, back along the top, and down."""
    directed = list(solid.faces[face].loops[0].directed)
    first = next(j for j, (e, _) in enumerate(directed) if e in top_edges)
    bottom, right, top, left = directed[first:] + directed[:first]
    return LinkingSide(
        face=face, bottom=(bottom,), right=(right,), top=((top[0], not top[1]),), left=((left[0], not left[1]),)
    )


def _extent(solid: Solid, loop: list[LinkingSide]) -> float:
    points = np.array([solid.edges[side.bottom[0][0]].midpoint for side in loop])
    corners = np.array([solid.vertices[solid.edges[side.bottom[0][0]].start] for side in loop])
    return float(np.linalg.norm(np.ptp(np.concatenate([points, corners]), axis=0)))


def _same_way(solid: Solid, bottom: int, top: int, sides: Sides) -> bool:
    """Whether two edges over each other start over each other."""
    start = solid.vertices[solid.edges[bottom].start]
    gaps = [solid.vertices[v] - start for v in (solid.edges[top].start, solid.edges[top].end)]
    off = [float(np.linalg.norm(gap - (gap @ sides.direction) * sides.direction)) for gap in gaps]
    return off[0] <= off[1]
