"""Segments around circles that are a pattern: as many as make the nodes as symmetric as the holes, or as the ring.

Place in the flow: :mod:`.sizes` asks for it. What carries the outline of a cap to itself (:mod:`.symmetry`) carries
nodes of its circles to nodes where these have certain multiples as segments; as much symmetry is had as costs little.
A rim and the bore about its middle, with holes between them, get as many each, for a lattice that closes around.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, dist, lcm, pi
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Solid
from ..sweep import Sweep
from .symmetry import find_symmetry

_SAME = 1e-6
"""Difference of lengths, in sizes of the part, up to which circles are alike."""
_MOST_MORE = 1.35
"""Segments over those wanted up to which a circle is divided more finely for symmetry."""
_MOST_ADDED = 3.0
"""Segments that half a small circle may get besides: six holes of six segments are alike with twelve."""
_MOST_UNLIKE = 2.5
"""Ratio of counts wanted up to which a rim and a bore with holes between them get equal ones: circles and rays."""
_NEARLY = 1.15
"""Ratio of counts up to which what a pattern has made equal, and other faces have not, is made so again."""
_LEAVE = 0.1
"""Part of a multiple that may be missing, before the next one is taken."""


class Patterned(NamedTuple):
    """What half a circle in a pattern is divided into: `segments`, a multiple of `step`."""

    segments: float
    step: int


def symmetric_counts(
    sweep: Sweep, wanted: Mapping[int, float], steps: Mapping[int, int] | None = None
) -> dict[int, Patterned]:
    """Counts of the halves of circles that are patterns, by edge; of other edges none.

    `steps`: of edges that are in a pattern of another cell, and have its counts.
    """
    found: dict[int, Patterned] = {}
    faces = [sweep.solid.faces[f] for f in (*sweep.source, *sweep.target)]  # edges that answer each other want the same
    plane = all(face.kind == "plane" for face in faces)
    counts = dict(wanted)  # with what is found: faces of one cap share circles
    for face in faces:
        if face.kind == "plane":
            own = _of_face(sweep.solid, face, counts, plane=plane)
            found |= own
            counts |= counts_of(own)
    known = {**(steps or {}), **{e: own.step for e, own in found.items()}}
    for face in faces:
        if face.kind == "plane" and len(face.loops) == 2:
            own = _beside(sweep.solid, face, counts, known)
            found |= own
            counts |= counts_of(own)
            known |= {e: made.step for e, made in own.items()}
    return found


def counts_of(patterned: Mapping[int, Patterned]) -> dict[int, float]:
    """The counts alone."""
    return {e: own.segments for e, own in patterned.items()}


def stepped(count: float, steps: Sequence[int]) -> float:
    """The count, not much smaller than the one wanted, that answers all patterns at once, or the greatest if it can.

    `steps`: of the edges that must have it, none of those in no pattern.
    """
    for step in (lcm(*steps), max(steps, default=1)):
        if step == 1:
            break
        found = step * max(1, ceil(count / step - _LEAVE))
        if found <= max(_MOST_MORE * count, count + _MOST_ADDED):
            return float(found)
    return count


def _beside(solid: Solid, face: Face, wanted: Mapping[int, float], steps: Mapping[int, int]) -> dict[int, Patterned]:
    """The counts of a wall between two circles one of which is in a pattern: those of that one."""
    circles = _circles(solid, face)
    if len(circles) != 2 or any(len(edges) != 2 or not set(edges) <= set(wanted) for edges, *_ in circles):
        return {}
    (one, at, _), (other, there, _) = circles
    n, m = (max(wanted[e] for e in edges) for edges in (one, other))
    own = [steps[e] for e in (*one, *other) if e in steps]
    if not own or np.linalg.norm(at - there) > _SAME * solid.size or max(n, m) > _MOST_UNLIKE * min(n, m):
        return {}
    return dict.fromkeys((*one, *other), Patterned(max(n, m), lcm(*own)))


def ring_sides(solid: Solid, face: Face, wanted: Mapping[int, float]) -> list[tuple[list[int], list[int]]]:
    """The rim and the bore of a ring with holes, where their counts are nearly equal: they stay so when rounded."""
    if face.kind != "plane" or len(face.loops) < 3:
        return []
    pairs = [(list(rim), list(bore)) for rim, bore in _rings(_circles(solid, face), wanted, solid)]
    return [pair for pair in pairs if nearly(pair, wanted)]


def nearly(pair: tuple[Sequence[int], Sequence[int]], wanted: Mapping[int, float]) -> bool:
    """Whether two loops of edges want nearly equal counts."""
    both = [sum(wanted[e] for e in edges) for edges in pair]
    return max(both) <= _NEARLY * min(both)


_Circle = tuple[Sequence[int], FloatArray, float]
"""Edges of a loop that is a circle, its centre, and its diameter."""


def _circles(solid: Solid, face: Face) -> list[_Circle]:
    found: list[_Circle] = []
    for loop in face.loops:
        edges = [solid.edges[e] for e in loop.edges]
        if any(edge.kind != "circle" for edge in edges):
            continue
        lengths = [edge.length for edge in edges]
        diameter = sum(lengths) / pi
        if len(edges) == 2 and abs(lengths[0] - lengths[1]) <= _SAME * solid.size:
            centre = (edges[0].midpoint + edges[1].midpoint) / 2
        else:  # as many points as tell a circle from three of its places
            places = np.concatenate([[edge.midpoint, solid.vertices[edge.start]] for edge in edges])
            centre = _centre(places)
            if np.ptp(np.linalg.norm(places - centre, axis=1)) > _SAME * solid.size:
                continue
        if abs(2.0 * dist(edges[0].midpoint, centre) - diameter) <= _SAME * solid.size:
            found.append((loop.edges, centre, diameter))
    return found


def _centre(places: FloatArray) -> FloatArray:
    """The point of their plane that is equally far from places (n, 3), n >= 2, in the sense of least squares."""
    off = places - places.mean(axis=0)
    solved = np.linalg.lstsq(2.0 * off, (off**2).sum(axis=1) - (off**2).sum(axis=1).mean(), rcond=1e-9)[0]
    return np.asarray(places.mean(axis=0) + solved)


def _of_face(solid: Solid, face: Face, wanted: Mapping[int, float], *, plane: bool) -> dict[int, Patterned]:
    """As :func:`symmetric_counts`, of one face; `plane`: all caps are, so that no curved one has the last word."""
    circles = [c for c in _circles(solid, face) if len(c[0]) == 2 and _halves(solid, c[0])]
    if not circles:
        return {}
    open_ones = [circle for circle in circles if set(circle[0]) <= set(wanted)]
    rings: dict[int, Patterned] = {}
    for rim, bore in _rings(open_ones, wanted, solid):
        # Nearer to what the rim wants: there are more quads outside than inside.
        rings = dict.fromkeys((*rim, *bore), Patterned((2.0 * wanted[rim[0]] + wanted[bore[0]]) / 3.0, 1))
    wanted = {**wanted, **counts_of(rings)} if rings else wanted
    if plane and len(circles) == len(face.loops) and _concentric(circles, solid):
        # Every turn carries them to themselves: quarters are what a square core has, and what costs next to nothing.
        halves = {e: wanted[e] for edges, *_ in open_ones for e in edges}
        if len(open_ones) == 2 and max(halves.values()) <= _MOST_UNLIKE * min(halves.values()):
            # Of a wall equal counts are made, of their mean.
            halves = dict.fromkeys(halves, float(np.exp(np.mean(np.log(list(halves.values()))))))
        return {e: Patterned(2.0 * max(1, ceil(n / 2.0 - _LEAVE)), 2) for e, n in halves.items()}
    symmetry = find_symmetry(solid, face)
    if symmetry is None:
        return rings
    for motions in symmetry.subgroups():
        for met in (True, False):
            multiples = symmetry.multiples(motions, met=met)
            if multiples is None:
                continue
            counts = {
                e: n / 2.0 * max(1, ceil(2.0 * wanted[e] / n - _LEAVE)) for e, n in multiples.items() if e in wanted
            }
            if all(count <= max(_MOST_MORE * wanted[e], wanted[e] + _MOST_ADDED) for e, count in counts.items()):
                return {**rings, **{e: Patterned(count, multiples[e] // 2) for e, count in counts.items()}}
    return rings


def _concentric(circles: Sequence[_Circle], solid: Solid) -> bool:
    return all(dist(centre, circles[0][1]) <= _SAME * solid.size for _, centre, _ in circles)


def _halves(solid: Solid, edges: Sequence[int]) -> bool:
    return abs(solid.edges[edges[0]].length - solid.edges[edges[1]].length) <= _SAME * solid.size


def _rings(
    circles: Sequence[_Circle], wanted: Mapping[int, float], solid: Solid
) -> list[tuple[Sequence[int], Sequence[int]]]:
    """The greatest circle and the bore about its middle, where there are holes between them; one pair, or none."""
    if len(circles) < 3:
        return []
    (rim, middle, _), *others = sorted(circles, key=lambda circle: -circle[2])
    bores = [edges for edges, at, _ in others if np.linalg.norm(at - middle) <= _SAME * solid.size]
    if len(bores) != 1:
        return []
    outside, inside = (sum(wanted[e] for e in edges) for edges in (rim, bores[0]))
    return [(rim, bores[0])] if outside <= _MOST_UNLIKE * inside else []
