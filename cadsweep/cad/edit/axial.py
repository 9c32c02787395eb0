"""What a cell has beside plane faces along three directions: its features, where they are, and which way they can go.

Place in the flow: read once for :mod:`.regions`, which parts features by planes, and :mod:`.boxes`, which puts a box
around every one of them.

Method: a feature is what hangs together of edges in the way and of faces that not every direction suits. Bores that
cross are several: the places where they do (:mod:`.crossings`), and what each of them is beyond these.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Torus

from ...arrays import FloatArray
from ...brep import Face, Solid
from ..shapes import shapes_of
from .axes import Axis, is_hollow
from .crossings import Crossing, find_crossings
from .slots import find_passages
from .together import Together

ALONG, SQUARE = 1e-9, 1e-5
"""One less the cosine of two directions that are one, and the cosine of two that are square to each other."""
EVERY = frozenset(range(3))
Box = tuple[tuple[float, float], ...]
_AXES = {
    GeomAbs_Cylinder: lambda adaptor: adaptor.Cylinder(),
    GeomAbs_Cone: lambda adaptor: adaptor.Cone(),
    GeomAbs_Torus: lambda adaptor: adaptor.Torus(),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Cluster:
    """What a cell has beside plane faces: where it is, and which directions suit it.

    Attributes
    ----------
    spans : three pairs of float
        Its reach along every normal.
    ways : frozenset of int
        Normals along which it can be swept.
    edges : frozenset of int
        Edges of the cell that belong to it.
    axes : frozenset of int
        The lines of both bores of a place where two cross, that of one beyond all such places; else none.
    rounded : frozenset of int
        Quarters of cylinders, and what is between them, that can be swept along its way as the edge of a cap alone.
    """

    spans: Box
    ways: frozenset[int]
    edges: frozenset[int]
    axes: frozenset[int] = frozenset()
    rounded: frozenset[int] = frozenset()

    @property
    def is_crossing(self) -> bool:
        """Whether two bores cross there: nothing is swept through all of it."""
        return len(self.axes) == 2


def make_box(low: FloatArray, high: FloatArray) -> Box:
    """A box of three pairs."""
    return tuple(zip(low.tolist(), high.tolist(), strict=True))


def is_across(face: Face, normal: FloatArray) -> bool:
    """Whether a face is a plane square to a direction."""
    return face.kind == "plane" and abs(float(face.normal @ normal)) > 1.0 - ALONG


def direction_of(solid: Solid, face: Face) -> FloatArray | None:
    """Normal of a plane, or axis of a round face; None for what has none."""
    if face.kind == "plane":
        return face.normal
    holder = shapes_of(solid)
    line = round_axis(holder.faces[face.id])
    return None if line is None else line[1]


def round_axis(shape: Any) -> tuple[FloatArray, FloatArray] | None:
    """A point of the axis of a cylinder, cone or torus, and its direction; None for any other face."""
    adaptor = BRepAdaptor_Surface(shape)
    read = _AXES.get(adaptor.GetType())
    if read is None:
        return None
    axis = read(adaptor).Axis()
    place, direction = axis.Location(), axis.Direction()
    return np.array([place.X(), place.Y(), place.Z()]), np.array([direction.X(), direction.Y(), direction.Z()])


def main_normals(solid: Solid, axes: Sequence[FloatArray | None]) -> FloatArray:
    """Three directions (3, 3) square to each other, those of most area first; less where faces give no two."""
    areas: list[tuple[float, FloatArray]] = []
    for face, axis in zip(solid.faces, axes, strict=True):
        if axis is None:
            continue
        for j, (area, known) in enumerate(areas):
            if abs(axis @ known) > 1.0 - ALONG:
                areas[j] = (area + face.area, known)
                break
        else:
            areas.append((face.area, axis))
    found: list[FloatArray] = []
    for _, normal in sorted(areas, key=lambda one: -one[0]):
        if all(abs(normal @ other) < SQUARE for other in found):
            found.append(normal)
    if len(found) == 2:
        found.append(np.cross(found[0], found[1]))
    return np.array(found)


def _ways(face: Face, axis: FloatArray | None, normals: FloatArray) -> frozenset[int]:
    """Directions along which a face is a wall, or across which it is a cap."""
    if axis is None:
        return EVERY  # spheres and free-form faces say nothing of where to part
    cosines = np.abs(normals @ axis)
    fits = cosines > 1.0 - ALONG
    if face.kind == "plane":
        fits |= cosines < SQUARE
    return frozenset(np.flatnonzero(fits).tolist())


def find_clusters(
    solid: Solid, axes: Sequence[FloatArray | None], normals: FloatArray, flat: float
) -> list[Cluster]:  # fmt: skip
    """List the features of a cell.

    Parameters
    ----------
    solid : Solid
    axes : sequence of (3,) float64 or None
        By face, as :func:`direction_of` gives it.
    normals : (3, 3) float64
        Directions square to each other.
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    suits = [_ways(face, axis, normals) for face, axis in zip(solid.faces, axes, strict=True)]
    picky = {face.id for face in solid.faces if suits[face.id] != EVERY}
    together = Together()
    join = together.join
    for f in sorted(picky):
        join(set(solid.faces[f].edges), set(), {f})
    for edge in solid.edges:
        if edge.dihedral > pi - flat:
            join({edge.id}, {edge.start, edge.end}, picky & set(edge.faces))
    for face in solid.faces:
        # The flat sides of a slot join its round ends.
        ends = picky.intersection(f for e in face.edges for f in hollow_beside(solid, face, e, flat))
        if face.id not in picky and len(ends) > 1:
            join(set(), set(), ends)
    found: list[Cluster] = []
    bores = find_passages(solid)
    crossings = find_crossings(bores)
    for crossing in crossings:
        for i in crossing.axes:
            join(set(), set(), set(bores[crossing.axes[0]].faces | bores[i].faces))
    for edges, faces in together.groups.values():
        ways = _common(suits, faces)
        # What no direction has as walls may be a rounding all around a block: one has it as the edge of a cap.
        around = frozenset[int]() if ways else _common(_rounded(solid, suits, faces), faces)
        if around:
            ways, rounded = around, frozenset(f for f in faces if solid.faces[f].kind != "plane")
            found.append(replace(_cluster(solid, normals, edges, ways), rounded=rounded))
            continue
        own = [] if ways else [c for c in crossings if all(bores[i].faces <= faces for i in c.axes)]
        if not own:
            found.append(_cluster(solid, normals, edges, ways))
            continue
        found += _crossed(solid, normals, edges, bores, own)
        lines = {line for c in own for line in c.lines}
        round_faces = frozenset[int]().union(*(bore.faces for bore in bores if bore.line in lines))
        rest = {e for e in edges if not round_faces.intersection(solid.edges[e].faces)}
        for part in _connected(solid, rest):
            beside = faces.intersection(f for e in part for f in solid.edges[e].faces)
            found.append(_cluster(solid, normals, part, _common(suits, beside)))
    return found


