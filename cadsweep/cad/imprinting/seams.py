"""Seams of coaxial round faces brought to one angle, so that they do not cut each other into strips.

Place in the flow: called by :mod:`.joining` before the fuse. A round face of a full turn has a seam, an edge where its
parameters begin again, at an angle that means nothing. A pin and its hole, or the rings of a pipe's insulation, have
theirs at different angles; fused, each cuts the other's face, and where the angles differ by a degree a strip of a
degree is left.

Method: faces of a full turn that hang together at whole circles are a chain; turned about its axis it is the same
surface. Chains of all solids about one axis get the angle of an edge along the axis that cannot be turned (that of
a half cylinder, say), or else that of the first of them. Plane faces beside a chain get its new circles.

Not handled: faces with holes in them, whole spheres and tori, and faces that solids share from the start; their seams
stay.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan2, cos, pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepTools import BRepTools_ReShape
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

from ...arrays import FloatArray
from ..extract.labels import Labels
from ..heal.validate import faults
from ..shapes import EDGE, FACE, SOLID, VERTEX, compound, explore, index_map, listed, mapped, subshapes, typed

_PARALLEL = 1e-9
"""Sine between two axes, and difference of angles, that are rounding."""
_ALIKE = 1e-14
"""One less the cosine of the angle between the ends of an edge along the axis."""
_SAME_AXIS = 1e-6
"""Distance of two axes, as a share of the part's size, up to which they are one."""

