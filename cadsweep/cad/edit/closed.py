"""A closed sweep along any curve cut open, so that it has a source and a target, which coincide.

Place in the flow: called by the pipeline for a part all of whose faces run around it, and which is no ring
of revolution (:mod:`.rings`).

Method: a plane square to an edge at its middle cuts some sections out of the solid; the one the edge
passes through is a candidate, the smaller the better. Two of them that fall the solid into two make one
solid again when the two are joined at the second section and left apart at the first: the vertices of
the first are copied for one of the two.

Not handled: rings that no plane square to one of their edges crosses in one face.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Splitter
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools_ReShape
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.Standard import Standard_Failure
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Vertex
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Part, Solid, volume_doubt
from ...errors import CadError
from ..shapes import FACE, SOLID, VERTEX, SolidShape, compound, explore, listed, subshapes, typed
from ..trial import attempted
from .opening import cross_section, open_solid

log = logging.getLogger(__name__)

MOST_PLANES = 12
"""Edges, the longest first, at whose middles sections are looked for."""
MOST_CUTS = 4
"""Cuts that are made before the part is given up."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Section:
    """A plane face through the solid; ``center`` and ``area`` are its own."""

    face: Any
    center: FloatArray
    area: float


def cut_closed(part: Part) -> Iterator[Part]:
    """Yield the part cut open, at the smallest section first.

    Parameters
    ----------
    part : Part
        One solid.

    Yields
    ------
    Part
        The same solid with two coincident caps, its other faces in pieces with their names and keys.
    """
    solid = part.solids[0]
    holder = solid.kernel
    if len(part.solids) != 1 or not isinstance(holder, SolidShape):
        return
    sections = sorted(_find_sections(solid, holder), key=lambda section: section.area)
    n_made = 0
    for first in sections:
        others = [s for s in sections if s is not first and s.area < 4.0 * first.area]
        others.sort(key=lambda s: -float(np.linalg.norm(s.center - first.center)))
        for second in others[:MOST_CUTS]:
            try:
                opened = _cut(part, solid, holder, first, second)
            except (CadError, Standard_Failure) as error:
                log.info("a section at %s does not cut the ring open: %s", first.center, error)
                continue
            if opened is not None:
                yield opened
                n_made += 1
                break
        if n_made == MOST_CUTS:
            return


def _find_sections(solid: Solid, holder: SolidShape) -> list[_Section]:
    """Sections square to edges at their middles, each plane once."""
    found: list[_Section] = []
    for edge in sorted(solid.edges, key=lambda edge: -edge.length)[:MOST_PLANES]:
        a, point, b = edge.curve.evaluate(np.array([0.5 - 1e-6, 0.5, 0.5 + 1e-6]))
        normal = (b - a) / np.linalg.norm(b - a)
        if any(_distance(section.face, point) < 1e-6 * solid.size for section in found):
            continue
        plane = gp_Pln(gp_Pnt(*point), gp_Dir(*normal))
        reach = 2.0 * solid.size
        faces = cross_section(holder.shape, BRepBuilderAPI_MakeFace(plane, -reach, reach, -reach, reach).Face())
        here = [face for face in faces if _distance(face, point) < 1e-6 * solid.size]
        if len(here) == 1:
            center, area = _measure(here[0])
            found.append(_Section(face=here[0], center=center, area=area))
    return found


def _distance(face: Any, point: FloatArray) -> float:
    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex()
    return float(BRepExtrema_DistShapeShape(vertex, face).Value())


def _cut(part: Part, solid: Solid, holder: SolidShape, first: _Section, second: _Section) -> Part | None:
    """Cut at the first section, and divide the sides at the second; None where they do not make two solids."""
    splitter = BRepAlgoAPI_Splitter()
    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(holder.shape)
    for section in (first, second):
        tools.Append(section.face)
    splitter.SetArguments(arguments)
    splitter.SetTools(tools)
    done = attempted(splitter.Build, "cutting a ring open", on=[holder.shape])
    halves = subshapes(splitter.Shape(), SOLID) if done and splitter.IsDone() else []
    if len(halves) != 2:
        return None
    one, other = (list(explore(half, FACE)) for half in halves)
    shared = [face for face in one if any(face.IsSame(twin) for twin in other)]
    if len(shared) != 2:
        return None
    cap, joint = sorted(shared, key=lambda face: float(np.linalg.norm(_measure(face)[0] - first.center)))
    one = [face for face in one if not face.IsSame(joint)]
    other = [face for face in other if not face.IsSame(joint)]
    images = [(new, j) for j, old in enumerate(holder.faces) for new in listed(splitter.Modified(old)) or [old]]
    origins = [next((j for new, j in images if face.IsSame(new)), None) for face in (*one, *other)]
    cap_faces = [j for j, face in enumerate((*one, *other)) if face.IsSame(cap)]
    opened = open_solid(
        solid, [*one, *_moved_apart(other, cap)], cap_faces, lambda _, j: None if j is None else origins[j]
    )
    if abs(opened.volume - solid.volume) > 1e-6 * solid.volume + volume_doubt(solid):
        return None
    note = "the closed ring is cut open; its source and target are one and the same place"
    return replace(part, solids=(opened,), notes=(*part.notes, note))


def _moved_apart(faces: list[Any], cap: Any) -> list[Any]:
    """The faces with their own copies of the vertices and edges of the cap, which they share with others."""
    builder, reshape = BRep_Builder(), BRepTools_ReShape()
    for vertex in subshapes(cap, VERTEX):
        twin = TopoDS_Vertex()
        builder.MakeVertex(twin, BRep_Tool.Pnt_s(vertex), BRep_Tool.Tolerance_s(vertex))
        reshape.Replace(typed(vertex.Oriented(TopAbs_Orientation.TopAbs_FORWARD), VERTEX), twin)
    return list(explore(reshape.Apply(compound(faces)), FACE))


def _measure(face: Any) -> tuple[FloatArray, float]:
    """Centroid and area."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    center = properties.CentreOfMass()
    return np.array([center.X(), center.Y(), center.Z()]), float(properties.Mass())
