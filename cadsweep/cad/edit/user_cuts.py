"""Cuts that a user asks for: planes, faces of the part extended, and shapes of their own.

Place in the flow: before recognition; what comes out is a part of cells like any other.

=========================== ====================================================================
``"plane z=3"``             the plane square to an axis, model units
``"plane 1,1,0,2.5"``       the plane ``1 x + 1 y + 0 z = 2.5``
``"face 12"``, ``"floor"``  the surface of a face, extended; by id, name or CadQuery selector
``"cutter.step"``           the faces of a file
a CadQuery object           its faces; anything with ``.wrapped``
=========================== ====================================================================
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_Transform
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec

from ...brep import Part
from ...errors import InputError
from ..loading import FILES, read_model
from ..names.selection import select_faces
from ..shapes import FACE, subshapes
from .cutters import extended_face
from .cutting import cut_cell

_PLANE = re.compile(r"plane\s+(?:([xyz])\s*=\s*(\S+)|(.+))", re.IGNORECASE)


def apply_cuts(part: Part, cuts: Sequence[Any]) -> Part:
    """Cut all solids of a part by what the user asks for, one after another.

    Raises
    ------
    InputError
        A cut is not understood, or cuts nothing.
    """
    tools = [(cut, _tools(part, cut)) for cut in cuts]
    for cut, faces in tools:
        cell, found = 0, False
        while cell < len(part.solids):
            pieces = cut_cell(part, cell, faces)
            if pieces is None:
                cell += 1
                continue
            cell += 1 + len(pieces.solids) - len(part.solids)
            part, found = pieces, True
        if not found:
            corners = np.concatenate([solid.vertices for solid in part.solids])
            low, high = (part.solids[0].units.place(end) for end in (corners.min(axis=0), corners.max(axis=0)))
            raise InputError(
                f"cut {_word(cut)} parts no solid cleanly: it passes by, or leaves slivers or short edges; corners of "
                f"the part lie from ({low}) to ({high})"
            )
    return part


def _word(cut: Any) -> str:
    return f"'{cut}'" if isinstance(cut, str | Path) else type(cut).__name__


def _tools(part: Part, cut: Any) -> list[Any]:
    """The faces of a cut, working units."""
    if not isinstance(cut, str | Path):
        return _foreign(part, cut)
    text = str(cut).strip()
    match = _PLANE.fullmatch(text)
    if match:
        return [_plane(part, text, match)]
    if Path(text).suffix.lower() in FILES:
        return _foreign(part, text)
    for solid in part.solids:
        for face in select_faces(part, text):
            made = extended_face(solid, face)
            if made:
                return list(made)
            raise InputError(f"cut '{text}': {solid.faces[face].label()} is of a kind that cannot be extended")
    raise InputError(f"cut '{text}' is no plane, face or file")


def _plane(part: Part, text: str, match: re.Match[str]) -> Any:
    """A plane face larger than the part."""
    try:
        if match[1]:
            normal, offset = np.eye(3)["xyz".index(match[1].lower())], float(match[2])
        else:
            *direction, offset = (float(number) for number in match[3].split(","))
            normal = np.array(direction)
    except ValueError:
        normal, offset = np.zeros(0), 0.0
    if normal.shape != (3,) or not np.isfinite([*normal, offset]).all() or not normal.any():
        raise InputError(f"cut '{text}': write 'plane z=3', or 'plane 1,1,0,2.5' for 1 x + 1 y + 0 z = 2.5")
    length = float(np.linalg.norm(normal))
    normal = normal / length
    corners = np.concatenate([solid.vertices for solid in part.solids])
    center, reach = corners.mean(axis=0), 2.0 * float(np.linalg.norm(np.ptp(corners, axis=0)))
    there = (offset / length - normal @ part.offset) / part.scale
    foot = center - (normal @ center - there) * normal
    plane = gp_Pln(gp_Pnt(*map(float, foot)), gp_Dir(*map(float, normal)))
    return BRepBuilderAPI_MakeFace(plane, -reach, reach, -reach, reach).Face()


def _foreign(part: Part, source: Any) -> list[Any]:
    """The faces of a user's own shape, brought to working units."""
    shape = read_model(source).shape
    if part.scale != 1.0 or part.offset.any():
        shift, stretch = gp_Trsf(), gp_Trsf()
        shift.SetTranslation(gp_Vec(*map(float, -part.offset)))
        stretch.SetScaleFactor(1.0 / part.scale)
        shape = BRepBuilderAPI_Transform(shape, stretch.Multiplied(shift), True).Shape()
    return subshapes(shape, FACE)
