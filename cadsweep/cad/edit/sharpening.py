"""A solid without its blends, built anew from the faces that stay: no boolean, no intersection of shapes.

Place in the flow: the first way of :mod:`.design`; OpenCASCADE's defeaturing has what is left.

Method: the topology is known beforehand (:mod:`.collapsing`). Every vertex lies where the surfaces around it meet and
every edge where its two do: Newton's method from about there, by the least step, so that tangent surfaces are met where
they are touched. Curves are lines and circles where they can be. What is as it was is a copy of the solid's
own: the solid itself is as it was, whatever becomes of what is built.

Not handled: surfaces that end before they meet; faces with degenerate edges whose other edges change.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from itertools import combinations
from typing import Any, TypeVar

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_MakeEdge
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_Circle, Geom_Line
from OCP.GeomAbs import GeomAbs_Shape
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.ShapeFix import ShapeFix_Edge, ShapeFix_Wire
from OCP.TColgp import TColgp_Array1OfPnt
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid, TopoDS_Vertex, TopoDS_Wire

from ...arrays import FloatArray
from ...brep import Edge, Solid, Surface
from ..heal.validate import faults
from ..shapes import EDGE, FACE, VERTEX, SolidShape, shapes_of, typed
from .collapsing import TANGENT, CannotCloseError, Collapsed, Rounding, SharpEdge, collapse
from .parting import part_vertex

Item = TypeVar("Item")
Made = TypeVar("Made")
_STEPS = 12
"""Steps of Newton's method."""
_CLOSE = 1e-6
"""Share of the solid's size within which surfaces meet."""
_FLAT = 0.1
"""Share of that within which places are on a line or circle."""
_EXACT = 1e-4
"""Share of it at which Newton's method ends."""
_STEP = 1e-4
"""Share of an edge over which its tangent is measured."""
_PARALLEL = 1e-3
"""Share of the largest singular value below which normals are taken for parallel."""
_FORWARD, _REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED


class Sharpened:
    """What :func:`sharpen` built.

    Attributes
    ----------
    shape : TopoDS_Solid
    faces, edges : dict of int to shape
        What faces and edges of the model became, by id.
    """

    def __init__(self, shape: Any, faces: dict[int, Any], edges: dict[int, Any]) -> None:
        self.shape, self.faces, self.edges = shape, faces, edges


Met = dict[tuple[tuple[int, ...], bytes], FloatArray | None]
"""Where faces meet near places, or that they do not: what one solid after the other need not look for again."""


def sharpen(solid: Solid, blends: Sequence[Rounding], met: Met) -> Sharpened:
    """Build a solid without its blends; `met` is of the same solid without others, and grows.

    Raises
    ------
    CannotCloseError
        The faces of some blends that have to stay.
    """
    topology = collapse(solid, blends)
    gone = {f for blend in blends for f in blend.faces}
    found = _Building(solid, topology, gone, met).built()
    if faults(found.shape):
        wrong = [f for f, face in found.faces.items() if faults(face)]
        beside = {g for f in wrong for e in solid.faces[f].edges for g in solid.edges[e].faces if g in gone}
        raise CannotCloseError(beside or gone, "the faces around it would cross")
    return found