_AXES = {
    GeomAbs_SurfaceType.GeomAbs_Cylinder: lambda surface: surface.Cylinder().Axis(),
    GeomAbs_SurfaceType.GeomAbs_Cone: lambda surface: surface.Cone().Axis(),
    GeomAbs_SurfaceType.GeomAbs_Torus: lambda surface: surface.Torus().Axis(),
    GeomAbs_SurfaceType.GeomAbs_Sphere: lambda surface: gp_Ax1(
        surface.Sphere().Location(), surface.Sphere().Position().Direction()
    ),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class _Axis:
    """A line, its direction with a fixed sign, through the point nearest to the origin."""

    foot: FloatArray
    direction: FloatArray

    def is_same(self, other: _Axis, size: float) -> bool:
        apart = np.linalg.norm(np.cross(self.direction, other.direction))
        return bool(apart < _PARALLEL and np.linalg.norm(self.foot - other.foot) < _SAME_AXIS * size)

    def angle(self, point: FloatArray) -> float | None:
        """Angle of a point about the axis, in a frame that depends on the direction alone; None on the axis."""
        across = np.eye(3)[int(np.argmin(np.abs(self.direction)))]
        x = across - (across @ self.direction) * self.direction
        x /= np.linalg.norm(x)
        arm = point - self.foot
        a, b = float(arm @ x), float(arm @ np.cross(self.direction, x))
        return atan2(b, a) if max(abs(a), abs(b)) > _PARALLEL * (1.0 + float(np.linalg.norm(arm))) else None

    def turn(self, angle: float) -> Any:
        out = gp_Trsf()
        out.SetRotation(gp_Ax1(gp_Pnt(*self.foot), gp_Dir(*self.direction)), angle)
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class _Chain:
    """Faces of one solid of a full turn about an axis, joined at whole circles, and the angle of their seams."""

    solid: int
    faces: list[Any]
    axis: _Axis
    angle: float


class _Beside:
    """The faces at each edge of a solid."""

    def __init__(self, shape: Any) -> None:
        self._found = TopTools_IndexedDataMapOfShapeListOfShape()
        TopExp.MapShapesAndAncestors_s(shape, EDGE, FACE, self._found)

    def around(self, edge: Any) -> list[Any]:
        return [typed(face, FACE) for face in listed(self._found.FindFromKey(edge))]


def align_seams(shapes: Sequence[Any], labels: Sequence[Labels], size: float) -> tuple[list[Any], list[Labels]]:
    """Turn the seams of coaxial round faces of different solids to one angle.

    Parameters
    ----------
    shapes : sequence of TopoDS_Solid
    labels : sequence of Labels
    size : float
        Of the part.

    Returns
    -------
    list of TopoDS_Solid
        The same solids; those whose seams stand right, the same shapes.
    list of Labels
        For the order of their faces and edges.
    """
    chains: list[_Chain] = []
    fixed: list[tuple[_Axis, float]] = []
    used = _Used(shapes)
    for i, shape in enumerate(shapes):
        found, stay = _chains(i, shape, size, used)
        chains += found
        fixed += stay
    if not chains:
        return list(shapes), list(labels)
    for shape in shapes:
        fixed += _fixed_angles(shape)
    turns: list[list[tuple[_Chain, float]]] = [[] for _ in shapes]
    for group in _by_axis(chains, size):
        axis = group[0].axis
        held = [angle for other, angle in fixed if other.is_same(axis, size)]
        wanted = held[0] if held else group[0].angle
        for chain in group:
            # Of two edges half a turn apart either will do: closed faces are halved there.
            off = (wanted - chain.angle + pi / 2) % pi - pi / 2
            if abs(off) > _PARALLEL and (held or len({one.solid for one in group}) > 1):
                turns[chain.solid].append((chain, off))
    out, out_labels = list(shapes), list(labels)
    for i, own in enumerate(turns):
        if own:
            turned = _turned(shapes[i], own)
            if turned is not None:
                out[i], out_labels[i] = turned[0], _followed(shapes[i], turned[0], turned[1], labels[i])
    return out, out_labels


class _Used:
    """How many solids each face bounds; what two share from the start cannot be turned in one of them."""

    def __init__(self, shapes: Sequence[Any]) -> None:
        self._found = index_map(compound(shapes), FACE)
        self._counts = Counter(self._found.FindIndex(face) for shape in shapes for face in subshapes(shape, FACE))

    def once(self, face: Any) -> bool:
        return self._counts[self._found.FindIndex(face)] == 1


def _chains(number: int, shape: Any, size: float, used: _Used) -> tuple[list[_Chain], list[tuple[_Axis, float]]]:
    """Chains of a solid that can be turned, and the seams of those that cannot."""
    fixed: list[tuple[_Axis, float]] = []
    rings: list[tuple[Any, _Axis]] = []
    for face in subshapes(shape, FACE):
        axis = _axis(face)
        if axis is not None and _is_full_ring(face):
            rings.append((face, axis))
    if not rings:
        return [], []
    beside = _Beside(shape)
    numbers = index_map(compound([face for face, _ in rings]), FACE)
    chains = []
    left = set(range(len(rings)))
    while left:
        face, axis = rings[min(left)]
        members = _linked(min(left), rings, beside, numbers)
        left -= members
        around = [other for k in members for circle in _circles(rings[k][0]) for other in beside.around(circle)]
        free = all(
            used.once(other) and (_is_plane(other) or numbers.FindIndex(other) - 1 in members) for other in around
        )
        angle = _seam_angle(face, axis)
        if angle is not None and free and all(rings[k][1].is_same(axis, size) for k in members):
            chains.append(_Chain(solid=number, faces=[rings[k][0] for k in sorted(members)], axis=axis, angle=angle))
        elif angle is not None:
            fixed.append((axis, angle))
    return chains, fixed


def _fixed_angles(shape: Any) -> Iterator[tuple[_Axis, float]]:
    """The angles of edges along an axis that cannot be turned."""
    for face in subshapes(shape, FACE):
        axis = _axis(face)
        if axis is not None and not _is_full_ring(face):
            yield from ((axis, angle) for angle in _axial_angles(face, axis))


def _linked(first: int, rings: Sequence[tuple[Any, _Axis]], beside: _Beside, numbers: Any) -> set[int]:
    """Rings that hang together with one at their circles."""
    found, queue = {first}, [first]
    while queue:
        for circle in _circles(rings[queue.pop()][0]):
            for other in beside.around(circle):
                k = numbers.FindIndex(other) - 1
                if k >= 0 and k not in found:
                    found.add(k)
                    queue.append(k)
    return found


def _axis(face: Any) -> _Axis | None:
    surface = BRepAdaptor_Surface(face)
    read = _AXES.get(surface.GetType())
    if read is None:
        return None
    line = read(surface)
    place, along = line.Location(), line.Direction()
    direction = np.array([along.X(), along.Y(), along.Z()])
    direction *= np.sign(direction[int(np.argmax(np.abs(direction) > 0.5))]) or 1.0
    origin = np.array([place.X(), place.Y(), place.Z()])
    return _Axis(foot=origin - (origin @ direction) * direction, direction=direction)


def _is_full_ring(face: Any) -> bool:
    """Whether a face goes once around, between whole circles or poles, with one seam and nothing else."""
    seams = 0
    for edge in subshapes(face, EDGE):
        if BRep_Tool.IsClosed_s(edge, face):
            seams += 1
        elif not _is_circle(edge):
            return False
    return seams == 1


def _is_circle(edge: Any) -> bool:
    return len(subshapes(edge, VERTEX)) == 1 and BRepAdaptor_Curve(edge).GetType() == GeomAbs_CurveType.GeomAbs_Circle


def _is_plane(face: Any) -> bool:
    return bool(BRepAdaptor_Surface(face).GetType() == GeomAbs_SurfaceType.GeomAbs_Plane)


def _circles(face: Any) -> list[Any]:
    return [edge for edge in subshapes(face, EDGE) if not BRep_Tool.IsClosed_s(edge, face)]


def _seam_angle(face: Any, axis: _Axis) -> float | None:
    return next(
        (angle for vertex in subshapes(face, VERTEX) if (angle := axis.angle(_point(vertex))) is not None), None
    )


def _axial_angles(face: Any, axis: _Axis) -> Iterator[float]:
    """Angles of the edges of a face that run along the axis."""
    for edge in explore(face, EDGE):
        if BRep_Tool.Degenerated_s(edge):
            continue
        first, *others = [axis.angle(_point(vertex)) for vertex in subshapes(edge, VERTEX)]
        if first is not None and others and others[0] is not None and abs(cos(first - others[0]) - 1.0) < _ALIKE:
            yield first


def _by_axis(chains: Sequence[_Chain], size: float) -> list[list[_Chain]]:
    groups: list[list[_Chain]] = []
    for chain in chains:
        group = next((one for one in groups if one[0].axis.is_same(chain.axis, size)), None)
        if group is None:
            groups.append([chain])
        else:
            group.append(chain)
    return groups


def _turned(shape: Any, turns: Sequence[tuple[_Chain, float]]) -> tuple[Any, BRepTools_ReShape] | None:
    """A solid with chains of its faces turned; None where OpenCASCADE does not make a valid one of it."""
    reshape = BRepTools_ReShape()
    for chain, angle in turns:
        tool = BRepBuilderAPI_Transform(compound(chain.faces), chain.axis.turn(angle), True)
        for sub in (*chain.faces, *(circle for face in chain.faces for circle in _circles(face))):
            reshape.Replace(_forward(sub), _forward(tool.ModifiedShape(sub)))
    turned = typed(reshape.Apply(shape), SOLID)
    counts = [len(subshapes(turned, kind)) == len(subshapes(shape, kind)) for kind in (FACE, EDGE, VERTEX)]
    return (turned, reshape) if all(counts) and not faults(turned) else None


def _forward(shape: Any) -> Any:
    return shape.Oriented(TopAbs_Orientation.TopAbs_FORWARD)


def _followed(shape: Any, turned: Any, reshape: BRepTools_ReShape, labels: Labels) -> Labels:
    """Labels in the order of the turned solid."""
    out: list[list[Any]] = []
    for kind, old in ((FACE, labels.faces), (EDGE, labels.edges)):
        found = index_map(turned, kind)
        places = [found.FindIndex(reshape.Apply(sub)) - 1 for sub in mapped(index_map(shape, kind), kind)]
        order = dict(zip(places, old, strict=True))
        # A seam is turned with its face, and has no image of its own.
        left = iter([label for place, label in zip(places, old, strict=True) if place < 0])
        out.append([order[j] if j in order else next(left) for j in range(found.Extent())])
    return Labels(*out)


def _point(vertex: Any) -> FloatArray:
    point = BRep_Tool.Pnt_s(vertex)
    return np.array([point.X(), point.Y(), point.Z()])
