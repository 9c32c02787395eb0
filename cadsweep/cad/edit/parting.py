r"""Vertices of a design in which more faces end than meet in a point, parted by short edges.

Place in the flow: between the topology of a design (:mod:`.collapsing`) and its shape (:mod:`.sharpening`).

Method: where the end of a blend lies across an edge of the face that it ends at, four faces are left around its vertex,
and their surfaces meet three by three. Of the faces around one vertex two that are apart get an edge between them, and
the vertex becomes the two ends of that; all ways are looked at, and that is taken in which the new edge goes most
clearly into both of these faces, seen from the edges that they have there::

       A |  B            A |  B
         |                 |
    -----+-----    ->  ----+---.          C and B, or A and the blend's other support
       C \  D            C      \ D
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from .collapsing import SAMPLES, Collapsed, SharpEdge

Meet = Callable[[Sequence[int], FloatArray], FloatArray | None]
"""Where faces meet near a place (3,); None where they do not."""


class _Passage(NamedTuple):
    """How the loop of a face goes through a vertex: the edge that comes in, and the one that leaves."""

    face: int
    into: int
    out: int


def part_vertex(solid: Solid, topology: Collapsed, vertex: int, place: FloatArray, meet: Meet) -> bool:
    """Part a vertex until three faces meet in each, in place; whether that could be done.

    Parameters
    ----------
    solid : Solid
    topology : Collapsed
        Is changed.
    vertex : int
    place : (3,) float64
        About where it is.
    meet : callable
    """
    ring = _ring(topology, vertex)
    if ring is None or len(ring) < 4:
        return False
    best: tuple[float, list[_Passage], FloatArray, FloatArray | None] | None = None
    for j in range(len(ring)):
        three = [ring[j - 1], ring[j], ring[(j + 1) % len(ring)]]
        cut_off = meet([own.face for own in three], place)
        if cut_off is None:
            continue
        others = [own.face for own in ring if own is not ring[j]]
        rest = meet(others, place)
        if rest is None and len(others) == 3:
            continue
        score = _score(solid, topology, vertex, ring, j, cut_off - (place if rest is None else rest))
        if best is None or score > best[0]:
            best = score, three, cut_off, rest
    if best is None:
        return False
    _, three, cut_off, rest = best
    other = _part(topology, vertex, three, cut_off, place if rest is None else rest)
    return other is not None and (rest is not None or part_vertex(solid, topology, vertex, place, meet))


def _ring(topology: Collapsed, vertex: int) -> list[_Passage] | None:
    """Faces around a vertex in their order; None where they are no one ring."""
    passages = {own.into: own for own in _passages(topology, vertex)}
    if not passages:
        return None
    ring = [next(iter(passages.values()))]
    while ring[-1].out != ring[0].into:
        if ring[-1].out not in passages or len(ring) > len(passages):
            return None
        ring.append(passages[ring[-1].out])
    return ring if len(ring) == len(passages) and len({own.face for own in ring}) == len(ring) else None


def _passages(topology: Collapsed, vertex: int) -> Iterator[_Passage]:
    for face, loops in topology.loops.items():
        for loop in loops:
            for (k, ahead), (after, _) in zip(loop, loop[1:] + loop[:1], strict=True):
                if topology.edges[k].ends[1 if ahead else 0] == vertex:
                    yield _Passage(face, k, after)


def _score(  # noqa: PLR0917
    solid: Solid, topology: Collapsed, vertex: int, ring: list[_Passage], j: int, way: FloatArray
) -> float:
    """How clearly an edge along `way`, to where face j of the ring is cut off, goes into both faces beside it."""
    before, own, after = ring[j - 1], ring[j], ring[(j + 1) % len(ring)]
    length = np.linalg.norm(way)
    if length == 0.0:
        return -1.0
    seen = [
        (before.face, before.into, -1.0),  # from the vertex, at the edges that stay there
        (after.face, after.out, -1.0),
        (before.face, own.into, 1.0),  # from where it is cut off, at the edges of the face there
        (after.face, own.out, 1.0),
    ]
    towards = sum(sign * float(_inward(solid, topology, vertex, face, k) @ way) / length for face, k, sign in seen)
    return -float(towards)


def _inward(solid: Solid, topology: Collapsed, vertex: int, face: int, k: int) -> FloatArray:
    """Unit direction into a face from one of its edges, near a vertex."""
    edge = topology.edges[k]
    rows = (0, 1) if edge.ends[0] == vertex else (-2, -1)
    ahead = next(way for loop in topology.loops[face] for number, way in loop if number == k)
    along = (edge.places[rows[1]] - edge.places[rows[0]]) * (1.0 if ahead else -1.0)
    surface = solid.faces[face].surface
    normal = surface.normals(surface.project(edge.places[rows[0] : rows[0] + 1]))[0]
    found: FloatArray = np.cross(normal, along)
    return found / np.linalg.norm(found)


def _part(topology: Collapsed, vertex: int, three: list[_Passage], cut_off: FloatArray, rest: FloatArray) -> int:
    """Give the middle one of three faces around a vertex a vertex of its own; its number."""
    before, own, after = three
    other = max(topology.vertices) + 1
    topology.vertices[other] = topology.vertices[vertex]
    for k in (own.into, own.out):
        edge = topology.edges[k]
        ends = tuple(other if v == vertex else v for v in edge.ends)
        topology.edges[k] = replace(edge, ends=(ends[0], ends[1]))
    share = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    number = len(topology.edges)
    topology.edges.append(
        SharpEdge(ends=(vertex, other), faces=(before.face, after.face), places=rest + share * (cut_off - rest))
    )
    for passage, ahead in ((before, True), (after, False)):
        for loop in topology.loops[passage.face]:
            for at, (k, way) in enumerate(loop):
                ends = topology.edges[k].ends
                if k == passage.into and ends[1 if way else 0] in (vertex, other):
                    loop.insert(at + 1, (number, ahead))
                    break
    return other


__all__ = ["part_vertex"]
