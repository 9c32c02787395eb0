"""Cells whose corners have three edges each, as blocks at their corners.

Place in the flow: beside the sweeps of a cell; the plan takes one of these where no sweep agrees with the neighbours.

Not handled: corners with more edges (cut through them first), faces with holes or with less than three corners, and
edges where the cell is re-entrant or nearly flat: the hexahedra there would be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from math import pi, sin

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Solid
from ..corner_blocks import CornerBlocks, View
from ..sweep import DirectedEdge, LinkingSide, turned_chain

FLATTEST = 11.0 * pi / 12.0
"""Angle at a corner or an edge up to which hexahedra fit into it: at 165 degrees their scaled Jacobian is 0.26."""
SHARPEST = pi / 12.0
"""Angle from which on they do."""
STRAIGHT = 2.0 * pi / 3.0
"""Angle of a face from which on two edges that meet alone are one chain."""
SAMPLES = 7
"""Points of an edge that are looked at."""
SEEN = 0.01
"""Distance, as a share of its size, by which the middle of a solid or face must lie inside of all of its outline."""
TURNED = 0.4
"""Least cosine between the normals of a curved face and that of its middle at which it may be looked at along that."""
BENT = 0.2
"""Cosine between the normals of a prism's ends up to which it may be bent: somewhat more than a quarter of a turn."""
SCORE = 0.25
"""Of the best: below half of what a sweep of middling quality has."""


def find_corner_blocks(solid: Solid) -> CornerBlocks | None:
    """Read a solid as blocks at its corners; None where it is none of that kind, or a logical box.

    Parameters
    ----------
    solid : Solid
    """
    degrees = Counter(v for edge in solid.edges for v in (edge.start, edge.end))
    least = _least_sine(solid, degrees)
    corners = tuple(v for v in range(len(solid.vertices)) if degrees[v] == 3)
    found = None if least is None else _outlines(solid, frozenset(corners))
    if least is None or found is None:
        return None
    chains, outlines = found
    ends = tuple((_start(solid, chain[0]), _start(solid, _back(chain[-1]))) for chain in chains)
    around: dict[int, set[int]] = {corner: set() for corner in corners}
    beside: list[set[int]] = [set() for _ in chains]
    for number, outline in outlines.items():
        for chain, _ in outline:
            beside[chain].add(number)
            for corner in ends[chain]:
                around[corner].add(number)
    if any(len(faces) != 3 for faces in around.values()) or any(len(faces) != 2 for faces in beside):
        return None
    if all(len(outline) == 4 for outline in outlines.values()):
        return None  # a box has sweeps
    views = _views(solid)
    if views is None:
        return None
    return CornerBlocks(
        solid=solid,
        corners=corners,
        chains=tuple(chains),
        ends=ends,
        across=tuple(
            (_only(around[start] - own), _only(around[end] - own))
            for (start, end), own in zip(ends, beside, strict=True)
        ),
        outlines=outlines,
        grids={face: _grid(face, outline, chains) for face, outline in outlines.items() if len(outline) == 4},
        view=views[0],
        face_views=views[1],
        score=SCORE * least,
    )


def _least_sine(solid: Solid, degrees: Mapping[int, int]) -> float | None:
    """Least sine of a face's angle at a corner; None where some vertex, edge or face rules blocks out."""
    if any(len(face.loops) != 1 for face in solid.faces) or set(degrees.values()) - {2, 3}:
        return None
    if any(not SHARPEST < edge.dihedral < FLATTEST for edge in solid.edges):
        return None
    least = 1.0
    for face in solid.faces:
        for directed, angle in zip(face.loops[0].directed, face.loops[0].angles, strict=True):
            is_corner = degrees[_start(solid, directed)] == 3
            low, high = (SHARPEST, FLATTEST) if is_corner else (STRAIGHT, 2.0 * pi - STRAIGHT)
            if not low < angle < high:
                return None
            least = min(least, sin(angle)) if is_corner else least
    return least


def _views(solid: Solid) -> tuple[View, dict[int, View]] | None:
    """Where a solid sees all of its faces from inside, and each face all of its outline; None where one does not."""
    flat = all(face.kind == "plane" for face in solid.faces) and all(edge.kind == "line" for edge in solid.edges)
    if flat:  # and angles below pi: convex
        everywhere = View(normals=np.empty((0, 3)), offsets=np.empty(0))
        return everywhere, dict.fromkeys((face.id for face in solid.faces), everywhere)
    at = np.linspace(0.0, 1.0, SAMPLES)
    normals: list[FloatArray] = []
    places: list[FloatArray] = []
    views: dict[int, View] = {}
    for face in solid.faces:
        loop = face.loops[0].directed
        rows = [solid.edges[e].curve.evaluate(at)[:: 1 if ahead else -1] for e, ahead in loop]
        uv = np.concatenate([face.surface.edge_uv(e, at)[:: 1 if ahead else -1] for e, ahead in loop])
        view = _face_view(face, rows)
        if view is None:
            return None
        views[face.id] = view
        middle = face.surface.project(np.concatenate(rows).mean(axis=0)[None])
        places += [*rows, face.surface.evaluate(middle)]
        normals += [-face.surface.normals(uv), -face.surface.normals(middle)]
    whole = View.of(np.concatenate(places), np.concatenate(normals))
    own = whole if whole.depth() > SEEN * solid.size else _view_in_wedge(solid)
    return None if own is None else (own, views)


