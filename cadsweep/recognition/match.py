"""Which face and edge of the source cap corresponds to which of the target cap.

Place in the flow: part of :mod:`.build`. Both caps are walked through side by side, beginning
with the edges that one linking side joins; where the two planar graphs agree, every source face
has its target face. Where they do not, only the joined boundary edges are given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from ..sweep import DirectedEdge, Sweep


def match_caps(sweep: Sweep) -> Sweep:
    """Return the sweep with ``target_faces`` and ``target_edges`` filled in."""
    joined = join_boundaries(sweep)
    if len(sweep.source) == len(sweep.target) == 1:
        return replace(sweep, target_faces={sweep.source[0]: sweep.target[0]}, target_edges=joined)
    matched = _walk(sweep, joined) if len(sweep.source) == len(sweep.target) else None
    if matched is not None:
        faces, edges = matched
        return replace(sweep, target_faces=faces, target_edges=edges)
    return replace(sweep, target_edges=joined)


def why_unmatched(sweep: Sweep) -> str:
    """Say how a target of several faces differs from the source; empty where the mesh can follow the target's edges."""
    if len(sweep.target) == 1 or sweep.target_faces:
        return ""
    source, target = (_names(sweep.solid, cap) for cap in (sweep.source, sweep.target))
    return f"both caps would be divided, and not alike: {source} on one side, {target} on the other"


def _names(solid: Solid, cap: Sequence[int]) -> str:
    more = f" and {len(cap) - 2} more" if len(cap) > 2 else ""
    return ", ".join(solid.faces[f].label() for f in cap[:2]) + more


def join_boundaries(sweep: Sweep) -> dict[int, DirectedEdge]:
    """Boundary edges that columns of one-to-one linking sides join."""
    above: dict[int, tuple[DirectedEdge, DirectedEdge]] = {}
    for side in sweep.linking_sides:
        if len(side.bottom) == 1 and len(side.top) == 1:
            above[side.bottom[0][0]] = (side.bottom[0], side.top[0])
    joined: dict[int, DirectedEdge] = {}
    targets = {e for loop in sweep.target_loops for e, _ in loop}
    for loop in sweep.source_loops:
        for e, _ in loop:
            edge, same = e, True
            while edge in above:
                (_, f0), (upper, f1) = above[edge]
                same = same == (f0 == f1)
                edge = upper
                if edge in targets:
                    joined[e] = (edge, same)
                    break
    return joined


def _directed(solid: Solid, face: int) -> dict[int, tuple[int, int]]:
    """For every edge of a face: its loop and its position in the loop."""
    return {e: (j, k) for j, loop in enumerate(solid.faces[face].loops) for k, e in enumerate(loop.edges)}


def _walk(sweep: Sweep, joined: dict[int, DirectedEdge]) -> tuple[dict[int, int], dict[int, DirectedEdge]] | None:
    """Walk both caps side by side; None where their graphs differ."""
    solid = sweep.solid
    source, target = set(sweep.source), set(sweep.target)
    edges = dict(joined)
    faces: dict[int, int] = {}
    queue = list(joined.items())
    done: set[tuple[int, int]] = set()
    while True:
        if not queue:
            queue = _inner_loops(solid, faces, edges, done)
        if not queue:
            break
        a, (b, same) = queue.pop()
        for f in solid.edges[a].faces:
            if f not in source:
                continue
            g = partner_of(solid, (f, a), (b, same), target)
            if g is None or faces.setdefault(f, g) != g:
                return None
            ja, ka = _directed(solid, f)[a]
            jb, kb = _directed(solid, g)[b]
            if (f, ja) in done:
                continue
            done.add((f, ja))
            # the target cap is seen from its other side: its loops run the other way round
            loop_a, loop_b = solid.faces[f].loops[ja], solid.faces[g].loops[jb]
            n = len(loop_a.edges)
            if len(loop_b.edges) != n or len(solid.faces[f].loops) != len(solid.faces[g].loops):
                return None
            for i in range(n):
                p, q = (ka + i) % n, (kb - i) % n
                pair = (loop_b.edges[q], loop_a.forward[p] != loop_b.forward[q])
                known = edges.setdefault(loop_a.edges[p], pair)
                if known != pair:
                    return None
                queue.append((loop_a.edges[p], pair))
    if len(faces) != len(source) or len(set(faces.values())) != len(target):
        return None
    if len(edges) != len({e for f in source for e in solid.faces[f].edges}):
        return None
    return faces, edges


def _inner_loops(
    solid: Solid, faces: dict[int, int], edges: dict[int, DirectedEdge], done: set[tuple[int, int]]
) -> list[tuple[int, DirectedEdge]]:
    """Pair an edge of a loop inside a cap (of an imprint) with one on the other cap, by its place.

    The places are compared after the affine map that the edges matched so far define.
    """
    waiting = [(f, j) for f in faces for j in range(len(solid.faces[f].loops)) if (f, j) not in done]
    if not waiting:
        return []
    f, j = waiting[0]
    source, target = matched_points(solid, edges)
    center, far_center = source.mean(axis=0), target.mean(axis=0)
    fit, *_ = np.linalg.lstsq(source - center, target - far_center, rcond=1e-9)
    edge = solid.edges[solid.faces[f].loops[j].edges[0]]
    place = (edge.midpoint - center) @ fit + far_center
    taken = {b for b, _ in edges.values()}
    candidates = [e for loop in solid.faces[faces[f]].loops for e in loop.edges if e not in taken]
    if not candidates:
        return []
    answer = min(candidates, key=lambda e: float(np.linalg.norm(solid.edges[e].midpoint - place)))
    forward, far_forward = dict(_forward(solid, f))[edge.id], dict(_forward(solid, faces[f]))[answer]
    pair = (answer, forward != far_forward)
    edges[edge.id] = pair
    return [(edge.id, pair)]


def matched_points(solid: Solid, edges: dict[int, DirectedEdge]) -> tuple[FloatArray, FloatArray]:
    """Middles and starts of matched edges, on the source and on the target."""
    source, target = [], []
    for a, (b, same) in edges.items():
        one, other = solid.edges[a], solid.edges[b]
        source += [one.midpoint, solid.vertices[one.start]]
        target += [other.midpoint, solid.vertices[other.start if same else other.end]]
    return np.array(source), np.array(target)


def partner_of(solid: Solid, beside: tuple[int, int], joined: DirectedEdge, target: set[int]) -> int | None:
    """Target face beside a joined edge that corresponds to a source face beside its edge."""
    face, edge = beside
    b, same = joined
    forward = dict(_forward(solid, face))[edge]
    for g in solid.edges[b].faces:
        if g in target and dict(_forward(solid, g))[b] == (forward != same):
            return g
    return None


def _forward(solid: Solid, face: int) -> list[DirectedEdge]:
    return [d for loop in solid.faces[face].loops for d in loop.directed]