def _rounded(solid: Solid, suits: Sequence[frozenset[int]], faces: Iterable[int]) -> dict[int, frozenset[int]]:
    """Directions that suit some faces, where quarters of cylinders may also be caps across."""
    return {f: EVERY if _is_quarter(solid, solid.faces[f]) else suits[f] for f in faces}


def _is_quarter(solid: Solid, face: Face) -> bool:
    """Whether a face is the part of a cylinder that rounds a square edge, or less."""
    if face.kind != "cylinder":
        return False
    line = round_axis(shapes_of(solid).faces[face.id])
    if line is None:
        return False
    place, direction = line
    at = np.linspace(0.0, 1.0, 9)
    out = np.concatenate([solid.edges[e].curve.evaluate(at) for e in face.edges]) - place
    out -= np.outer(out @ direction, direction)
    out /= np.linalg.norm(out, axis=1)[:, None]
    return float((out @ out.T).min()) > -SQUARE


def _common(suits: Mapping[int, frozenset[int]] | Sequence[frozenset[int]], faces: Iterable[int]) -> frozenset[int]:
    """Directions that suit all of some faces."""
    return EVERY.intersection(*(suits[f] for f in faces))


def _cluster(solid: Solid, normals: FloatArray, edges: Iterable[int], ways: frozenset[int]) -> Cluster:
    own = sorted(edges)
    at = np.linspace(0.0, 1.0, 9)
    along = np.concatenate([solid.edges[e].curve.evaluate(at) for e in own]) @ normals.T
    return Cluster(spans=make_box(along.min(axis=0), along.max(axis=0)), ways=ways, edges=frozenset(own))


