"""From a layout to a :class:`~cadsweep.sweep.Sweep`: loops, sides, rails, stations in order.

Place in the flow: fourth step of :mod:`cadsweep.recognition`. Directions follow the conventions of
:class:`~cadsweep.sweep.Sweep` and :class:`~cadsweep.sweep.LinkingSide`; faces are oriented
outward, so the bottom of a linking side in the face's own direction runs along the source loop.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from ..brep import Face, Solid
from ..errors import NotSweepableError
from ..sweep import DirectedEdge, LinkingSide, Sweep
from .bands import Band
from .layout import Layout
from .match import match_caps, why_unmatched

MAX_RIM = 10 * pi / 9
"""Interior angle between a cap and its linking sides beyond which no hex fits."""
MAX_FOLD = pi / 3
"""Radians from pi beyond which an inner edge of a cap is a fold that the other cap must answer."""
FLAT = 1e-3
"""Radians from pi up to which two planes or two lines are one: a hexahedron between them has no volume at its corner,
its scaled Jacobian is below this figure. Curved faces that are tangent leave facets an angle."""


def build_sweep(solid: Solid, layout: Layout, *, reverse: bool = False) -> Sweep:
    """Return the sweep of a layout.

    Parameters
    ----------
    solid : Solid
    layout : Layout
    reverse : bool
        Take the second cap for the source.

    Raises
    ------
    NotSweepableError
        The layout is none of a sweep; the message is the reason, in half a sentence.
    """
    sweep = match_caps(assemble_sweep(solid, layout, reverse=reverse))
    reason = _reentrant_rim(sweep) or _flat_corner(sweep) or _unmatched_fold(sweep) or why_unmatched(sweep)
    if reason:
        raise NotSweepableError(reason)
    return sweep


def assemble_sweep(solid: Solid, layout: Layout, *, reverse: bool = False) -> Sweep:
    """The sweep of a layout as :func:`build_sweep` gives it, before one cap is compared with the other.

    Raises
    ------
    NotSweepableError
        A cap is no disc with holes.
    """
    source, target = layout.caps[::-1] if reverse else layout.caps
    loops: list[tuple[list[LinkingSide], list[DirectedEdge], list[DirectedEdge]]] = []
    chains = [_side_chain(solid, chain, reverse) for chain in layout.chains]
    for chain in chains:
        bottom = order_loop(solid, _ends(solid, chain[0], set(source), top=False))
        top = order_loop(solid, _ends(solid, chain[-1], set(target), top=True))
        loops.append(([side for span in chain for side in span], bottom, top))
    extent = [_extent(solid, [e for e, _ in bottom]) for _, bottom, _ in loops]
    order = sorted(range(len(loops)), key=lambda j: -extent[j])
    for cap in (source, target):
        if euler(solid, cap) != 2 - len(loops):
            raise NotSweepableError(f"the cap with {solid.faces[cap[0]].label()} is not a disc with holes")

    source_loops, target_loops, spans, lengths, stations = [], [], [], [], []
    for j in order:
        sides, bottom, top = loops[j]
        bottom, top = _begin_on_rail(solid, sides, bottom, top)
        source_loops.append(tuple(bottom))
        target_loops.append(tuple(top))
        spans.append(tuple(_rails(span) for span in chains[j]))
        lengths.append(tuple(_span_length(solid, span) for span in chains[j]))
        total = sum(lengths[-1])
        for k in range(len(chains[j]) - 1):
            below = {f.face for f in chains[j][k]}
            ring = order_loop(solid, _ends(solid, chains[j][k + 1], below, top=False))
            stations.append((sum(lengths[-1][: k + 1]) / total, tuple(e for e, _ in ring)))
    all_sides = tuple(side for j in order for side in loops[j][0])
    return Sweep(
        solid=solid,
        source=tuple(source),
        target=tuple(target),
        linking_sides=all_sides,
        source_loops=tuple(source_loops),
        target_loops=tuple(target_loops),
        rails=tuple(sorted({e for loop in spans for span in loop for e in span})),
        stations=tuple(ring for _, ring in sorted(stations, key=lambda s: s[0])),
        spans=tuple(spans),
        span_lengths=tuple(lengths),
    )


def _reentrant_rim(sweep: Sweep) -> str:
    """Say where a cap and a linking side meet at an angle that no hex fits into."""
    for e in [e for loop in sweep.source_loops + sweep.target_loops for e, _ in loop]:
        edge = sweep.solid.edges[e]
        faces = [sweep.solid.faces[f] for f in edge.faces]
        if edge.dihedral > MAX_RIM:
            return f"cap and linking side meet at a re-entrant edge, between {_both(faces)}"
        if abs(edge.dihedral - pi) < FLAT and all(face.kind == "plane" for face in faces):
            return f"cap and linking side lie in one plane, {_both(faces)}"
    return ""


def _both(faces: Sequence[Face]) -> str:
    return " and ".join(face.label() for face in faces)


def _flat_corner(sweep: Sweep) -> str:
    """Say which linking side has a corner between two edges that are one straight line."""
    solid = sweep.solid
    for side in sweep.linking_sides:
        ring = [side.bottom, side.right, _reversed(side.top), _reversed(side.left)]
        loop = solid.faces[side.face].loops[0]
        place = {edge: k for k, edge in enumerate(loop.directed)}
        for one, other in zip(ring, [*ring[1:], ring[0]], strict=True):
            straight = solid.edges[one[-1][0]].kind == solid.edges[other[0][0]].kind == "line"
            k = place.get(other[0])
            if straight and k is not None and abs(loop.angles[k] - pi) < FLAT:
                return f"{solid.faces[side.face].label()} would have a corner within a straight line"
    return ""


def _unmatched_fold(sweep: Sweep) -> str:
    """Say where a cap is folded and the other cap is not folded the other way at the same place."""
    solid = sweep.solid
    source, target = set(sweep.source), set(sweep.target)
    answered = {b for b, _ in sweep.target_edges.values()} if sweep.target_faces else set()
    for edge in solid.edges:
        fold = edge.dihedral - pi
        if abs(fold) < MAX_FOLD:
            continue
        for cap, other in ((source, sweep.target_edges if sweep.target_faces else {}), (target, None)):
            if not cap.issuperset(edge.faces):
                continue
            if other is None:
                matched = edge.id in answered
            else:
                matched = edge.id in other and abs(solid.edges[other[edge.id][0]].dihedral - pi + fold) < MAX_FOLD
            if not matched:
                return f"its cap is folded at {edge.label()} and the other cap is not"
    return ""


def _side_chain(solid: Solid, chain: Sequence[tuple[Band, dict[int, int]]], reverse: bool) -> list[list[LinkingSide]]:
    """Linking sides of one loop, span by span from source to target."""
    spans = []
    for band, bottoms in chain[::-1] if reverse else chain:
        span = []
        for f, (reading, _) in band.faces.items():
            forward = dict(solid.faces[f].loops[0].directed)
            b = bottoms[f] + (2 if reverse else 0)
            bottom, right, top, left = (tuple((e, forward[e]) for e in reading.chains[(b + k) % 4]) for k in range(4))
            span.append(LinkingSide(face=f, bottom=bottom, right=right, top=_reversed(top), left=_reversed(left)))
        spans.append(span)
    return spans


def _reversed(chain: Sequence[DirectedEdge]) -> tuple[DirectedEdge, ...]:
    return tuple((e, not forward) for e, forward in reversed(chain))


def _ends(solid: Solid, span: Sequence[LinkingSide], neighbours: set[int], *, top: bool) -> list[DirectedEdge]:
    """Directed edges at the bottom or top of a span that border the given faces."""
    found = []
    for side in span:
        for e, forward in side.top if top else side.bottom:
            a, b = solid.edges[e].faces
            if (b if a == side.face else a) in neighbours:
                found.append((e, forward))
    return found


def order_loop(solid: Solid, edges: Sequence[DirectedEdge]) -> list[DirectedEdge]:
    """Put directed edges in cyclic order.

    Raises
    ------
    NotSweepableError
        They are not one loop; the message says why.
    """
    begins: dict[int, DirectedEdge] = {}
    for e, forward in edges:
        v = solid.first_vertex((e, forward))
        if v in begins:
            raise NotSweepableError(f"a loop of the cap touches itself at ({solid.units.place(solid.vertices[v])})")
        begins[v] = (e, forward)
    loop = [edges[0]]
    while len(loop) <= len(edges):
        v = solid.last_vertex(loop[-1])
        step = begins.get(v)
        if step is None or step == loop[0]:
            break
        loop.append(step)
    if len(loop) != len(edges):
        raise NotSweepableError("a ring of its linking sides is not one closed loop")
    return loop


def euler(solid: Solid, faces: Sequence[int]) -> int:
    """Euler characteristic of a connected group of faces: 1 for a disc, 0 for a ring."""
    edges = {e for f in faces for e in solid.faces[f].edges}
    vertices = {v for e in edges for v in (solid.edges[e].start, solid.edges[e].end)}
    return len(vertices) - len(edges) + sum(2 - len(solid.faces[f].loops) for f in faces)


def _extent(solid: Solid, edges: Sequence[int]) -> float:
    """Diagonal of the box around a loop: the outer loop has the greatest."""
    points = np.concatenate([[solid.vertices[solid.edges[e].start], solid.edges[e].midpoint] for e in edges])
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def _rails(span: Sequence[LinkingSide]) -> tuple[int, ...]:
    return tuple(sorted({e for side in span for e, _ in side.left + side.right}))


def _span_length(solid: Solid, span: Sequence[LinkingSide]) -> float:
    """Mean length of a span along the sweep, stacked faces counted with their share of the loop."""
    height = [sum(solid.edges[e].length for e, _ in side.left) for side in span]
    width = [sum(solid.edges[e].length for e, _ in side.bottom) for side in span]
    bordering = {e for side in span for e, _ in side.top}
    lowest = [w for side, w in zip(span, width, strict=True) if not bordering & {e for e, _ in side.bottom}]
    return sum(h * w for h, w in zip(height, width, strict=True)) / max(sum(lowest), 1e-300)


def _begin_on_rail(
    solid: Solid, sides: Sequence[LinkingSide], bottom: list[DirectedEdge], top: list[DirectedEdge]
) -> tuple[list[DirectedEdge], list[DirectedEdge]]:
    """Turn both loops so that they begin on the same rail, where one runs all the way."""
    up: dict[int, int] = {}
    for side in sides:
        for e, forward in side.left + side.right:
            a, b = solid.edges[e].start, solid.edges[e].end
            up[a if forward else b] = b if forward else a
    tops = {solid.first_vertex(directed): k for k, directed in enumerate(top)}
    for j, directed in enumerate(bottom):
        v = solid.first_vertex(directed)
        while v in up:
            v = up[v]
        if v in tops:
            k = tops[v]
            return bottom[j:] + bottom[:j], top[k:] + top[:k]
    return bottom, top
