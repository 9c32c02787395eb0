"""From a healed OpenCASCADE solid to ``brep.Solid``: ids, loops, angles and numpy geometry.

Place in the flow: the last step of ``cad``. The shape has been divided and checked, so that every
edge has two vertices and two faces.

Method: vertices, edges and faces are numbered in OpenCASCADE's order of exploration. A loop is
chained from the directed edges of a wire; where several go on from one vertex the sharpest turn
to the material's side is taken, so that a wire that touches itself falls into simple loops.
Degenerate edges (a cone's apex, a sphere's pole) are left out of the loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS

from ...arrays import FloatArray
from ...brep import Edge, Face, Loop, Solid, Units
from ...errors import CadError
from ..geometry.angles import MIDDLE, chain_loops, corner_angles, dihedral_angle
from ..geometry.convert import distances_from, read_curve, read_curve_2d, read_surface, surface_kind
from ..geometry.curves import EdgeCurve, Ellipse, Line, Parametric, Reparametrised
from ..geometry.face_surface import FaceSurface
from ..geometry.measure import Measure, measure_face
from ..shapes import (
    EDGE,
    FACE,
    VERTEX,
    WIRE,
    SolidShape,
    bounds,
    explore,
    index_map,
    mapped,
    space_range,
    surface_range,
)

_INFINITE = 1e100
_LARGEST_GAP = 1e-3
"""Distance between an edge and its faces, as a share of the part's size, beyond which a model is damaged."""
_OPEN = 1e-4
"""Sum of the vector areas, as a share of the area, up to which a surface counts as closed."""
_EXACT_CURVES = {"line", "circle", "ellipse"}


class FaceLabel(NamedTuple):
    """What is known of a face besides geometry: fields of ``brep.Face``."""

    key: str = ""
    names: tuple[str, ...] = ()
    color: str | None = None


class EdgeLabel(NamedTuple):
    """What is known of an edge besides geometry: fields of ``brep.Edge``."""

    key: str = ""
    names: tuple[str, ...] = ()


class Labels(NamedTuple):
    """What is known of the parts of a solid besides geometry, by id."""

    faces: Sequence[FaceLabel]
    edges: Sequence[EdgeLabel]


def label_of(face: Face | None) -> FaceLabel:
    """The label of a face, for one that is made of it; an empty one for a face that comes from none."""
    return FaceLabel() if face is None else FaceLabel(face.key, face.names, face.color)


