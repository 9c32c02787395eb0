"""A full ring of revolution cut open, so that it has a source and a target, which coincide.

Place in the flow: called by the pipeline for a part that has no caps. Which parts those are is
recognition's word; :func:`cut_ring` only looks whether all faces turn about one axis.

Method: the section by a half-plane through the axis is turned by half a revolution, and its last
place by another half, so that the two halves share the faces' edges in between while the first and
the last place stay apart. The result is a solid as any other, whose two caps lie on each other: the
layer of nodes on the target is the layer on the source, and a mesh of it is closed
(``SweptStructure.periodic``).

Not handled: sections that touch the axis. Closed sweeps along other curves are :mod:`.closed`'s.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepGProp import BRepGProp
from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
from OCP.gp import gp_Ax1, gp_Ax3, gp_Dir, gp_Pln, gp_Pnt
from OCP.GProp import GProp_GProps

from ...arrays import FloatArray
from ...brep import Part, Solid, volume_doubt
from ...errors import CadError
from ..geometry.face_surface import FaceSurface
from ..geometry.surfaces import Cone, Plane, Revolved, Torus
from ..names.naming import inner_point
from ..shapes import FACE, SolidShape, explore
from .opening import cross_section, open_solid

_ANGLE = 1e-9
"""Cosines and sines that differ from 1 or 0 by this much count as parallel or square."""


def cut_ring(part: Part) -> Part | None:
    """Cut a full ring of revolution open.

    Parameters
    ----------
    part : Part
        One solid.

    Returns
    -------
    Part or None
        The same solid with two coincident caps in a plane through the axis, its other faces in two
        halves with their names and keys; None where the solid is no full ring of revolution.

    Raises
    ------
    CadError
        It is one, but OpenCASCADE fails at cutting it.
    """
    if len(part.solids) != 1:
        return None
    solid = part.solids[0]
    axis = _common_axis(solid)
    if axis is None:
        return None
    try:
        return _cut(part, solid, *axis)
    except CadError:
        raise
    except Exception as error:
        raise CadError(
            f"'{part.name}': OpenCASCADE failed at cutting the ring open ({type(error).__name__})."
        ) from error


def _common_axis(solid: Solid) -> tuple[FloatArray, FloatArray] | None:
    """Point and direction of the axis about which every face turns."""
    lines, spheres, normals = [], [], []
    for face in solid.faces:
        surface = face.surface
        geometry = surface.geometry if isinstance(surface, FaceSurface) else None
        if isinstance(geometry, Plane):
            normals.append(geometry.frame.z)
        elif isinstance(geometry, Torus) and geometry.major == 0.0:
            spheres.append(geometry.frame.origin)
        elif isinstance(geometry, (Cone, Torus)):
            lines.append((geometry.frame.origin, geometry.frame.z))
        elif isinstance(geometry, Revolved):
            lines.append((geometry.origin, geometry.axis))
        else:
            return None
    if not lines:
        return None
    origin, direction = lines[0]
    parallel = all(abs(abs(d @ direction) - 1) < _ANGLE for d in [*(d for _, d in lines), *normals])
    arms = [p - origin for p in [*(p for p, _ in lines), *spheres]]
    off = max(float(np.linalg.norm(arm - (arm @ direction) * direction)) for arm in arms)
    return (origin, direction) if parallel and off < 1e-6 * solid.size else None


def _cut(part: Part, solid: Solid, origin: FloatArray, direction: FloatArray) -> Part | None:
    holder = solid.kernel
    if not isinstance(holder, SolidShape):
        return None
    section = _section(solid, holder, origin, direction)
    if section is None:
        return None
    axis = gp_Ax1(gp_Pnt(*origin), gp_Dir(*direction))
    first = BRepPrimAPI_MakeRevol(section, axis, math.pi)
    second = BRepPrimAPI_MakeRevol(first.LastShape(), axis, math.pi)
    faces = [f for f in explore(first.Shape(), FACE) if not f.IsSame(first.LastShape())]
    faces += [f for f in explore(second.Shape(), FACE) if not f.IsSame(second.FirstShape())]
    caps = [first.FirstShape(), second.LastShape()]
    cap_faces = [next(j for j, face in enumerate(faces) if face.IsSame(cap)) for cap in caps]
    cut = open_solid(solid, faces, cap_faces, lambda face, j: None if j in cap_faces else _nearest(face, holder.faces))
    if abs(cut.volume - solid.volume) > 1e-6 * solid.volume + volume_doubt(solid):
        after, before = (one.volume * part.scale**3 for one in (cut, solid))
        raise CadError(
            f"'{part.name}': the ring has the volume {after:.6g} after it was cut open, and {before:.6g} before, "
            "so OpenCASCADE failed at it. Model a sector of the ring instead."
        )
    note = "the full ring is cut open; its source and target are one and the same place"
    return replace(part, solids=(cut,), notes=(*part.notes, note))


def _section(solid: Solid, holder: SolidShape, origin: FloatArray, direction: FloatArray) -> Any:
    """The section by a half-plane through the axis; None where it touches the axis or does not make the ring."""
    arms = solid.vertices - origin
    radial = arms - (arms @ direction)[:, None] * direction
    distance = np.sqrt(np.einsum("md,md->m", radial, radial))
    if distance.max() <= 1e-6 * solid.size:
        return None
    x = radial[int(distance.argmax())] / distance.max()
    reach = 4.0 * solid.size + float(np.linalg.norm(origin - solid.vertices.mean(axis=0)))
    plane = gp_Pln(gp_Ax3(gp_Pnt(*origin), gp_Dir(*np.cross(direction, x)), gp_Dir(*x)))
    half_plane = BRepBuilderAPI_MakeFace(plane, 0.0, reach, -reach, reach).Face()
    sections = cross_section(holder.shape, half_plane)
    if len(sections) != 1:
        return None
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(sections[0], properties)
    center = properties.CentreOfMass()
    arm = np.array([center.X(), center.Y(), center.Z()]) - origin
    radius = float(arm @ x)
    # Pappus: a full ring has the volume of its section times the way of its centroid.
    if abs(2 * math.pi * radius * properties.Mass() - solid.volume) > 1e-4 * solid.volume:
        return None
    on_axis = BRepBuilderAPI_MakeFace(plane, 0.0, 1e-6 * solid.size, -reach, reach).Face()
    if BRepExtrema_DistShapeShape(sections[0], on_axis).Value() <= 0.0:
        return None
    return sections[0]


def _nearest(face: Any, candidates: list[Any]) -> int | None:
    """The old face that a new one is a piece of; None where the new one has no inside."""
    inside = inner_point(face)
    if inside is None:
        return None
    vertex = BRepBuilderAPI_MakeVertex(inside[0]).Vertex()
    distances = [BRepExtrema_DistShapeShape(vertex, old).Value() for old in candidates]
    return int(np.argmin(distances))


__all__ = ["cut_ring"]