class _Building:
    def __init__(self, solid: Solid, topology: Collapsed, gone: set[int], met: Met) -> None:
        self.solid, self.topology, self.gone, self.met = solid, topology, gone, met
        self.holder = _copied(shapes_of(solid))
        self.own = set(map(id, self.holder.edges))
        self.close = max(_CLOSE * solid.size, solid.tolerance)
        self.walls: defaultdict[tuple[int, ...], list[_Wall]] = defaultdict(list)
        for edge in solid.edges:
            if abs(edge.dihedral - np.pi) < TANGENT:
                self.walls[tuple(sorted(edge.faces))].append(_Wall(solid, edge))
        self.blends_at: dict[int, set[int]] = {}
        for edge in solid.edges:
            for v in (edge.start, edge.end):
                self.blends_at.setdefault(v, set()).update(f for f in edge.faces if f in gone)

    def built(self) -> Sharpened:
        self._of_all(list(self.topology.vertices), self._part)
        places = dict(zip(self.topology.vertices, self._of_all(self.topology.vertices, self._vertex), strict=True))
        vertices = {v: self._vertex_shape(v, place) for v, place in places.items()}
        edges = self._of_all(self.topology.edges, lambda edge: self._edge(edge, places, vertices))
        builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
        builder.MakeShell(shell)
        faces = {f: self._face(f, loops, edges) for f, loops in self.topology.loops.items()}
        for face in faces.values():
            builder.Add(shell, face)
        shell.Closed(True)
        builder.MakeSolid(solid)
        builder.Add(solid, shell)
        BRepLib.SameParameter_s(solid, self.close, False)
        kept = {edge.origin: edges[k] for k, edge in enumerate(self.topology.edges) if edge.origin is not None}
        return Sharpened(solid, faces, kept)

    @staticmethod
    def _of_all(items: Iterable[Item], make: Callable[[Item], Made]) -> list[Made]:
        """What is made of all items; those that cannot be are refused together, each costs another solid."""
        found, refused = list[Made](), list[CannotCloseError]()
        for item in items:
            try:
                found.append(make(item))
            except CannotCloseError as error:
                refused.append(error)
        if refused:
            why = ", ".join(dict.fromkeys(map(str, refused)))
            raise CannotCloseError({f for error in refused for f in error.faces}, why)
        return found

    def _around(self, vertex: int) -> set[int]:
        """Faces of blends that a vertex is where it is because of."""
        return {f for v in self.topology.vertices[vertex] for f in self.blends_at[v]}

    def _part(self, vertex: int) -> None:
        """Part a vertex whose faces do not meet in a point."""
        if not self._around(vertex):
            return
        place = self.solid.vertices[self.topology.vertices[vertex]].mean(axis=0)
        beside = {f for edge in self.topology.edges if vertex in edge.ends for f in edge.faces}
        if self._meet(beside, place) is None and not part_vertex(self.solid, self.topology, vertex, place, self._meet):
            raise CannotCloseError(self._around(vertex), "the faces around it do not meet in a point")

    def _vertex(self, vertex: int) -> FloatArray:
        place: FloatArray = self.solid.vertices[self.topology.vertices[vertex]].mean(axis=0)
        if not self._around(vertex):
            return place
        found = self._meet({f for edge in self.topology.edges if vertex in edge.ends for f in edge.faces}, place)
        if found is None:
            raise CannotCloseError(self._around(vertex), "the faces around it do not meet in a point")
        return found

    def _meet(self, faces: Collection[int], place: FloatArray) -> FloatArray | None:
        """Where faces meet near a place (3,)."""
        key = (tuple(sorted(faces)), place.tobytes())
        if key not in self.met:
            found, off = _meeting(self._surfaces(faces), place[None], _EXACT * self.close)
            self.met[key] = found[0] if off[0] <= self.close else None
        return self.met[key]

    def _surfaces(self, faces: Collection[int]) -> list[Surface | _Wall]:
        """Surfaces of faces, and the walls on smooth edges between these."""
        own = sorted(faces)
        walls = [wall for pair in combinations(own, 2) for wall in self.walls[pair]]
        return [*(self.solid.faces[f].surface for f in own), *walls]

    def _vertex_shape(self, vertex: int, place: FloatArray) -> Any:
        if not self._around(vertex):
            return self.holder.vertices[vertex]
        found = TopoDS_Vertex()
        BRep_Builder().MakeVertex(found, gp_Pnt(*place.tolist()), self.close)
        return found

    def _edge(self, edge: SharpEdge, places: dict[int, FloatArray], vertices: dict[int, Any]) -> Any:
        why = set(edge.blend) | self._around(edge.ends[0]) | self._around(edge.ends[1])
        if edge.origin is not None and not why:
            return self.holder.edges[edge.origin]
        first, last = (places[v] for v in edge.ends)
        share = np.linspace(0.0, 1.0, len(edge.places))[:, None]
        about = edge.places + (1.0 - share) * (first - edge.places[0]) + share * (last - edge.places[-1])
        if len(set(edge.faces)) < 2:
            raise CannotCloseError(why, "a face would lie on both sides of an edge")
        found, off = _meeting(self._surfaces(edge.faces), about, _EXACT * self.close)
        found[[0, -1]] = first, last
        if not off[1:-1].max() <= self.close:
            raise CannotCloseError(why, "the faces beside it do not meet")
        if (np.diff(found, axis=0) * np.diff(edge.places, axis=0)).sum(axis=1).min() <= 0.0:
            raise CannotCloseError(why, "the faces around it would turn round")
        curve, low, high = _curve(found, _FLAT * self.close)
        maker = BRepBuilderAPI_MakeEdge(curve, *(vertices[v] for v in edge.ends), low, high)
        if not maker.IsDone():
            raise CannotCloseError(why, "an edge beside it has no curve")
        return maker.Edge()

    def _face(self, f: int, loops: list[list[tuple[int, bool]]], edges: list[Any]) -> Any:
        old = self.holder.faces[f]
        if {id(edges[k]) for loop in loops for k, _ in loop} <= self.own:
            return old
        forward = old.Orientation() == _FORWARD
        face = typed(typed(old.Oriented(_FORWARD), FACE).EmptyCopied(), FACE)
        builder = BRep_Builder()
        for loop in loops:
            wire = TopoDS_Wire()
            builder.MakeWire(wire)
            for k, ahead in loop if forward else loop[::-1]:
                builder.Add(wire, edges[k].Oriented(_FORWARD if ahead == forward else _REVERSED))
                ShapeFix_Edge().FixAddPCurve(edges[k], face, False, self.close)
            wire.Closed(True)
            fix = ShapeFix_Wire(wire, face, self.close)
            fix.FixShifted()
            builder.Add(face, wire)
        return face.Oriented(old.Orientation())