def extract_solid(
    shape: Any,
    *,
    labels: Labels | None = None,
    name: str | None = None,
    material: str | None = None,
    color: str | None = None,
    units: Units | None = None,
    part_maps: tuple[Any, Any, Any] | None = None,
    opened: tuple[frozenset[int], frozenset[int]] | None = None,
) -> Solid:
    """Read a solid into ids and numpy geometry.

    Parameters
    ----------
    shape : TopoDS_Solid
        Divided and checked; lengths in working units.
    labels : Labels, optional
        Keys, names and colours of its faces and edges, by id.
    name, material, color : str, optional
    units : Units, optional
        How the working lengths become the model's.
    part_maps : three maps, optional
        Vertices, edges and faces of the whole part, for the keys that tell shared entities.
    opened : pair of frozenset of int, optional
        Faces on either side of the cut that opened a closed ring.

    Raises
    ------
    CadError
        An edge has no two faces, or no curve.
    """
    maps = index_map(shape, VERTEX), index_map(shape, EDGE), index_map(shape, FACE)
    holder = SolidShape(
        shape=shape, vertices=mapped(maps[0], VERTEX), edges=mapped(maps[1], EDGE), faces=mapped(maps[2], FACE)
    )
    n_faces, n_edges = len(holder.faces), len(holder.edges)
    units = Units() if units is None else units
    if labels is None:
        labels = Labels(
            [FaceLabel(f"face {j}") for j in range(n_faces)], [EdgeLabel(f"edge {j}") for j in range(n_edges)]
        )
    vertices = np.array([_point(BRep_Tool.Pnt_s(v)) for v in holder.vertices]).reshape(-1, 3)
    curves = [_edge_curve(edge, j) for j, edge in enumerate(holder.edges)]
    ends = [_edge_ends(edge, maps[0]) for edge in holder.edges]
    box = bounds(shape, tight=True)
    size = float(np.linalg.norm(box[1] - box[0]))
    for j, (curve, _) in enumerate(curves):
        gap = np.linalg.norm(curve.evaluate(np.array([0.0, 1.0])) - vertices[list(ends[j])], axis=1).max()
        if not gap <= _LARGEST_GAP * size:
            raise CadError(
                f"edge {j} ends {gap * units.scale:.3g} off its vertices, near "
                f"({units.place(vertices[ends[j][0]])}), so the model is damaged. Export it again from its CAD program."
            )

    # Of several points that sewing took for one vertex it keeps any: the first edge's end is always the same.
    for j in reversed(range(len(curves))):
        vertices[list(ends[j])] = curves[j][0].evaluate(np.array([0.0, 1.0]))

    surfaces = [_face_surface(face, maps[1], [c for c, _ in curves]) for face in holder.faces]
    frames = [_edge_frames(surface, j, _LARGEST_GAP * size) for j, surface in enumerate(surfaces)]
    uses: list[list[tuple[int, bool]]] = [[] for _ in holder.edges]
    loops: list[tuple[Loop, ...]] = []
    for f, face in enumerate(holder.faces):
        loops.append(_face_loops(face, maps[1], ends, [c for c, _ in curves], frames[f]))
        for loop in loops[-1]:
            for e, forward in loop.directed:
                uses[e].append((f, forward))

    edges = tuple(
        _edge(
            j,
            ends=ends[j],
            curve=curves[j],
            uses=uses[j],
            normals=frames,
            label=labels.edges[j],
            units=units,
        )
        for j in range(n_edges)
    )
    measures = [
        _measured(holder.faces[j], surfaces[j], loops[j], {curves[e][1] for e in surfaces[j].curves})
        for j in range(n_faces)
    ]
    faces = tuple(
        _face(
            j,
            shape=holder.faces[j],
            surface=surfaces[j],
            loops=loops[j],
            measure=measures[j],
            label=labels.faces[j],
            units=units,
        )
        for j in range(n_faces)
    )
    shared = part_maps if part_maps is not None else maps
    return Solid(
        vertices=vertices,
        edges=edges,
        faces=faces,
        volume=_volume(shape, measures),
        size=size,
        tolerance=largest_tolerance(shape),
        write_brep=holder,
        vertex_keys=_keys(shared[0], holder.vertices),
        edge_keys=_keys(shared[1], holder.edges),
        face_keys=_keys(shared[2], holder.faces),
        name=name,
        material=material,
        color=color,
        units=units,
        opened=opened,
    )


def largest_tolerance(shape: Any) -> float:
    """Largest gap that the model allows between its vertices, edges and faces."""
    from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance

    return float(ShapeAnalysis_ShapeTolerance().Tolerance(shape, 1))


def _keys(shared: Any, own: Sequence[Any]) -> Any:
    return np.array([shared.FindIndex(s) - 1 for s in own], dtype=np.int64)


def _edge_curve(edge: Any, number: int) -> tuple[EdgeCurve, str]:
    curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
    if curve is None:
        raise CadError(f"Edge {number} has no curve in space. Repair the model in its CAD program and export it again.")
    first, last = space_range(edge)
    geometry, kind, breaks, constant_speed = read_curve(curve)
    return (
        EdgeCurve(geometry=geometry, first=first, last=last, breaks=breaks, constant_speed=constant_speed),
        kind,
    )


