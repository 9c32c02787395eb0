"""From a healed OpenCASCADE solid to ``brep.Solid``: ids, loops, angles and numpy geometry.

Place in the flow: the last step of ``cad``. The shape has been divided and checked, so that every
edge has two vertices and two faces.

Method: vertices, edges and faces are numbered in OpenCASCADE's order of exploration. A loop is
chained from the directed edges of a wire; where several go on from one vertex the sharpest turn
to the material's side is taken, so that a wire that touches itself falls into simple loops.
Degenerate edges (a cone's apex, a sphere's pole) are left out of the loops.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_Orientation

from ...arrays import FloatArray, IntArray
from ...brep import Edge, Face, Loop, Solid, Units
from ...errors import CadError
from ..geometry.angles import chain_loops, corner_angles, dihedral_angles, n_touching
from ..geometry.convert import surface_kind
from ..geometry.curves import EdgeCurve
from ..geometry.face_surface import FaceSurface
from ..geometry.measure import Measure
from ..geometry.surfaces import Plane
from ..shapes import EDGE, FACE, VERTEX, WIRE, SolidShape, explore, index_map, mapped, shapes_of
from .cylinders import find_cylinders
from .extent import tight_bounds
from .face_surfaces import ParameterCurves, read_face_surface
from .gaps import border_gaps
from .labels import EdgeLabel, FaceLabel, Labels
from .measures import measure_faces, measured_by_opencascade, volume_inside
from .sampling import EdgeSamples, FaceSamples, sample_face
from .shared import PartGeometry

_LARGEST_GAP = 1e-3
"""Distance between an edge and its faces, as a share of the part's size, beyond which a model is damaged."""
_SENSES = {TopAbs_Orientation.TopAbs_FORWARD: True, TopAbs_Orientation.TopAbs_REVERSED: False}


