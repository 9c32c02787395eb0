"""Expected quality of a sweep, from angles and shapes alone.

Place in the flow: fifth step of :mod:`cadsweep.recognition`; orders the candidates before anything
is meshed. Five figures between 0 and 1 are multiplied: how far the corners of the linking sides
are from right angles, how far caps stand from square to the sides, how affine the target loop is
to the source loop, how parallel the rails run, and how simple the caps are. None of them is a
bound on a mesh's quality.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..sweep import Sweep
from .growth import rim_quality
from .layout import Layout

FLOOR = 0.02
"""Least factor of a score: one bad angle must not hide the others."""

PLACES = 16
"""Places along the sweep where the directions of the rails are compared."""


def score_layout(solid: Solid, layout: Layout) -> float:
    """Return the part of the score that angles decide: sides' corners and the dihedral at the caps."""
    faces = [reading for chain in layout.chains for band, _ in chain for reading, _ in band.faces.values()]
    worst_corner = max(reading.cost for reading in faces)
    mean_corner = sum(reading.cost for reading in faces) / len(faces)
    folded = max(0.0, worst_corner - 1.0)
    corners = 1.0 / (1.0 + 0.35 * mean_corner + 0.1 * worst_corner + folded)
    caps = {f for cap in layout.caps for f in cap}
    rim, inner = [], []
    for edge in solid.edges:
        n = sum(f in caps for f in edge.faces)
        if n == 1:
            rim.append(rim_quality(solid, edge))
        elif n == 2:
            inner.append(edge.dihedral)
    square = [max(quality, FLOOR) for quality in rim]
    caps_score = sqrt(min(square) * (sum(square) / len(square)))
    folds = [max(1.0 - abs(a - pi) / pi, FLOOR) for a in inner]
    return corners * caps_score**0.5 * (min(folds) if folds else 1.0)


def score_sweep(sweep: Sweep, angles: float) -> float:
    """Return the expected quality of a sweep whose angles have the score `angles`, at most 1."""
    solid = sweep.solid
    n_faces = len(sweep.source) + len(sweep.target)
    plane = sum(solid.faces[f].kind == "plane" for f in sweep.source + sweep.target) / n_faces
    simple = (0.9 + 0.1 * plane) * (1.0 if n_faces == 2 else 0.85)
    if len(sweep.target) > 1 and not sweep.target_faces:
        simple *= 0.5
    return float(angles * affinity(sweep) * parallelism(sweep) * simple * (0.9 + 0.1 * _compactness(sweep)))


def affinity(sweep: Sweep) -> float:
    """How well one affine map brings the source loops onto the target loops: 1 exactly, 0.3 not at all."""
    solid = sweep.solid
    a, b = [], []
    for loop in sweep.source_loops:
        for e, _ in loop:
            if e not in sweep.target_edges:
                continue
            t, same = sweep.target_edges[e]
            first, second = solid.edges[e], solid.edges[t]
            a += [first.midpoint, solid.vertices[first.start]]
            b += [second.midpoint, solid.vertices[second.start if same else second.end]]
    if len(a) < 4:
        return 0.9
    source, target = np.array(a), np.array(b)
    source = source - source.mean(axis=0)
    target = target - target.mean(axis=0)
    fit, *_ = np.linalg.lstsq(source, target, rcond=1e-9)
    size = np.sqrt((target**2).sum()) or 1.0
    residual = np.sqrt(((source @ fit - target) ** 2).sum()) / size
    return float(1.0 - 0.7 * min(1.0, 2.0 * residual))


def parallelism(sweep: Sweep) -> float:
    """How parallel the rails run at the same place of the sweep: 1 in an extrusion or a bend.

    Layers stand about square to the mean direction of the rails, so a rail that leans away from it by an
    angle t shears the hexahedra beside it to a scaled Jacobian of cos t. The least and the mean cosine
    count alike. Between the skins of a sheet, faces that answer each other one by one, layers follow the skins:
    a rail that leans there is seen at the rims.
    """
    if len(sweep.source) > 1 and sweep.target_faces:
        return 1.0
    forward = {e: same for side in sweep.linking_sides for e, same in (*side.left, *side.right)}
    middles = (np.arange(PLACES) + 0.5) / PLACES
    total = np.zeros((PLACES, 3))
    found: list[tuple[IntArray, FloatArray]] = []
    for spans, lengths in zip(sweep.spans, sweep.span_lengths, strict=True):
        ends = np.concatenate([[0.0], np.cumsum(lengths)]) / sum(lengths)
        for rails, first, last in zip(spans, ends[:-1], ends[1:], strict=True):
            places = np.flatnonzero((middles >= first) & (middles < last))
            if not len(places):
                continue
            shares = (middles[places] - first) / (last - first)
            for rail in rails:
                directions = _directions(sweep.solid, rail, shares, forward.get(rail, True))
                total[places] += directions
                found.append((places, directions))
    if not found:
        return 1.0
    norm = np.linalg.norm(total, axis=1, keepdims=True)
    mean = total / np.where(norm > 0, norm, 1.0)
    cosines = np.concatenate([np.einsum("md,md->m", mean[places], d) for places, d in found])
    return float(max(0.5 * (cosines.min() + cosines.mean()), FLOOR))


def _directions(solid: Solid, rail: int, shares: FloatArray, forward: bool) -> FloatArray:
    """Unit tangents (m, 3) of a rail at shares of its length (m,), both from source to target."""
    edge = solid.edges[rail]
    if edge.kind == "line":
        chord = solid.vertices[edge.end] - solid.vertices[edge.start]
        tangents = np.broadcast_to(chord, (len(shares), 3))
    else:
        at = shares if forward else 1.0 - shares
        half = 0.25 / PLACES
        ends = edge.curve.evaluate(np.concatenate([np.maximum(at - half, 0.0), np.minimum(at + half, 1.0)]))
        tangents = ends[len(at) :] - ends[: len(at)]
    tangents = tangents / np.linalg.norm(tangents, axis=1, keepdims=True)
    return tangents if forward else -tangents


def _compactness(sweep: Sweep) -> float:
    """Isoperimetric ratio of the source cap's outer loop, 1 for a disc."""
    solid = sweep.solid
    perimeter = sum(solid.edges[e].length for e, _ in sweep.source_loops[0])
    area = sum(solid.faces[f].area for f in sweep.source)
    return float(min(1.0, 4.0 * pi * area / perimeter**2)) if perimeter else 0.0