def _copied(holder: SolidShape) -> SolidShape:
    """The same shapes once more: what is built shares edges with what stays, and their curves on it are changed."""
    tool = BRepBuilderAPI_Copy(holder.shape)

    def copies(shapes: list[Any], kind: TopAbs_ShapeEnum) -> list[Any]:
        return [typed(tool.ModifiedShape(shape).Oriented(shape.Orientation()), kind) for shape in shapes]

    return SolidShape(
        shape=tool.Shape(),
        faces=copies(holder.faces, FACE),
        edges=copies(holder.edges, EDGE),
        vertices=copies(holder.vertices, VERTEX),
    )


class _Wall:
    """What stands upright on a smooth edge: the surfaces of two tangent faces alone do not tell where they meet.

    Beyond the ends of the edge it goes straight on.
    """

    def __init__(self, solid: Solid, edge: Edge) -> None:
        self.curve, self.surface = edge.curve, solid.faces[edge.faces[0]].surface

    def project(self, points: FloatArray) -> FloatArray:
        """The points (m, 3) themselves, which are their parameters."""
        return points

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """The nearest points (m, 3)."""
        normals = self.normals(uv)
        found: FloatArray = uv - ((uv - self.curve.nearest(uv)) * normals).sum(axis=1, keepdims=True) * normals
        return found

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3)."""
        at = np.clip(self.curve.project(uv), _STEP, 1.0 - _STEP)
        along = self.curve.evaluate(at + _STEP) - self.curve.evaluate(at - _STEP)
        found = np.cross(along, self.surface.normals(self.surface.project(self.curve.evaluate(at))))
        return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))


def _meeting(surfaces: Sequence[Surface | _Wall], points: FloatArray, close: float) -> tuple[FloatArray, FloatArray]:
    """Where surfaces meet near points (m, 3), and how far (m,) these places are off them at most."""
    found = np.array(points)
    for _ in range(_STEPS):
        normals, offsets = np.empty((2, len(found), len(surfaces), 3))
        for k, surface in enumerate(surfaces):
            uv = surface.project(found)
            normals[:, k], offsets[:, k] = surface.normals(uv), found - surface.evaluate(uv)
        heights = (normals * offsets).sum(axis=2)
        if abs(heights).max() <= close:
            break
        found -= (np.linalg.pinv(normals, rcond=_PARALLEL) @ heights[..., None])[..., 0]
    return found, np.linalg.norm(offsets, axis=2).max(axis=1)


def _curve(points: FloatArray, close: float) -> tuple[Any, float, float]:
    """A curve through points (m, 3) and its range: a line or an arc of a circle where all are on one."""
    first, last = points[0], points[-1]
    chord = last - first
    length = float(np.linalg.norm(chord))
    if length > 0.0 and _off_line(points, first, chord / length).max() <= close:
        return Geom_Line(gp_Pnt(*first.tolist()), gp_Dir(*chord.tolist())), 0.0, length
    middle = points[len(points) // 2]
    a, b = middle - first, last - first
    axis = np.cross(a, b)
    if np.linalg.norm(axis) > close * max(np.linalg.norm(a), np.linalg.norm(b)):
        centre = first + np.cross(axis, b * (a @ a) - a * (b @ b)) / (-2.0 * (axis @ axis))
        axis /= np.linalg.norm(axis)
        offsets = points - centre
        radius = float(np.linalg.norm(offsets[0]))
        off = np.hypot(np.linalg.norm(offsets - np.outer(offsets @ axis, axis), axis=1) - radius, offsets @ axis)
        if off.max() <= close:
            x = offsets[0] / radius
            frame = gp_Ax2(gp_Pnt(*centre.tolist()), gp_Dir(*axis.tolist()), gp_Dir(*x.tolist()))
            turn = float(np.arctan2(offsets[-1] @ np.cross(axis, x), offsets[-1] @ x)) % (2.0 * np.pi)
            return Geom_Circle(frame, radius), 0.0, turn
    array = TColgp_Array1OfPnt(1, len(points))
    for j, point in enumerate(points.tolist()):
        array.SetValue(j + 1, gp_Pnt(*point))
    spline = GeomAPI_PointsToBSpline(array, 3, 8, GeomAbs_Shape.GeomAbs_C2, close).Curve()
    return spline, spline.FirstParameter(), spline.LastParameter()


def _off_line(points: FloatArray, place: FloatArray, along: FloatArray) -> FloatArray:
    offsets = points - place
    found: FloatArray = np.linalg.norm(offsets - np.outer(offsets @ along, along), axis=1)
    return found


__all__ = ["Sharpened", "sharpen"]