def _edge_ends(edge: Any, vertex_map: Any) -> tuple[int, int]:
    forward = TopoDS.Edge_s(edge.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    return (
        vertex_map.FindIndex(TopExp.FirstVertex_s(forward, True)) - 1,
        vertex_map.FindIndex(TopExp.LastVertex_s(forward, True)) - 1,
    )


def _face_surface(face: Any, edge_map: Any, curves: Sequence[EdgeCurve]) -> FaceSurface:
    surface = BRep_Tool.Surface_s(face)
    geometry = read_surface(surface)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    limits = np.array(surface.Bounds()).reshape(2, 2).T.copy()
    limits[np.abs(limits) > _INFINITE] *= np.inf
    for j, period in enumerate(geometry.periods):
        if period is not None:
            limits[:, j] = (-np.inf, np.inf)
    in_parameters = {}
    box = np.array([[u0, v0], [u1, v1]])
    for edge in explore(face, EDGE):
        number = edge_map.FindIndex(edge) - 1
        if number < 0:
            continue
        curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
        known = None if curve is None else _in_range(read_curve_2d(curve), curves[number], edge, face)
        in_parameters[number] = (curves[number], known, _into_branch(known, curves[number], geometry.periods, box))
    outward = -1.0 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
    return FaceSurface(
        geometry=geometry,
        outward=outward,
        box=box,
        limits=limits,
        curves=in_parameters,
        second_opinion=distances_from(surface, box),
    )


def _in_range(known: Parametric, curve: EdgeCurve, edge: Any, face: Any) -> Parametric:
    """The parameter curve in the parameter of the space curve; dividing may leave them a period apart."""
    first, last = surface_range(edge, face)
    width = curve.last - curve.first
    if max(abs(first - curve.first), abs(last - curve.last)) <= 1e-9 * width:
        return known
    rate = (last - first) / width
    return Reparametrised(curve=known, offset=first - rate * curve.first, rate=rate)


def _into_branch(known: Any, curve: EdgeCurve, periods: Sequence[float | None], box: FloatArray) -> FloatArray:
    """Shift (2,) that brings an edge's parameter curve into the box of its face.

    OpenCASCADE leaves the curve of a divided face a period off where the edge crossed the seam.
    """
    shift = np.zeros(2)
    if known is not None:
        middle = known.derivatives(np.array([(curve.first + curve.last) / 2.0]))[0][0]
        for j, period in enumerate(periods):
            if period is not None:
                shift[j] = -period * np.round((middle[j] - box[:, j].mean()) / period)
    return shift


def _edge_frames(surface: FaceSurface, number: int, largest_gap: float) -> dict[int, FloatArray]:
    """For each edge of the face, the outward normals (3, 3) at its start, middle and end; and in the face's middle."""
    numbers = list(surface.curves)
    at = np.array([0.0, 0.5, 1.0])
    uv = np.concatenate([surface.edge_uv(e, at) for e in numbers])
    on_edges = np.concatenate([surface.curves[e][0].evaluate(at) for e in numbers])
    gap = np.linalg.norm(surface.evaluate(uv) - on_edges, axis=1)
    if not gap.max() <= largest_gap:
        edge, (x, y, z) = numbers[int(gap.argmax()) // 3], on_edges[int(gap.argmax())]
        raise CadError(
            f"edge {edge} lies {gap.max():.3g} off face {number} at ({x:.4g}, {y:.4g}, {z:.4g}), so the model is "
            "damaged. Export it again from its CAD program."
        )
    normals = surface.normals(uv).reshape(-1, 3, 3)
    frames = dict(zip(numbers, normals, strict=True))
    frames[MIDDLE] = surface.normals(surface.box.mean(axis=0)[None])
    return frames


def _face_loops(
    face: Any,
    edge_map: Any,
    ends: Sequence[tuple[int, int]],
    curves: Sequence[EdgeCurve],
    normals: dict[int, FloatArray],
) -> tuple[Loop, ...]:
    outer = BRepTools.OuterWire_s(face)
    wires = sorted(explore(face, WIRE), key=lambda wire: not wire.IsSame(outer))
    loops = []
    for wire in wires:
        directed = []
        for edge in explore(wire, EDGE):
            number = edge_map.FindIndex(edge) - 1
            if number >= 0 and edge.Orientation() in (
                TopAbs_Orientation.TopAbs_FORWARD,
                TopAbs_Orientation.TopAbs_REVERSED,
            ):
                directed.append((number, edge.Orientation() == TopAbs_Orientation.TopAbs_FORWARD))
        for chain in chain_loops(directed, ends, curves, normals):
            loops.append(
                Loop(
                    edges=tuple(e for e, _ in chain),
                    forward=tuple(f for _, f in chain),
                    angles=corner_angles(chain, curves, normals),
                )
            )
    return tuple(loops)


def _edge(
    number: int,
    *,
    ends: tuple[int, int],
    curve: tuple[EdgeCurve, str],
    uses: Sequence[tuple[int, bool]],
    normals: Sequence[dict[int, FloatArray]],
    label: EdgeLabel,
    units: Units,
) -> Edge:
    geometry, kind = curve
    at = np.array([0.0, 0.5, 1.0])
    points, tangents = geometry.evaluate(at), geometry.tangents(at)
    if len(uses) != 2:
        raise CadError(
            f"Edge {number} at ({units.place(points[1])}) bounds {len(uses)} faces instead of 2. "
            "The solid is not closed, or is not manifold there; repair it in its CAD program."
        )
    # The face that runs the edge forward first: its material lies on the left of the tangent.
    (first, _), (second, _) = sorted(uses, key=lambda use: not use[1])
    dihedral = dihedral_angle(tangents[1], normals[first][number][1], normals[second][number][1])
    return Edge(
        id=number,
        start=ends[0],
        end=ends[1],
        length=geometry.length,
        kind=kind,
        faces=(first, second),
        dihedral=dihedral,
        midpoint=points[1],
        tangents=geometry.end_tangents,
        curve=geometry,
        name=label.names[0] if label.names else None,
        groups=label.names[1:],
        key=label.key,
        units=units,
    )


def _measured(shape: Any, surface: FaceSurface, loops: tuple[Loop, ...], kinds: set[str]) -> Measure:
    """Area, centroid and volume share of a face.

    OpenCASCADE measures what it measures exactly, planes between lines and conics that are drawn as such on the
    plane, too; its share of the volume is NaN where a curved face has no parameter curves.
    """
    flat = _kind(shape) == "plane"
    drawn = [known.curve if isinstance(known, Reparametrised) else known for _, known, _ in surface.curves.values()]
    exact = kinds <= _EXACT_CURVES and all(isinstance(curve, (Line, Ellipse)) for curve in drawn)
    measure = None if flat and exact else measure_face(surface, loops)
    if measure is not None:
        return measure
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    area, center = float(properties.Mass()), _point(properties.CentreOfMass())
    if not flat:
        return Measure(area, center, float("nan"), np.full(3, np.nan))
    vector = area * surface.normals(surface.project(center[None]))[0]
    return Measure(area, center, float(center @ vector) / 3.0, vector)


def _volume(shape: Any, measures: Sequence[Measure]) -> float:
    gap = np.linalg.norm(np.sum([m.vector for m in measures], axis=0))
    if gap <= _OPEN * sum(m.area for m in measures):
        return float(sum(m.volume for m in measures))
    # Our quadrature does not see a closed surface (or has none of a face): OpenCASCADE's stands in.
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())


def _kind(shape: Any) -> str:
    return surface_kind(BRep_Tool.Surface_s(shape))


def _face(
    number: int,
    *,
    shape: Any,
    surface: FaceSurface,
    loops: tuple[Loop, ...],
    measure: Measure,
    label: FaceLabel,
    units: Units,
) -> Face:
    return Face(
        id=number,
        kind=_kind(shape),
        area=measure.area,
        center=measure.center,
        normal=surface.normals(surface.project(measure.center[None]))[0],
        loops=loops,
        surface=surface,
        name=label.names[0] if label.names else None,
        groups=label.names[1:],
        color=label.color,
        key=label.key,
        units=units,
    )


def _point(p: Any) -> FloatArray:
    return np.array([p.X(), p.Y(), p.Z()])
