"""What a candidate sweep asks of the faces of its cell.

Place in the flow: :mod:`.search` chooses one :class:`Way` a cell so that every shared face has roles that agree.

Every face of a cell is one of three things:

grid
    A logical rectangle with four corners: a linking side, or a cap of a cell that is a logical box.
first
    On the cap where the cell's quads begin: it takes whatever quads it is given, and free ones where it is given none.
last
    On the cap where they are carried to: nobody else may mesh it.
star
    Not of four corners, on a cell that has a block at every corner: its quads meet in a star.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi
from typing import Literal

from ..brep import Face, Solid
from ..corner_blocks import CornerBlocks
from ..sweep import DirectedEdge, LinkingSide, Sweep, turned, turned_chain

Role = Literal["grid", "first", "last", "star"]
Fill = Sweep | CornerBlocks
"""How a cell is filled with hexahedra."""

CORNER = 5.0 * pi / 6.0
"""Interior angle of a face below which a vertex of its outline is a corner: half way to straight from 120 degrees."""
REENTRANT = 7.0 * pi / 6.0
"""Angle from which on an outline turns back: such a face is no logical rectangle."""
TANGENT = 1e-3
"""Radians from pi up to which the halves of a rounding run tangent into each other."""
BOXED = 1e-3
"""What a way whose caps are grids is preferred by: a structured cap is what a person would draw."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Way:
    """A candidate sweep in one direction, or blocks at the corners, and what that makes of the cell's faces.

    Attributes
    ----------
    fill : Sweep or CornerBlocks
        A sweep from the cap whose quads come first to the one they are carried to.
    roles : tuple of Role
        By face id of the cell.
    grids : dict of int to LinkingSide
        The logical rectangle of every face whose role is ``grid``, its chains in the cell's own edges.
    score : float
        The higher the better.
    """

    fill: Fill
    roles: tuple[Role, ...]
    grids: dict[int, LinkingSide]
    score: float


def list_ways(candidates: Sequence[Fill]) -> list[Way]:
    """All ways of the candidates of a cell, both directions of each sweep, best first."""
    ways = []
    for sweep in candidates:
        if isinstance(sweep, CornerBlocks):
            roles: list[Role] = ["grid" if face.id in sweep.grids else "star" for face in sweep.solid.faces]
            ways.append(Way(fill=sweep, roles=tuple(roles), grids=dict(sweep.grids), score=sweep.score))
            continue
        for one in (sweep, turned(sweep)):
            sides = {side.face: side for side in one.linking_sides}
            if one is sweep:
                boxed = box_caps(one)
                if boxed is not None:
                    ways.append(_way(one, sides | {cap.face: cap for cap in boxed}, one.score + BOXED))
            if len(one.target) == 1 or one.target_faces:
                ways.append(_way(one, sides, one.score))
    return sorted(ways, key=lambda way: -way.score)


def way_of(sweep: Sweep) -> Way:
    """The way of a cell that shares nothing: along its sweep, in the sweep's own direction."""
    return _way(sweep, {side.face: side for side in sweep.linking_sides}, sweep.score)


def _way(sweep: Sweep, grids: dict[int, LinkingSide], score: float) -> Way:
    roles: list[Role] = []
    for face in sweep.solid.faces:
        if face.id in grids:
            roles.append("grid")
        elif face.id in sweep.source:
            roles.append("first")
        else:
            roles.append("last")
    return Way(fill=sweep, roles=tuple(roles), grids=grids, score=score)


def box_caps(sweep: Sweep) -> tuple[LinkingSide, LinkingSide] | None:
    """Both caps as logical rectangles whose corners stand over each other; None where the cell is no logical box."""
    if len(sweep.source) != 1 or len(sweep.target) != 1 or len(sweep.source_loops) != 1 or sweep.stations:
        return None
    solid = sweep.solid
    source, target = solid.faces[sweep.source[0]], solid.faces[sweep.target[0]]
    corners = corners_of(solid, source)
    if corners is None or set(corners_of(solid, target) or ()) != {over(sweep, v) for v in corners}:
        return None
    a, b, c, d = split_at(solid, sweep.source_loops[0], corners)
    # Bottom times left points out of the solid, as on linking sides: on the source against the loop's direction.
    low = LinkingSide(face=source.id, bottom=turned_chain(d), right=turned_chain(c), top=tuple(b), left=tuple(a))
    a, b, c, d = split_at(solid, sweep.target_loops[0], [over(sweep, v) for v in corners])
    high = LinkingSide(face=target.id, bottom=tuple(a), right=tuple(b), top=turned_chain(c), left=turned_chain(d))
    return low, high


def corners_of(solid: Solid, face: Face) -> list[int] | None:
    """The four corner vertices of a face of one loop that turns nowhere else; None where it is no such rectangle.

    Where it turns at three, the place where a rounding is divided half way is the fourth.
    """
    if len(face.loops) != 1:
        return None
    loop = face.loops[0]
    outline = [(solid.first_vertex(edge), angle) for edge, angle in zip(loop.directed, loop.angles, strict=True)]
    corners = {v for v, angle in outline if angle < CORNER}
    if len(corners) == 3:
        corners |= _half_way(solid)
    found = [v for v, _ in outline if v in corners]
    return found if len(found) == 4 and max(loop.angles) < REENTRANT else None


def _half_way(solid: Solid) -> set[int]:
    """The ends of edges at which the halves of a rounding about an axis run tangent into each other."""
    return {
        v
        for edge in solid.edges
        if abs(edge.dihedral - pi) < TANGENT and all(solid.faces[f].kind == "torus" for f in edge.faces)
        for v in (edge.start, edge.end)
    }


def over(sweep: Sweep, vertex: int) -> int:
    """The vertex that the rails lead to from a vertex of the source; -1 where none leaves it."""
    rails = (rail for side in sweep.linking_sides for rail in (side.left, side.right))
    ahead = {sweep.solid.first_vertex(rail[0]): sweep.solid.last_vertex(rail[-1]) for rail in rails}
    found = vertex
    while found in ahead:  # sides may follow each other along the sweep
        found = ahead[found]
    return -1 if found == vertex else found


def split_at(solid: Solid, loop: Sequence[DirectedEdge], corners: Sequence[int]) -> list[list[DirectedEdge]]:
    """A loop cut at its corners, the first chain from the first corner that it meets."""
    at = [j for j, directed in enumerate(loop) if solid.first_vertex(directed) in corners]
    run = [*loop[at[0] :], *loop[: at[0]]]
    cuts = [j - at[0] for j in at] + [len(loop)]
    return [list(run[a:b]) for a, b in pairwise(cuts)]


def corner_vertices(solid: Solid, grid: LinkingSide) -> tuple[int, int, int, int]:
    """Vertices at the corners of a logical rectangle: bottom's begin and end, top's end and begin."""
    return (
        solid.first_vertex(grid.bottom[0]),
        solid.last_vertex(grid.bottom[-1]),
        solid.last_vertex(grid.top[-1]),
        solid.first_vertex(grid.top[0]),
    )