def _view_in_wedge(solid: Solid) -> View | None:
    """Where a bent prism of three sides sees the middles of its faces; None for any other solid.

    The ring under a counterbore, in quarters: from nowhere inside all of its inner wall is seen, yet every block lies
    along the bend between two walls, which are close to each other.
    """
    ends = [face for face in solid.faces if len(face.edges) == 3 and face.kind == "plane"]
    if len(solid.faces) != 5 or len(ends) != 2 or float(ends[0].normal @ ends[1].normal) > BENT:
        return None
    middles = [face.surface.project(face.center[None]) for face in solid.faces]
    places = [face.surface.evaluate(uv) for face, uv in zip(solid.faces, middles, strict=True)]
    normals = [-face.surface.normals(uv) for face, uv in zip(solid.faces, middles, strict=True)]
    view = View.of(np.concatenate(places), np.concatenate(normals))
    return view if view.depth() > SEEN * solid.size else None


def _face_view(face: Face, rows: Sequence[FloatArray]) -> View | None:
    """Where a face sees all of its outline, given in rows of points; None where it does not.

    A curved face is looked at along the normal of its middle; where the middle sees all, no other place is asked for.
    """
    points = np.concatenate(rows)
    uv = face.surface.project(points.mean(axis=0)[None])
    center, normal = face.surface.evaluate(uv)[0], face.surface.normals(uv)[0]
    least = SEEN * float(np.sqrt(face.area))
    steps = np.concatenate([np.diff(row, axis=0) for row in rows])
    aside = np.cross(normal, steps)
    lengths = np.linalg.norm(aside, axis=1)
    seen = lengths > 1e-9 * lengths.max()
    starts, aside = np.concatenate([row[:-1] for row in rows])[seen], aside[seen] / lengths[seen, None]
    if face.kind != "plane":
        if float(((center - starts) * aside).sum(axis=1).min()) > least:
            return View(normals=np.empty((0, 3)), offsets=np.empty(0))
        if float((face.surface.normals(face.surface.project(points)) @ normal).min()) < TURNED:
            return None
    view = View.of(starts, aside, plane=(normal, float(normal @ center)))
    return view if view.depth() > least else None


def _outlines(
    solid: Solid, corners: frozenset[int]
) -> tuple[list[tuple[DirectedEdge, ...]], dict[int, tuple[DirectedEdge, ...]]] | None:
    """The chains between corners, and every face's outline in chains; None where a face has less than three."""
    chains: list[tuple[DirectedEdge, ...]] = []
    known: dict[DirectedEdge, DirectedEdge] = {}
    outlines: dict[int, tuple[DirectedEdge, ...]] = {}
    for face in solid.faces:
        loop = face.loops[0].directed
        at = [j for j, directed in enumerate(loop) if _start(solid, directed) in corners]
        if len(at) < 3:
            return None
        outline: list[DirectedEdge] = []
        for j, first in enumerate(at):
            last = at[(j + 1) % len(at)]
            run = loop[first:last] if last > first else (*loop[first:], *loop[:last])
            if run[0] not in known:
                known[run[0]] = (len(chains), True)
                known[_back(run[-1])] = (len(chains), False)
                chains.append(tuple(run))
            outline.append(known[run[0]])
        outlines[face.id] = tuple(outline)
    return chains, outlines


def _grid(face: int, outline: tuple[DirectedEdge, ...], chains: list[tuple[DirectedEdge, ...]]) -> LinkingSide:
    """A face of four corners as a logical rectangle, its bottom times its left pointing out, as on sweeps."""
    a, b, c, d = (chains[chain] if forward else turned_chain(chains[chain]) for chain, forward in outline)
    return LinkingSide(face=face, bottom=a, right=b, top=turned_chain(c), left=turned_chain(d))


def _start(solid: Solid, directed: DirectedEdge) -> int:
    edge = solid.edges[directed[0]]
    return edge.start if directed[1] else edge.end


def _back(directed: DirectedEdge) -> DirectedEdge:
    return directed[0], not directed[1]


def _only(faces: set[int]) -> int:
    (face,) = faces
    return face
