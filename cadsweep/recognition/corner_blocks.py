"""Cells whose corners have three edges each, as blocks at their corners.

Place in the flow: beside the sweeps of a cell; the plan takes one of these where no sweep agrees with the neighbours.

Not handled: corners with more edges (cut through them first), faces with holes or with less than three corners, and
edges where the cell is re-entrant or nearly flat: the hexahedra there would be.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from math import pi, sin

from ..brep import Solid
from ..corner_blocks import CornerBlocks
from ..sweep import DirectedEdge, LinkingSide, turned_chain

FLATTEST = 11.0 * pi / 12.0
"""Angle at a corner or an edge up to which hexahedra fit into it: at 165 degrees their scaled Jacobian is 0.26."""
SHARPEST = pi / 12.0
"""Angle from which on they do."""
STRAIGHT = 2.0 * pi / 3.0
"""Angle of a face from which on two edges that meet alone are one chain."""
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
