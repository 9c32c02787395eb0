"""Caps grown over a ring of faces, where hexes have better corners at its outer edge.

Place in the flow: variants of a layout, beside it in the list of :mod:`.find`. A ring of rectangles around a cap can
be the last of the linking sides or the border of the cap: a shallow chamfer or the upper half of a rounding is better
a part of the cap, a steep chamfer a side. What decides is the angle between cap and sides at the rim, as hexes see
it: on a rounding not between the tangent planes, which is 180 degrees, but between chords.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi, sin
from weakref import WeakKeyDictionary

import numpy as np

from ..brep import Edge, Solid
from ..sweep import Sweep
from .bands import Band
from .layout import Layout

TANGENT = 5 * pi / 6
"""Interior angle from which on a rim is judged by chords."""
HALF_SEGMENT = pi / 16
"""Greatest turn, in radians, from a rim to the chord of the first segment beyond it."""
_LEAST = 1e-6
"""Sine that stands for nought, so that quotients are finite."""
GAIN = 1.15
"""How much better the worst edge of the rim must become for a cap to grow."""


_angles: WeakKeyDictionary[Solid, dict[int, float]] = WeakKeyDictionary()


def rim_angle(solid: Solid, edge: Edge) -> float:
    """Interior angle of the solid across an edge, in radians, as hexes on both sides see it.

    Nearly tangent faces are taken by the chord of a first segment, which leaves the tangent by up to `HALF_SEGMENT`.
    """
    known = _angles.setdefault(solid, {})  # the same edges are the rim of hundreds of layouts
    if edge.id not in known:
        known[edge.id] = _rim_angle(solid, edge)
    return known[edge.id]


def _rim_angle(solid: Solid, edge: Edge) -> float:
    angle = edge.dihedral
    if not TANGENT < angle < 2 * pi - TANGENT or edge.start == edge.end:
        return angle
    for f in edge.faces:
        face = solid.faces[f]
        if face.kind == "plane":
            continue
        at_rim = face.surface.normals(face.surface.edge_uv(edge.id, np.array([0.5])))[0]
        # Not the face's own normal: of a bent strip it stands at a place beside the strip.
        box = np.concatenate([face.surface.edge_uv(e, np.array([0.0, 0.5, 1.0])) for e in face.edges])
        middle = face.surface.normals((box.min(axis=0) + box.max(axis=0))[None] / 2)[0]
        forward = next(run for loop in face.loops for e, run in loop.directed if e == edge.id)
        tangent = (solid.vertices[edge.end] - solid.vertices[edge.start]) * (1 if forward else -1)
        inward = np.cross(at_rim, tangent / np.linalg.norm(tangent))
        # The normal of a bulging face leans forward on the way into the face.
        turn = float(np.arctan2(middle @ inward, middle @ at_rim))
        angle -= min(max(turn, -HALF_SEGMENT), HALF_SEGMENT)
    return angle


def rim_quality(solid: Solid, edge: Edge) -> float:
    """Expected quality of the hexes at an edge between cap and side: 1 at a right angle, near 0 where it is flat."""
    sine = max(sin(rim_angle(solid, edge)), _LEAST)
    # Shorter segments see a sharp edge as it is, and a rounding ever flatter.
    return sine**2 if TANGENT < edge.dihedral < 2 * pi - TANGENT else sine


def worst_rim(sweep: Sweep) -> float:
    """Expected quality of the hexes at the worst edge between caps and sides, at most 1."""
    loops = sweep.source_loops + sweep.target_loops
    return _worst(sweep.solid, [sweep.solid.edges[e] for loop in loops for e, _ in loop])


def find_roundings(sweep: Sweep) -> list[tuple[int, tuple[int, ...]]]:
    """Find the caps that run tangent into their sides, and the faces that may round their edges.

    Returns
    -------
    list of (int, tuple of int)
        For every such cap that has a plane face: the largest of these, and curved faces of the cap and beside it.
    """
    solid = sweep.solid
    found = []
    for cap in (sweep.source, sweep.target):
        inside = set(cap)
        beside = [edge for edge in solid.edges if any(f in inside for f in edge.faces)]
        rim = [edge for edge in beside if not inside.issuperset(edge.faces)]
        planes = [solid.faces[f] for f in cap if solid.faces[f].kind == "plane"]
        if planes and any(TANGENT < edge.dihedral < 2 * pi - TANGENT for edge in rim):
            near = {f for edge in beside for f in edge.faces if solid.faces[f].kind != "plane"}
            found.append((max(planes, key=lambda face: face.area).id, tuple(sorted(near))))
    return found


def with_grown(solid: Solid, layout: Layout) -> list[Layout]:
    """Return the layout and, before it, that with its caps grown where they are better so."""
    larger = _grown(solid, layout)
    return [layout] if larger is None else [larger, layout]


def _grown(solid: Solid, layout: Layout) -> Layout | None:
    caps = [list(layout.caps[0]), list(layout.caps[1])]
    chains = [list(chain) for chain in layout.chains]
    for end in (0, -1):
        for chain in chains:
            while len(chain) > 1:
                outer, inner = (chain[0], chain[1]) if end == 0 else (chain[-1], chain[-2])
                before = _worst(solid, _between(solid, outer[0], set(caps[end])))
                after = _worst(solid, _between(solid, outer[0], set(inner[0].faces)))
                if after < GAIN * before:
                    break
                caps[end] += sorted(outer[0].faces)
                del chain[end]
    if len(caps[0]) + len(caps[1]) == len(layout.caps[0]) + len(layout.caps[1]):
        return None
    return replace(
        layout,
        caps=(tuple(sorted(caps[0])), tuple(sorted(caps[1]))),
        chains=tuple(tuple(chain) for chain in chains),
    )


def _between(solid: Solid, band: Band, others: set[int]) -> list[Edge]:
    """Edges between the faces of a band and other faces."""
    found = []
    for f in band.faces:
        for e in solid.faces[f].edges:
            a, b = solid.edges[e].faces
            if (b if a == f else a) in others:
                found.append(solid.edges[e])
    return found


def _worst(solid: Solid, edges: Sequence[Edge]) -> float:
    return min((rim_quality(solid, edge) for edge in edges), default=_LEAST)
