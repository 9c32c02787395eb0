"""Surfaces that may part a cell: faces at re-entrant edges extended, rims carried into the material.

Place in the flow: the search for cuts asks for the cutters of a cell that no sweep fits; :mod:`.cutting` applies one.

Method. At an edge where the solid is re-entrant, or that was imprinted on a face, the surfaces beside it are extended
through the cell (planes, cylinders, cones), and the rims of plane faces are carried into the material square to them.
What belongs together is tried together first: all floors across one direction, all walls along it.

A neighbour's faces at such an edge are extended, too: an arm that ends on a round post imprints a patch on its one
side, and the post gives no surface there that would part it.

What goes across the axis of a turned body is parted first, all at once (:mod:`.strips`, :mod:`.spokes`). Planes through
the middle of round faces (:mod:`.central`) come next where those end in a point, else last; planes at crossings
(:mod:`.crossings`) before what faces give, boxes under circles (:mod:`.cushions`) after it.

Not handled: spheres, tori and free-form faces are not extended; their rims are carried where they lie on planes.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from math import inf, pi
from operator import itemgetter
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane
from OCP.gp import gp_Pln, gp_Pnt, gp_Vec

from ... import rows
from ...arrays import FloatArray
from ...brep import Edge, Face, Part, Solid
from ..shapes import FACE, shapes_of, subshapes
from .around_bores import around_bores
from .beside_holes import beside_holes
from .boxes import around_features
from .central import Cutter, plane_tool, through_axes, through_centers
from .crossings import at_crossings
from .cushions import under_rims
from .families import family
from .grids import on_grid
from .mitres import at_mitres
from .ports import at_ports
from .regions import into_boxes
from .spokes import along_spokes
from .stars import from_inside
from .strips import along_features

FLAT = 1e-4
"""Radians from pi up to which two faces at an edge are one surface: OpenCASCADE's own tangency is about 1e-4."""
SAME = 1e-6
"""Distance, as a share of the cell's size, up to which two cutters are one."""
MOST_CUTTERS = 24
"""Cutters of one cell at edges in the way that are tried."""
TOWARDS_CUT = 0.5
"""Price of rims that are carried on to a cut."""
MOST_BETWEEN = 4
"""Planes between its holes that are tried before these."""
MOST_NORMALS = 12
"""Directions in which gaps between holes are looked for."""


@dataclass(kw_only=True, eq=False)
class _Found:
    """A surface extended through the cell, and the edges in the way that it goes through."""

    key: tuple[float, ...]
    kind: str
    label: str
    tools: tuple[Any, ...]
    along: FloatArray | None
    across: FloatArray | None
    edges: dict[int, float] = field(default_factory=dict)


def extended_face(solid: Solid, face: int) -> tuple[Any, ...]:
    """A face's surface extended through the solid; none where it is of a kind that is not extended."""
    made = _Cutters(solid, frozenset()).surface_of(solid, solid.faces[face])
    return () if made is None else made.tools


def find_cutters(part: Part, cell: int, faces: Collection[int] = ()) -> Iterator[Cutter]:
    """What may part a cell, the most promising first; the others are made when they are asked for.

    Parameters
    ----------
    part : Part
    cell : int
    faces : collection of int
        Faces of the cell on which its sweeps contradict its neighbours': their outlines are in the way, too.
    """
    solid = part.solids[cell]
    own = {int(key): e for e, key in enumerate(solid.edge_keys)} if len(part.solids) > 1 else {}
    beside: dict[int, list[tuple[Solid, Face]]] = {}
    for j, other in enumerate(part.solids):
        if j == cell:
            continue
        for edge, key in zip(other.edges, other.edge_keys, strict=True):
            if int(key) in own:
                beside.setdefault(own[int(key)], []).extend((other, other.faces[f]) for f in edge.faces)
    return _Cutters(solid, frozenset(faces), beside).all()


