"""Faces that only divide one plane or cylinder, merged again.

Place in the flow: called by the pipeline for a part that has no sweep, or whose caps are divided in ways
that do not correspond, as it is; divisions that recognition can use stay as they are.

Method: OpenCASCADE's ``ShapeUpgrade_UnifySameDomain``, kept away from every edge but those to give up:
both faces lie on one plane or cylinder, their names do not differ, and the edge was not made by dividing a
closed face.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

from ..errors import CadError
from ..topology import Edge, Part, Solid
from .extract import Labels, extract_solid
from .shapes import FACE, SOLID, SolidShape, index_map, mapped, subshapes
from .validate import check_closed

_SMOOTH = 1e-6
"""Radians from pi within which two planes or cylinders count as one."""


def merge_faces(part: Part) -> Part | None:
    """Merge faces that divide one plane or cylinder.

    Parameters
    ----------
    part : Part
        One solid.

    Returns
    -------
    Part or None
        The same solid with fewer faces; None where there is nothing to merge, or OpenCASCADE cannot.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].write_brep, SolidShape):
        return None
    solid, holder = part.solids[0], part.solids[0].write_brep
    given_up = [edge.id for edge in solid.edges if _divides_one_surface(solid, edge)]
    if not given_up:
        return None
    tool = ShapeUpgrade_UnifySameDomain(holder.shape, True, True, False)
    for edge in solid.edges:
        if edge.id not in given_up:
            tool.KeepShape(holder.edges[edge.id])
    try:
        tool.Build()
        (shape,) = subshapes(tool.Shape(), SOLID)
        check_closed(shape)
        history = tool.History()
        found = index_map(shape, FACE)
        origin: dict[int, int] = {}
        for face in reversed(solid.faces):
            old = holder.faces[face.id]
            for new in list(history.Modified(old)) or [old]:
                if found.Contains(new):
                    origin[found.FindIndex(new) - 1] = face.id
        numbers = range(len(mapped(found, FACE)))
        labels = Labels(
            [solid.faces[origin[j]].key if j in origin else "" for j in numbers],
            [solid.faces[origin[j]].name if j in origin else None for j in numbers],
        )
        merged = extract_solid(shape, labels=labels, name=solid.name, material=solid.material)
    except (CadError, ValueError):
        return None  # the part as it was is refused with its own reasons
    n_less = len(solid.faces) - len(merged.faces)
    if n_less <= 0 or abs(merged.volume - solid.volume) > 1e-6 * solid.volume:
        return None
    note = f"faces merged with their neighbours in one plane or cylinder: {n_less}; the edges between them are gone"
    return replace(part, solids=(merged,), notes=(*part.notes, note))


def _divides_one_surface(solid: Solid, edge: Edge) -> bool:
    one, other = (solid.faces[f] for f in edge.faces)
    return (
        one.kind == other.kind
        and one.kind in ("plane", "cylinder")
        and abs(edge.dihedral - pi) < _SMOOTH
        and one.name == other.name
        and one.key != other.key
    )