def sliced(solid: Solid, normals: FloatArray, axes: Sequence[FloatArray | None], cluster: Cluster) -> list[Cluster]:
    """A feature along its one direction, parted where its outline changes: beside a rib there is only the rounding.

    Parameters
    ----------
    solid : Solid
    normals : (3, 3) float64
    axes : sequence of (3,) float64 or None
        By face, as :func:`direction_of` gives it.
    cluster : Cluster
    """
    if len(cluster.ways) != 1 or cluster.axes:
        return [cluster]
    (way,) = cluster.ways
    picky = {f for e in cluster.edges for f in solid.edges[e].faces if _ways(solid.faces[f], axes[f], normals) != EVERY}
    at = np.linspace(0.0, 1.0, 9)
    # What has an extent along the way: faces, and edges by themselves.
    pieces = [[e] for e in sorted(cluster.edges)] + [list(solid.faces[f].edges) for f in sorted(picky)]
    reach = [np.concatenate([solid.edges[e].curve.evaluate(at) for e in own]) @ normals.T for own in pieces]
    # Roundings of a block's outer corners stand by themselves, with nothing but its sides between them.
    corners = {e for f in picky if _is_outer_quarter(solid, f) for e in solid.faces[f].edges}
    alone = [corners.issuperset(own) for own in pieces]
    near = SQUARE * solid.size
    tall = [k for k, points in enumerate(reach) if np.ptp(points[:, way]) > near]
    ends = np.sort(np.concatenate([[reach[k][:, way].min(), reach[k][:, way].max()] for k in tall] or [[]]))
    levels = ends[np.append(True, np.diff(ends) > near)] if len(ends) else ends
    if len(levels) < 2 or (len(levels) == 2 and not any(alone)):
        return [cluster]
    found = []
    for low, high in pairwise(levels):
        here = [k for k in tall if reach[k][:, way].min() < high - near and reach[k][:, way].max() > low + near]
        for own in _touching([reach[k] for k in here], [alone[k] for k in here], near):
            points = np.concatenate(own)
            points[:, way] = np.clip(points[:, way], low, high)
            spans = make_box(points.min(axis=0), points.max(axis=0))
            found.append(Cluster(spans=spans, ways=cluster.ways, edges=cluster.edges))
    return found


def _is_outer_quarter(solid: Solid, f: int) -> bool:
    """Whether a face rounds an outer edge of the solid."""
    face = solid.faces[f]
    line = round_axis(shapes_of(solid).faces[f])
    if line is None or not _is_quarter(solid, face):
        return False
    return not is_hollow(face, solid.edges[face.edges[0]].midpoint, *line)


def _touching(points: Sequence[FloatArray], alone: Sequence[bool], near: float) -> list[list[FloatArray]]:
    """Point sets (m, 3) in groups: those that stand alone by what their boxes touch, all others in one."""
    groups: list[list[FloatArray]] = [[own for own, is_alone in zip(points, alone, strict=True) if not is_alone]]
    for own, is_alone in zip(points, alone, strict=True):
        if is_alone:
            beside = [g for g in groups if g and _meet(np.concatenate(g), own, near)]
            groups = [g for g in groups if not any(g is other for other in beside)]
            groups.append([own, *(p for g in beside for p in g)])
    return [g for g in groups if g]


def _meet(one: FloatArray, other: FloatArray, near: float) -> bool:
    """Whether the boxes of two sets of points touch."""
    low, high = np.maximum(one.min(axis=0), other.min(axis=0)), np.minimum(one.max(axis=0), other.max(axis=0))
    return bool((low < high + near).all())


