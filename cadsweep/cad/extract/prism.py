"""Cells of a plane extruded to a prism, as a ``brep.Solid`` made of data.

Place in the flow: last step of an arrangement. What is over a cell follows from the cell, so OpenCASCADE need not
extrude thousands of them, nor be read again: the edges of the plane are read once, and the top is the bottom, moved.

::

         top[e]            faces, in this order: the sides of the rim, then of every cell its bottom and its top
       +-------->+         edges run the same way at the bottom and at the top, rails run up
    rail    side   rail    loops of a top run as those of its cell, those of a bottom the other way round
       +-------->+
        bottom[e]
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ...arrays import FloatArray
from ...brep import Edge, Face, Loop, Solid
from ...errors import CadError
from ..geometry.affine import carried
from ..geometry.angles import MIDDLE, chain_loops, corner_angles, dihedral_angles
from ..geometry.curves import EdgeCurve, Line, Parametric
from ..geometry.edge_on_face import EdgeOnFace
from ..geometry.face_surface import FaceSurface
from ..geometry.measure import Measure, measure_face
from ..geometry.surfaces import Cone, Frame, Geometry, Plane
from ..geometry.vectors import cross_rows
from ..shapes import bounds, compound
from .flat import is_exact, measure_flat
from .shared import PartGeometry
from .solids import largest_tolerance
from .upright import known_as, limits_of, renumbered, surface_over, turned_round, upright_face

_PANELS, _GAUSS = 8, np.polynomial.legendre.leggauss(8)
_AT = ((np.arange(_PANELS)[:, None] + (_GAUSS[0] + 1.0) / 2.0) / _PANELS).ravel()
_WEIGHTS = np.tile(_GAUSS[1] / (2.0 * _PANELS), _PANELS)
"""Nodes and weights on 0 to 1 for the middle of a line."""


class Prism(NamedTuple):
    """A prism over cells, and where they are in it.

    Attributes
    ----------
    solid : Solid
        Its `kernel` are the :class:`PlaneShapes` of its bottom.
    bottoms, tops : tuple of int
        Faces under and over each cell.
    lower, upper : list of int
        Edges that every line became at the bottom and at the top.
    """

    solid: Solid
    bottoms: tuple[int, ...]
    tops: tuple[int, ...]
    lower: list[int]
    upper: list[int]


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneShapes:
    """OpenCASCADE's edges and vertices of the bottom of a prism, by their ids."""

    edges: dict[int, Any]
    vertices: dict[int, Any]


Wires: TypeAlias = "Sequence[Sequence[tuple[int, bool]]]"
"""Lines that bound a cell, outer wire first, and whether the cell is on their left."""


def extrude_cells(  # noqa: PLR0917
    cells: Sequence[Wires],
    lines: Sequence[Any],
    read: Sequence[tuple[EdgeCurve, str]],
    beside: Sequence[tuple[int, int]],
    plane: Geometry,
    along: FloatArray,
) -> Prism:
    """Make the prism over the cells of a plane.

    Parameters
    ----------
    cells : sequence of Wires
        On the plane, facing along the direction.
    lines : sequence of TopoDS_Edge
        All that bound them.
    read : sequence of (EdgeCurve, str)
        Their curves and kinds.
    beside : sequence of (int, int)
        Cells on the left and on the right of each line, -1 outside.
    plane : Geometry
        Of the bottom; a plane.
    along : (3,) float64
        From the bottom to the top.

    Raises
    ------
    CadError
        The outline of the cells touches itself, or a cell is turned over.
    """
    assert isinstance(plane, Plane)
    return _Extrusion(cells, lines, read, beside, plane, along).prism()


def plane_shapes(prism: Solid) -> PlaneShapes:
    """OpenCASCADE's side of a prism that :func:`extrude_cells` made."""
    holder = prism.kernel
    assert isinstance(holder, PlaneShapes), "it is an arrangement's"
    return holder