class _Cutters:
    """The cutters of one cell; `beside` are the neighbours' faces at its edges."""

    def __init__(
        self, solid: Solid, faces: frozenset[int], beside: Mapping[int, Sequence[tuple[Solid, Face]]] | None = None
    ) -> None:
        self.solid = solid
        self.beside = beside or {}
        self.center = solid.vertices.mean(axis=0)
        self.reach = 1.5 * solid.size
        self.faces = faces
        self.found: list[_Found] = []
        self.sums: list[tuple[int, float, float]] = []

    def all(self) -> Iterator[Cutter]:
        """Strips of a turned body, then planes between holes that go different ways, then batches and single ones."""
        solid = self.solid
        is_whole = all(face.key for face in solid.faces)
        if is_whole:
            turned = [*family("strips", lambda: along_features(solid, FLAT))]
            turned = turned or [*family("spokes", lambda: along_spokes(solid, FLAT))]
            yield from turned or family("ports", lambda: at_ports(solid))
        yield from family("centres", lambda: through_centers(solid))
        parted, is_well = into_boxes(solid, FLAT) if rows.is_on("cut: regions") else ([], False)
        boxes = [*family("gaps", self.between), *family("regions", lambda: parted)]
        if is_well:
            yield from boxes
        if is_whole:
            boxed = [*family("boxes", lambda: around_features(solid, FLAT))]
            yield from boxed or family("grids", lambda: on_grid(solid, FLAT))
        if not is_well:
            yield from boxes
        yield from family("beside holes", lambda: beside_holes(solid))
        yield from family("mitres", lambda: at_mitres(solid))
        yield from family("around bores", lambda: around_bores(solid))
        yield from family("crossings", lambda: at_crossings(solid))
        rims, others = self.at_edges()
        # A rim that is carried on to a cut divides the cell beyond; a circle can be closed under it instead.
        at_edges, closed = [*rims, *others][:MOST_CUTTERS], family("cushions", lambda: under_rims(solid, FLAT))
        yield from chain(closed, at_edges) if any(rim.price for rim in rims) else chain(at_edges, closed)
        yield from family("axes", lambda: through_axes(solid))
        yield from family("stars", lambda: from_inside(solid))

    def at_edges(self) -> tuple[list[Cutter], list[Cutter]]:
        """Rims carried on at once; batches and single ones of what the surfaces at edges in the way give."""
        for edge in self.solid.edges:
            if self.in_the_way(edge):
                for f in edge.faces:
                    self.extend(self.solid, self.solid.faces[f], edge)
                if edge.dihedral < pi + FLAT:
                    for other, face in self.beside.get(edge.id, ()):
                        self.extend(other, face, edge)
        columns = list(self.columns())
        single = sorted(
            [
                Cutter(
                    kind=one.kind,
                    reason=one.label,
                    tools=one.tools,
                    weight=sum(one.edges.values()),
                    everywhere=one.kind == "plane",
                )
                for one in self.found
            ]
            + columns,
            key=lambda cutter: -cutter.weight,
        )
        others = [*family("batches", lambda: self.batches(columns)), *family("edges", lambda: single)]
        return [*family("rims", self.rims)], others

    def in_the_way(self, edge: Edge) -> bool:
        """Whether the solid is re-entrant there, the edge an imprint, or its face contradicts a neighbour."""
        return edge.dihedral > pi - FLAT or bool(self.faces & set(edge.faces))

    def extend(self, owner: Solid, face: Face, edge: Edge) -> None:
        """Extend the surface of a face, of the cell or of a neighbour, through the cell."""
        made = self.surface_of(owner, face)
        if made is None:
            return
        known = self.alike(made)
        if edge.dihedral > pi + FLAT or known.kind != "plane":
            known.edges[edge.id] = edge.length
        else:
            known.edges.setdefault(edge.id, 0.1 * edge.length)

    def alike(self, made: _Found) -> _Found:
        """What was found first of what is alike; it itself where it is new."""
        near = SAME * max(self.solid.size, 1.0)
        n, total = len(made.key), sum(made.key)
        start = bisect_left(self.sums, (n, total - n * near))  # keys that are alike have sums that are alike
        stop = bisect_right(self.sums, (n, total + n * near, inf))
        for _, _, number in sorted(self.sums[start:stop], key=itemgetter(2)):
            known = self.found[int(number)]
            if np.abs(np.subtract(known.key, made.key)).max() <= near:
                return known
        insort(self.sums, (n, total, float(len(self.found))))
        self.found.append(made)
        return made

    def surface_of(self, owner: Solid, face: Face) -> _Found | None:
        """The tool of a face's surface; None where it is of a kind that is not extended."""
        adaptor = BRepAdaptor_Surface(shapes_of(owner).faces[face.id])
        kind = adaptor.GetType()
        if kind == GeomAbs_Plane:
            plane = adaptor.Plane()
            normal = _array(plane.Axis().Direction())
            offset = float(normal @ _array(plane.Location()))
            normal, offset = _signed(normal, offset)
            foot = self.center - (normal @ self.center - offset) * normal
            moved = gp_Pln(gp_Pnt(*foot), plane.Axis().Direction())
            tool = BRepBuilderAPI_MakeFace(moved, -self.reach, self.reach, -self.reach, self.reach).Face()
            return _Found(
                key=(0.0, *normal, offset), kind="plane", label=f"the plane of {face.label()}", tools=(tool,),
                along=None, across=normal,
            )  # fmt: skip
        if kind == GeomAbs_Cylinder:
            cylinder = adaptor.Cylinder()
            axis, place = _array(cylinder.Axis().Direction()), _array(cylinder.Location())
            middle = float((self.center - place) @ axis)
            first = adaptor.FirstUParameter()
            tools = tuple(
                BRepBuilderAPI_MakeFace(cylinder, u, u + pi, middle - self.reach, middle + self.reach).Face()
                for u in (first, first + pi)
            )
            foot = place - (place @ axis) * axis
            axis, _ = _signed(axis, 0.0)
            return _Found(
                key=(1.0, *axis, *foot, cylinder.Radius()), kind="cylinder", label=f"the cylinder of {face.label()}",
                tools=tools, along=axis, across=None,
            )  # fmt: skip
        if kind == GeomAbs_Cone:
            cone = adaptor.Cone()
            apex = -cone.RefRadius() / np.sin(cone.SemiAngle())
            low, high = adaptor.FirstVParameter(), adaptor.LastVParameter()
            # One nappe: from next to the apex to beyond the cell.
            if 0.5 * (low + high) > apex:
                low, high = apex + 1e-3 * self.reach, max(high, apex) + 2.0 * self.reach
            else:
                low, high = min(low, apex) - 2.0 * self.reach, apex - 1e-3 * self.reach
            first = adaptor.FirstUParameter()
            tools = tuple(BRepBuilderAPI_MakeFace(cone, u, u + pi, low, high).Face() for u in (first, first + pi))
            key = (2.0, *_array(cone.Apex()), cone.SemiAngle())
            return _Found(
                key=key, kind="cone", label=f"the cone of {face.label()}", tools=tools, along=None, across=None
            )
        return None

    def columns(self) -> Iterator[Cutter]:
        """Rims on plane faces carried into the material, square to the face."""
        for face in self.solid.faces:
            if face.kind != "plane":
                continue
            for loop in face.loops:
                edges = [self.solid.edges[e] for e in loop.edges if self.in_the_way(self.solid.edges[e])]
                edges = [e for e in edges if e.kind != "line" or e.dihedral > pi - FLAT]
                if not edges:
                    continue
                tools = [tool for e in edges for tool in self.prism(e, face.normal)]
                weight = sum(e.length for e in edges)
                yield Cutter(
                    kind="rims", reason=f"the rim on {face.label()} carried on", tools=tuple(tools), weight=0.9 * weight
                )

    def prism(self, edge: Edge, normal: FloatArray) -> list[Any]:
        """An edge carried into the material."""
        made = BRepPrimAPI_MakePrism(shapes_of(self.solid).edges[edge.id], gp_Vec(*(-2.0 * self.reach * normal)), True)
        return subshapes(made.Shape(), FACE)

    def rims(self) -> Iterator[Cutter]:
        """The rims on all faces across a direction carried on at once, where that leaves columns along it."""
        for direction in self.directions():
            tools, weight = [], 0.0
            for face in self.solid.faces:
                if face.kind != "plane" or abs(face.normal @ direction) < 1 - 1e-9:
                    continue
                for edge in (self.solid.edges[e] for e in face.edges):
                    if edge.dihedral > pi - FLAT:
                        tools += self.prism(edge, face.normal)
                        weight += edge.length
            if len(tools) > 1:
                place = ", ".join(f"{c:.3g}" for c in direction + 0.0)
                yield Cutter(
                    kind="rims",
                    reason=f"all rims carried on along ({place})",
                    tools=tuple(tools),
                    weight=weight,
                    price=TOWARDS_CUT * self.ends_on_cut(direction),
                )

    def ends_on_cut(self, direction: FloatArray) -> bool:
        """Whether what is carried on along a direction ends on a cut of the cell."""
        return any(
            face.kind == "plane" and not face.key and abs(face.normal @ direction) > 1 - 1e-9
            for face in self.solid.faces
        )

    def batches(self, columns: Sequence[Cutter]) -> Iterator[Cutter]:
        """All floors across a direction at once, and all walls along it."""
        for direction in self.directions():
            floors = [f for f in self.found if f.across is not None and abs(f.across @ direction) > 1 - 1e-9]
            walls = [
                f
                for f in self.found
                if (f.along is not None and abs(f.along @ direction) > 1 - 1e-9)
                or (f.across is not None and abs(f.across @ direction) < 1e-9)
            ]
            for what, members in (("floors", floors), ("walls", walls)):
                own = [f for f in members if any(self.solid.edges[e].dihedral > pi + FLAT for e in f.edges)]
                if len(own) > 1:
                    place = ", ".join(f"{c:.3g}" for c in direction)
                    yield Cutter(
                        reason=f"all {what} {'across' if what == 'floors' else 'along'} ({place})",
                        tools=tuple(tool for f in own for tool in f.tools),
                        weight=sum(sum(f.edges.values()) for f in own),
                    )

    def between(self) -> Iterator[Cutter]:
        """Planes half way between holes that go different ways, the widest gap first."""
        holes = [
            (face.normal, self.feature(face.id, loop.edges))
            for face in self.solid.faces
            if face.kind == "plane"
            for loop in face.loops[1:]
        ]
        normals: list[FloatArray] = []
        for face in self.solid.faces:
            if face.kind == "plane" and not any(abs(face.normal @ known) > 1 - 1e-9 for known in normals):
                normals.append(face.normal)
        found: list[tuple[float, float, FloatArray]] = []
        for normal in normals[:MOST_NORMALS]:
            # A plane square to a hole goes through it without harm.
            spans = sorted(
                (float((p @ normal).min()), float((p @ normal).max()), j)
                for j, (along, p) in enumerate(holes)
                if abs(along @ normal) < 1 - 1e-9
            )
            for j, (_, end, i) in enumerate(spans):
                later = [other for other in spans[j + 1 :] if other[0] > end]
                if not later or any(low < end < high for low, high, _ in spans if high > end):
                    continue
                start, _, k = later[0]
                if abs(holes[i][0] @ holes[k][0]) < 1 - 1e-9:
                    found.append((start - end, 0.5 * (start + end), normal))
        for gap, offset, normal in sorted(found, key=lambda one: -one[0])[:MOST_BETWEEN]:
            tool = plane_tool(self.solid, normal, offset * normal)
            yield Cutter(
                kind="plane",
                reason="a plane between holes that go different ways",
                tools=(tool,),
                weight=gap,
                leads=True,
            )

    def feature(self, base: int, rim: Sequence[int]) -> FloatArray:
        """Points of a hole or a boss, all the way to its floor or to where it comes out again."""
        faces = {f for e in rim for f in self.solid.edges[e].faces} - {base}
        waiting = list(faces)
        while waiting:
            for e in self.solid.faces[waiting.pop()].edges:
                for f in self.solid.edges[e].faces:
                    face = self.solid.faces[f]
                    if f in faces or f == base or (face.kind == "plane" and len(face.loops) > 1):
                        continue
                    faces.add(f)
                    waiting.append(f)
        edges = sorted({e for f in faces for e in self.solid.faces[f].edges})
        at = np.linspace(0.0, 1.0, 9)
        return np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in edges])

    def directions(self) -> list[FloatArray]:
        """Normals of planes and axes of cylinders at edges in the way, the most frequent first."""
        seen: list[tuple[FloatArray, float]] = []
        for one in self.found:
            direction = one.across if one.across is not None else one.along
            if direction is None:
                continue
            for j, (known, weight) in enumerate(seen):
                if abs(known @ direction) > 1 - 1e-9:
                    seen[j] = (known, weight + sum(one.edges.values()))
                    break
            else:
                seen.append((direction, sum(one.edges.values())))
        return [direction for direction, _ in sorted(seen, key=lambda pair: -pair[1])[:3]]


def _array(thing: Any) -> FloatArray:
    return np.array([thing.X(), thing.Y(), thing.Z()])


def _signed(direction: FloatArray, offset: float) -> tuple[FloatArray, float]:
    """A direction and its opposite are one: the first large component is positive."""
    lead = direction[np.argmax(np.abs(direction) > 0.5)]
    return (direction, offset) if lead > 0 else (-direction, -offset)