def _crossed(
    solid: Solid, normals: FloatArray, edges: Iterable[int], axes: Sequence[Axis], crossings: Sequence[Crossing]
) -> Iterator[Cluster]:
    """The places where bores cross, and what every bore is beyond them."""
    taken: dict[int, list[tuple[Axis, float, float]]] = {}
    for crossing in crossings:
        # The box about each axis, as far as the other one is wide: both have it in common.
        boxes = []
        for i, other, place in zip(crossing.axes, reversed(crossing.axes), crossing.on_axes, strict=True):
            axis, reach = axes[i], axes[other].radius
            at = float((place - axis.place) @ axis.direction)
            first, last = axes[other].span(axis.direction)
            begin, end = at + first - reach, at + last + reach
            boxes.append(_around(normals, axis, begin, end))
            taken.setdefault(axis.line, []).append((axis, begin, end))
        (low, high), (other_low, other_high) = boxes
        spans = make_box(np.minimum(low, other_low), np.maximum(high, other_high))
        yield Cluster(spans=spans, ways=frozenset(), edges=frozenset(), axes=frozenset(crossing.lines))
    for axis in axes:
        places = [_along(axis, *place) for place in taken.get(axis.line, ())]
        if not places:
            continue
        way = np.flatnonzero(np.abs(normals @ axis.direction) > 1.0 - ALONG)
        start = axis.low
        for place, end in (*sorted(places), (axis.high, axis.high)):
            begin = min(place, axis.high)
            if begin > start + SQUARE * solid.size:
                own = (e for e in edges if axis.faces.intersection(solid.edges[e].faces))
                inside = frozenset(
                    e for e in own if start < float((solid.edges[e].midpoint - axis.place) @ axis.direction) < begin
                )
                yield Cluster(
                    spans=make_box(*_around(normals, axis, start, begin)), ways=frozenset(way.tolist()), edges=inside,
                    axes=frozenset([axis.line]),
                )  # fmt: skip
            start = max(start, end)


def _along(axis: Axis, other: Axis, low: float, high: float) -> tuple[float, float]:
    """A stretch along one of two axes of one line, along the other."""
    sign = float(np.sign(axis.direction @ other.direction))
    shift = float((other.place - axis.place) @ axis.direction)
    first, last = sorted((shift + sign * low, shift + sign * high))
    return first, last


def _around(normals: FloatArray, axis: Axis, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """The box (3,), (3,) of a piece of a cylinder."""
    ends = np.array([axis.place + t * axis.direction for t in (low, high)]) @ normals.T
    aside = axis.radius * np.sqrt(np.maximum(0.0, 1.0 - (normals @ axis.direction) ** 2))
    first, last = np.sort([np.zeros(3), normals @ axis.spread], axis=0)
    return ends.min(axis=0) + first - aside, ends.max(axis=0) + last + aside


def _connected(solid: Solid, edges: Iterable[int]) -> list[set[int]]:
    """Edges that hang together by their vertices."""
    groups: list[tuple[set[int], set[int]]] = []
    for e in sorted(edges):
        own, vertices = {e}, {solid.edges[e].start, solid.edges[e].end}
        for group in [g for g in groups if g[1] & vertices]:
            groups.remove(group)
            own, vertices = own | group[0], vertices | group[1]
        groups.append((own, vertices))
    return [own for own, _ in groups]


def hollow_beside(solid: Solid, face: Face, edge: int, flat: float) -> list[int]:
    """The faces that a plane face goes on into at an edge, where it bends towards the outside of the material."""
    own = solid.edges[edge]
    if face.kind != "plane" or abs(own.dihedral - pi) > flat:
        return []
    other = own.faces[own.faces[0] == face.id]
    middles = np.array([solid.edges[e].midpoint for e in solid.faces[other].edges])
    return [other] if float(((middles - own.midpoint) @ face.normal).max()) > flat * solid.size else []


__all__ = [
    "ALONG",
    "EVERY",
    "SQUARE",
    "Box",
    "Cluster",
    "direction_of",
    "find_clusters",
    "hollow_beside",
    "is_across",
    "main_normals",
    "make_box",
    "round_axis",
    "sliced",
]