class _Extrusion:
    """What is known of the lines and cells of the plane, each by its number, and the ids they take in the prism."""

    def __init__(  # noqa: PLR0917
        self,
        cells: Sequence[Wires],
        lines: Sequence[Any],
        read: Sequence[tuple[EdgeCurve, str]],
        beside: Sequence[tuple[int, int]],
        plane: Plane,
        along: FloatArray,
    ) -> None:
        self.plane, self.along = plane, along
        self.height = float(np.linalg.norm(along))
        self.up = along / self.height
        # The rim first, then as the cells have them.
        rim = [j for j, own in enumerate(beside) if -1 in own]
        met = (j for cell in cells for wire in cell for j, _ in wire)
        order = list(dict.fromkeys([*rim, *met]))
        place = {j: k for k, j in enumerate(order)}
        self.place, self.n_rim = place, len(rim)
        self.shapes = [lines[j] for j in order]
        self.beside = [beside[j] for j in order]
        own = [read[j] for j in order]
        self.shared = PartGeometry(compound(self.shapes), curves=own)
        self.curves, self.kinds = [curve for curve, _ in own], [kind for _, kind in own]
        self.samples, self.ends = self.shared.samples, self.shared.ends
        self.lifted = [self._lifted(curve) for curve in self.curves]
        self.frame = {**dict.fromkeys(range(len(order)), np.broadcast_to(self.up, (3, 3))), MIDDLE: self.up[None]}
        self.loops = self._loops([[[(place[j], left) for j, left in wire] for wire in cell] for cell in cells])
        self._number()

    def _loops(self, cells: Sequence[Wires]) -> list[list[Loop]]:
        """The loops of every cell seen from above, outer loop first."""
        ends = [(start, end) for start, end in self.ends.tolist()]
        tangents = self.samples.end_tangents
        chains = [
            [chain for wire in cell for chain in chain_loops(wire, ends, self.curves, self.frame, tangents)]
            for cell in cells
        ]
        flat = [chain for own in chains for chain in own]
        angles = iter(corner_angles(flat, self.curves, [self.frame] * len(flat), tangents))
        return [
            [Loop(edges=tuple(j for j, _ in c), forward=tuple(way for _, way in c), angles=next(angles)) for c in own]
            for own in chains
        ]

    def _number(self) -> None:
        """Ids of vertices, edges and faces of the prism."""
        self.lower_vertex: dict[int, int] = {}
        self.upper_vertex: dict[int, int] = {}
        self.rails: dict[int, int] = {}
        self.lower: dict[int, int] = {}
        self.upper: dict[int, int] = {}
        n_edges = n_vertices = 0
        for j in range(self.n_rim):
            for v in self.ends[j].tolist():
                if v not in self.rails:
                    self.rails[v], n_edges = n_edges, n_edges + 1
                    self.lower_vertex[v], self.upper_vertex[v], n_vertices = n_vertices, n_vertices + 1, n_vertices + 2
            self.lower[j], self.upper[j], n_edges = n_edges, n_edges + 1, n_edges + 2
        for own in self.loops:
            new = sorted({j for loop in own for j in loop.edges if j not in self.lower})
            corners = [v for v in dict.fromkeys(self.ends[new].ravel().tolist()) if v not in self.lower_vertex]
            for edges, vertices in ((self.lower, self.lower_vertex), (self.upper, self.upper_vertex)):
                edges.update((j, n_edges + k) for k, j in enumerate(new))
                vertices.update((v, n_vertices + k) for k, v in enumerate(corners))
                n_edges, n_vertices = n_edges + len(new), n_vertices + len(corners)
        self.bottoms = tuple(range(self.n_rim, self.n_rim + 2 * len(self.loops), 2))
        self.tops = tuple(f + 1 for f in self.bottoms)

    def prism(self) -> Prism:
        """All of it."""
        faces = [*self._sides(), *self._cells()]
        low = bounds(compound(self.shapes[: self.n_rim]), tight=True)
        corners = np.concatenate([low, low + self.along])
        vertices = np.empty((2 * len(self.lower_vertex), 3))
        for v, place in enumerate(self.shared.positions):
            vertices[self.lower_vertex[v]], vertices[self.upper_vertex[v]] = place, place + self.along
        edges = self._edges()
        shapes = self.shared.vertex_shapes
        solid = Solid(
            vertices=vertices,
            edges=edges,
            faces=tuple(faces),
            volume=self.height * sum(faces[f].area for f in self.tops),
            size=float(np.linalg.norm(np.ptp(corners, axis=0))),
            tolerance=largest_tolerance(compound(self.shapes)),
            kernel=PlaneShapes(
                edges={self.lower[j]: shape for j, shape in enumerate(self.shapes)},
                vertices={self.lower_vertex[v]: shape for v, shape in enumerate(shapes)},
            ),
            vertex_keys=np.arange(len(vertices)),
            edge_keys=np.arange(len(edges)),
            face_keys=np.arange(len(faces)),
        )
        lines = range(len(self.place))
        return Prism(
            solid,
            self.bottoms,
            self.tops,
            [self.lower[self.place[j]] for j in lines],
            [self.upper[self.place[j]] for j in lines],
        )

    def _edges(self) -> tuple[Edge, ...]:
        """Lines at the bottom and at the top, and rails."""
        tangents = self.samples.tangents[:, 1]
        gaps = np.linalg.norm(self.samples.points[:, ::2] - self.shared.vertices[self.ends], axis=2).max(
            axis=1, initial=0.0
        )
        found: dict[int, Edge] = {}
        facing = self._facing()
        for top, ids, ends, own in (
            (False, self.lower, self.lower_vertex, self.bottoms),
            (True, self.upper, self.upper_vertex, self.tops),
        ):
            turned = self.up if top else -self.up
            sides, normals = np.empty((len(self.curves), 2), dtype=np.int64), np.empty((2, len(self.curves), 3))
            for j, (left, right) in enumerate(self.beside):
                for k, cell in enumerate((left, right) if top else (right, left)):
                    sides[j, k] = own[cell] if cell >= 0 else j
                    normals[k, j] = turned if cell >= 0 else facing[j]
            dihedrals = dihedral_angles(tangents, *normals)
            for j, e in ids.items():
                found[e] = Edge(
                    id=e,
                    start=ends[int(self.ends[j, 0])],
                    end=ends[int(self.ends[j, 1])],
                    length=float(self.samples.lengths[j]),
                    kind=self.kinds[j],
                    faces=(int(sides[j, 0]), int(sides[j, 1])),
                    dihedral=float(dihedrals[j]),
                    midpoint=self.samples.points[j, 1] + (self.along if top else 0.0),
                    tangents=self.samples.end_tangents[j],
                    curve=self.lifted[j] if top else self.curves[j],
                    key=f"edge {e}",
                    gap=float(gaps[j]),
                )
        for rail in self._rails():
            found[rail.id] = rail
        return tuple(found[e] for e in range(len(found)))

    def _lifted(self, curve: EdgeCurve) -> EdgeCurve:
        return EdgeCurve(
            geometry=carried(curve.geometry, np.eye(3), self.along),
            first=curve.first,
            last=curve.last,
            breaks=curve.breaks,
            constant_speed=curve.constant_speed,
        )

    def _sense(self, j: int) -> float:
        """1 where the cells lie on the left of a line of the rim."""
        return 1.0 if self.beside[j][0] >= 0 else -1.0

    def _right(self, tangents: FloatArray) -> FloatArray:
        """To the right of tangents (m, 3), seen from above."""
        return cross_rows(tangents, np.broadcast_to(self.up, tangents.shape))

    def _facing(self) -> FloatArray:
        """Normals (n_rim, 3) of the sides at their middles."""
        senses = np.array([self._sense(j) for j in range(self.n_rim)])
        return senses[:, None] * self._right(self.samples.tangents[: self.n_rim, 1])

    def _rails(self) -> list[Edge]:
        """Lines up from the corners of the rim; refuse a corner where the rim comes twice."""
        beside: dict[int, dict[bool, tuple[int, FloatArray]]] = {v: {} for v in self.rails}
        for j in range(self.n_rim):
            sense = self._sense(j)
            for at_end, (v, tangent) in enumerate(
                zip(self.ends[j].tolist(), self.samples.end_tangents[j], strict=True)
            ):
                # A side's loop goes up the rail at the end of its line, as the rim runs.
                goes_up = bool(at_end) == (sense > 0)
                if goes_up in beside[v]:
                    place = ", ".join(f"{c:.4g}" for c in self.shared.positions[v])
                    raise CadError(f"the shadow of the part touches itself at ({place})")
                beside[v][goes_up] = j, sense * self._right(tangent[None])[0]
        vertices = list(self.rails)
        normals = [np.array([beside[v][way][1] for v in vertices]) for way in (True, False)]
        dihedrals = dihedral_angles(np.broadcast_to(self.up, (len(vertices), 3)), *normals)
        return [
            Edge(
                id=self.rails[v],
                start=self.lower_vertex[v],
                end=self.upper_vertex[v],
                length=self.height,
                kind="line",
                faces=(beside[v][True][0], beside[v][False][0]),
                dihedral=float(dihedral),
                midpoint=self.shared.positions[v] + self.along / 2.0,
                tangents=np.array([self.up, self.up]),
                curve=self._rail_curve(v),
                key=f"edge {self.rails[v]}",
            )
            for v, dihedral in zip(vertices, dihedrals, strict=True)
        ]

    def _rail_curve(self, v: int) -> EdgeCurve:
        line = Line(origin=self.shared.positions[v], direction=self.up)
        return EdgeCurve(geometry=line, first=0.0, last=self.height, constant_speed=True)

    def _sides(self) -> list[Face]:
        found = []
        facing = self._facing()
        for j in range(self.n_rim):
            curve, (start, end) = self.curves[j], self.ends[j].tolist()
            geometry, hand = surface_over(curve.geometry, self.up)
            first, last, top = curve.first, curve.last, hand * self.height
            lower, upper, left, right = self.lower[j], self.upper[j], self.rails[start], self.rails[end]
            across, upward = np.array([1.0, 0.0]), np.array([0.0, hand])
            on_side = {
                left: (self._rail_curve(start), Line(origin=np.array([first, 0.0]), direction=upward)),
                right: (self._rail_curve(end), Line(origin=np.array([last, 0.0]), direction=upward)),
                lower: (curve, Line(origin=np.zeros(2), direction=across)),
                upper: (self.lifted[j], Line(origin=np.array([0.0, top]), direction=across)),
            }
            forward = self._sense(j) > 0
            run = (
                ((left, False), (lower, True), (right, True), (upper, False))
                if forward
                else ((left, True), (upper, True), (right, False), (lower, False))
            )
            area = float(self.samples.lengths[j]) * self.height
            middle = _WEIGHTS @ curve.evaluate(_AT)
            surface = FaceSurface(
                geometry=geometry,
                outward=hand * self._sense(j),
                box=np.array([[first, min(0.0, top)], [last, max(0.0, top)]]),
                limits=limits_of(geometry, first, last),
                curves={e: EdgeOnFace(curve=own, read=known_as(flat)) for e, (own, flat) in on_side.items()},
            )
            center = middle + self.along / 2.0
            kind = {Plane: "plane", Cone: "cylinder"}.get(type(geometry), "extrusion")
            loop = Loop(edges=tuple(e for e, _ in run), forward=tuple(way for _, way in run), angles=(np.pi / 2,) * 4)
            # Half way along an arc, as along a line, is what is nearest to the middle.
            normal = surface.normals(surface.project(center[None]))[0] if kind == "extrusion" else facing[j]
            found.append(upright_face(j, kind, area, center, normal, (loop,), surface))
        return found

    def _cells(self) -> list[Face]:
        """Bottom and top of every cell."""
        top_plane = Plane(
            frame=Frame(
                origin=self.plane.frame.origin + self.along,
                x=self.plane.frame.x,
                y=self.plane.frame.y,
                z=self.plane.frame.z,
            )
        )
        hand = 1.0 if float(self.plane.frame.z @ self.up) * self.plane.frame.handedness > 0 else -1.0
        found = []
        for c, (own, measure) in enumerate(zip(self.loops, self._measured(hand), strict=True)):
            box = self._box(own)
            for top, f in ((False, self.bottoms[c]), (True, self.tops[c])):
                ids = self.upper if top else self.lower
                loops = tuple(renumbered(loop, ids) if top else renumbered(turned_round(loop), ids) for loop in own)
                curves = {
                    ids[j]: EdgeOnFace(curve=self.lifted[j] if top else self.curves[j], read=self._dropped(j))
                    for loop in own
                    for j in loop.edges
                }
                surface = FaceSurface(
                    geometry=top_plane if top else self.plane,
                    outward=hand if top else -hand,
                    box=box,
                    limits=np.array([[-np.inf, -np.inf], [np.inf, np.inf]]),
                    curves=curves,
                )
                center = measure.center + (self.along if top else 0.0)
                found.append(
                    upright_face(f, "plane", measure.area, center, self.up if top else -self.up, loops, surface)
                )
        return found

    def _box(self, loops: Sequence[Loop]) -> FloatArray:
        """Of the ends and middles of a cell's lines, in the plane's coordinates."""
        own = [j for loop in loops for j in loop.edges]
        places = self.plane.project(self.samples.points[own].reshape(-1, 3))
        return np.array([places.min(axis=0), places.max(axis=0)])

    def _dropped(self, j: int) -> Callable[[], tuple[Parametric, FloatArray]]:
        """A line in the plane's coordinates."""
        frame = self.plane.frame

        def read() -> tuple[Parametric, FloatArray]:
            axes = np.array([frame.x, frame.y])
            return carried(self.curves[j].geometry, axes, -axes @ frame.origin), np.zeros(2)

        return read

    def _measured(self, hand: float) -> list[Measure]:
        """Area and centroid of every cell."""
        exact = [is_exact(curve) for curve in self.curves]
        plain = [c for c, own in enumerate(self.loops) if all(exact[j] for loop in own for j in loop.edges)]
        normals = np.broadcast_to(self.up, (len(plain), 3))
        found = dict(
            zip(plain, measure_flat([self.loops[c] for c in plain], normals, self.curves, self.samples), strict=True)
        )
        measures = []
        for c, own in enumerate(self.loops):
            measure = found.get(c)
            if c not in found:
                surface = FaceSurface(
                    geometry=self.plane,
                    outward=hand,
                    box=self._box(own),
                    limits=np.array([[-np.inf, -np.inf], [np.inf, np.inf]]),
                    curves={
                        j: EdgeOnFace(curve=self.curves[j], read=self._dropped(j)) for loop in own for j in loop.edges
                    },
                )
                measure = measure_face(surface, own)
            if measure is None:
                raise CadError("a cell of the arrangement is turned over")
            measures.append(measure)
        return measures


__all__ = ["PlaneShapes", "Prism", "extrude_cells", "plane_shapes"]