def extract_solid(
    shape: Any,
    *,
    labels: Labels | None = None,
    name: str | None = None,
    material: str | None = None,
    color: str | None = None,
    units: Units | None = None,
    shared: PartGeometry | None = None,
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
    shared : PartGeometry, optional
        What the solid shares with others of its part; the keys are those of the whole part then.
    opened : pair of frozenset of int, optional
        Faces on either side of the cut that opened a closed ring.

    Raises
    ------
    CadError
        An edge has no two faces, or no curve.
    """
    maps = index_map(shape, VERTEX), index_map(shape, EDGE), index_map(shape, FACE)
    shared = PartGeometry(shape) if shared is None else shared
    holder = SolidShape(
        shape=shape, vertices=mapped(maps[0], VERTEX), edges=mapped(maps[1], EDGE), faces=mapped(maps[2], FACE)
    )
    n_faces, n_edges = len(holder.faces), len(holder.edges)
    units = Units() if units is None else units
    if labels is None:
        labels = Labels(
            [FaceLabel(f"face {j}") for j in range(n_faces)], [EdgeLabel(f"edge {j}") for j in range(n_edges)]
        )
    vertex_keys, edge_keys = shared.keys(VERTEX, holder.vertices), shared.keys(EDGE, holder.edges)
    read = [shared.curves[key] for key in edge_keys.tolist()]
    curves, kinds = [curve for curve, _ in read], [kind for _, kind in read]
    samples = shared.samples.take(edge_keys)
    local = np.full(len(shared.vertices), -1)
    local[vertex_keys] = np.arange(len(vertex_keys))
    ends = local[shared.ends[edge_keys]]
    box = tight_bounds(shape)
    size = float(np.linalg.norm(box[1] - box[0]))
    largest_gap = max(_LARGEST_GAP * size, shared.closed)
    gaps = _end_gaps(samples, shared.vertices[shared.ends[edge_keys]], largest_gap, units)
    wires = [read_wires(face, maps[1]) for face in holder.faces]
    surfaces = _surfaces(holder, wires, curves, shared, labels.faces)
    cylinders = find_cylinders(surfaces)
    at_once = cylinders.samples(surfaces, samples)
    frames = []
    for j, surface in enumerate(surfaces):
        along = at_once[j] if j in at_once else sample_face(surface, samples)
        _refuse_torn(along, j, largest_gap)
        frames.append(along.normals)
        numbers, found = (
            border_gaps(surface, samples, size) if along.gaps is None else (list(surface.curves), along.gaps)
        )
        gaps[numbers] = np.maximum(gaps[numbers], found)
    loops = _loops(wires, ends, curves, frames, samples)
    uses: list[list[tuple[int, bool]]] = [[] for _ in holder.edges]
    for f, of_face in enumerate(loops):
        for loop in of_face:
            for e, forward in loop.directed:
                uses[e].append((f, forward))
    sides = np.array([_two_faces(j, own, samples, units) for j, own in enumerate(uses)]).reshape(-1, 2)
    dihedrals = dihedral_angles(
        samples.tangents[:, 1],
        np.array([frames[f][e][1] for e, f in enumerate(sides[:, 0])]).reshape(-1, 3),
        np.array([frames[f][e][1] for e, f in enumerate(sides[:, 1])]).reshape(-1, 3),
    )
    edges = tuple(
        Edge(
            id=j,
            start=int(ends[j, 0]),
            end=int(ends[j, 1]),
            length=float(samples.lengths[j]),
            kind=kinds[j],
            faces=(int(sides[j, 0]), int(sides[j, 1])),
            dihedral=float(dihedrals[j]),
            midpoint=samples.points[j, 1],
            tangents=samples.end_tangents[j],
            curve=curves[j],
            name=labels.edges[j].names[0] if labels.edges[j].names else None,
            groups=labels.edges[j].names[1:],
            key=labels.edges[j].key,
            number=labels.edges[j].number,
            gap=float(gaps[j]),
            units=units,
        )
        for j in range(n_edges)
    )
    measures = [
        measure or measured_by_opencascade(face, surface)
        for measure, face, surface in zip(
            measure_faces(surfaces, loops, frames, samples, curves, cylinders), holder.faces, surfaces, strict=True
        )
    ]
    faces = tuple(
        _face(
            j,
            shape=holder.faces[j],
            surface=surfaces[j],
            loops=loops[j],
            measure=measures[j],
            label=labels.faces[j],
            handles=-n_touching(loops[j], ends),
            units=units,
        )
        for j in range(n_faces)
    )
    return Solid(
        vertices=shared.positions[vertex_keys],
        edges=edges,
        faces=faces,
        volume=volume_inside(shape, measures, open_area=2.0 * sum(edge.gap * edge.length for edge in edges)),
        size=size,
        tolerance=largest_tolerance(shape),
        closed=shared.closed,
        kernel=holder,
        vertex_keys=vertex_keys,
        edge_keys=edge_keys,
        face_keys=shared.keys(FACE, holder.faces),
        name=name,
        material=material,
        color=color,
        units=units,
        opened=opened,
    )


def _surfaces(
    holder: SolidShape,
    wires: Sequence[Sequence[Sequence[_Use]]],
    curves: Sequence[EdgeCurve],
    shared: PartGeometry,
    labels: Sequence[FaceLabel],
) -> list[FaceSurface]:
    """The surface of every face."""
    # Of planes and cylinders hardly anybody wants to know the curves in their parameters, which splines need.
    together: defaultdict[str, ParameterCurves] = defaultdict(ParameterCurves)
    surfaces = []
    for face, own, label in zip(holder.faces, wires, labels, strict=True):
        edges = [(use.edge, use.number) for wire in own for use in wire]
        kind = _kind(face)
        beside = ParameterCurves() if kind == "plane" else together[kind]
        geometry = shared.surface(face)
        surfaces.append(read_face_surface(face, edges, curves, geometry=geometry, beside=beside, tips=label.tips))
    return surfaces


def rekeyed(solid: Solid, shared: PartGeometry) -> Solid:
    """A solid that was read before, as a cell of another part: its geometry is the same, its keys are the part's.

    Parameters
    ----------
    solid : Solid
        Its shape is in the part.
    shared : PartGeometry
        Of the part.
    """
    holder = shapes_of(solid)
    vertex_keys = shared.keys(VERTEX, holder.vertices)
    return replace(
        solid,
        vertices=shared.positions[vertex_keys],
        vertex_keys=vertex_keys,
        edge_keys=shared.keys(EDGE, holder.edges),
        face_keys=shared.keys(FACE, holder.faces),
    )


def largest_tolerance(shape: Any) -> float:
    """Largest gap that the model allows between its vertices, edges and faces."""
    from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance

    return float(ShapeAnalysis_ShapeTolerance().Tolerance(shape, 1))


class _Use(NamedTuple):
    """An edge as a wire of a face runs through it; `sense` is None for one that does not bound the face."""

    edge: Any
    number: int
    sense: bool | None


def read_wires(face: Any, edge_map: Any) -> list[list[_Use]]:
    """The wires of a face, outer wire first; without degenerate edges."""
    found = list(explore(face, WIRE))
    if len(found) > 1:
        outer = BRepTools.OuterWire_s(face)
        found.sort(key=lambda wire: not wire.IsSame(outer))
    wires = []
    for wire in found:
        uses = []
        for edge in explore(wire, EDGE):
            number = edge_map.FindIndex(edge) - 1
            if number >= 0:
                uses.append(_Use(edge, number, _SENSES.get(edge.Orientation())))
        wires.append(uses)
    return wires


def _end_gaps(samples: EdgeSamples, vertices: FloatArray, largest_gap: float, units: Units) -> FloatArray:
    """How far edges end off their vertices (n_edges, 2, 3); refuse what is far off."""
    gaps = np.linalg.norm(samples.points[:, ::2] - vertices, axis=2).max(axis=1, initial=0.0)
    if not (gaps <= largest_gap).all():
        edge = int(np.argmax(~(gaps <= largest_gap)))
        raise CadError(
            f"edge {edge} ends {gaps[edge] * units.scale:.3g} off its vertices, near "
            f"({units.place(vertices[edge, 0])}), more than a mesh may leave open. Export it again, more exactly."
        )
    return gaps


def _refuse_torn(along: FaceSamples, number: int, largest_gap: float) -> None:
    """Refuse a face that lies far off one of its edges."""
    if not along.gap <= largest_gap:
        x, y, z = along.place
        raise CadError(
            f"edge {along.edge} lies {along.gap:.3g} off face {number} at ({x:.4g}, {y:.4g}, {z:.4g}), "
            "more than a mesh may leave open. Export it again, more exactly."
        )


def _loops(
    wires: Sequence[Sequence[Sequence[_Use]]],
    ends: IntArray,
    curves: Sequence[EdgeCurve],
    frames: Sequence[Mapping[int, FloatArray]],
    samples: EdgeSamples,
) -> list[tuple[Loop, ...]]:
    """The loops of every face, outer loop first."""
    start_end = [(start, end) for start, end in ends.tolist()]
    chains = [
        [
            chain
            for wire in own
            for chain in chain_loops(
                [(use.number, use.sense) for use in wire if use.sense is not None],
                start_end,
                curves,
                frames[f],
                samples.end_tangents,
            )
        ]
        for f, own in enumerate(wires)
    ]
    of_face = [f for f, own in enumerate(chains) for _ in own]
    flat = [chain for own in chains for chain in own]
    angles = corner_angles(flat, curves, [frames[f] for f in of_face], samples.end_tangents)
    loops: list[list[Loop]] = [[] for _ in wires]
    for f, chain, own_angles in zip(of_face, flat, angles, strict=True):
        loops[f].append(
            Loop(edges=tuple(e for e, _ in chain), forward=tuple(forward for _, forward in chain), angles=own_angles)
        )
    return [tuple(own) for own in loops]


def _two_faces(number: int, uses: Sequence[tuple[int, bool]], samples: EdgeSamples, units: Units) -> tuple[int, int]:
    """The face that runs the edge forward, whose material lies on the left of the tangent, and the other."""
    if len(uses) != 2:
        raise CadError(
            f"Edge {number} at ({units.place(samples.points[number, 1])}) bounds {len(uses)} faces instead of 2. "
            "The solid is not closed, or is not manifold there; repair it in its CAD program."
        )
    (first, _), (second, _) = sorted(uses, key=lambda use: not use[1])
    return first, second


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
    handles: int,
    units: Units,
) -> Face:
    flat = isinstance(surface.geometry, Plane)
    return Face(
        id=number,
        kind=_kind(shape),
        area=measure.area,
        center=measure.center,
        normal=surface.normals(surface.box[:1] if flat else surface.project(measure.center[None]))[0],
        loops=loops,
        surface=surface,
        name=label.names[0] if label.names else None,
        groups=label.names[1:],
        color=label.color,
        key=label.key,
        number=label.number,
        tips=label.tips,
        units=units,
        handles=handles,
    )


def _point(p: Any) -> FloatArray:
    return np.array([p.X(), p.Y(), p.Z()])
