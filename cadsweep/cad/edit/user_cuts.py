"""Cuts that a user asks for: planes, faces of the part extended, and shapes of their own.

Place in the flow: before recognition; what comes out is a part of cells like any other.

=========================== ====================================================================
``"plane z=3"``             the plane square to an axis, model units
``"plane 1,1,0,2.5"``       the plane ``1 x + 1 y + 0 z = 2.5``
``"face 12"``, ``"floor"``  the surface of a face, extended; by id, name or CadQuery selector
``"cutter.step"``           the faces of a file
a CadQuery plane            the plane; anything with an origin and a normal ``zDir`` or ``z_dir``
a CadQuery shape            its faces as they are, the part's own extended; anything with ``.wrapped``
=========================== ====================================================================
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_Transform
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps

from ...brep import Part
from ...errors import InputError
from ..loading import FILES, read_model
from ..names.selection import select_faces
from ..shapes import FACE, subshapes
from .cutters import extended_face
from .cutting import cut_cell

_PLANE = re.compile(r"plane\s+(?:([xyz])\s*=\s*(\S+)|(.+))", re.IGNORECASE)
_SAME = 1e-6
"""Share of its size by which a user's face may differ from the part's that it is."""


def apply_cuts(part: Part, cuts: Sequence[Any]) -> Part:
    """Cut all solids of a part by what the user asks for, one after another.

    Raises
    ------
    InputError
        A cut is not understood, or cuts nothing.
    """
    if not isinstance(cuts, list | tuple):  # a string and a shape are sequences, too: of letters and of faces
        raise InputError(f"cuts is a list: write cuts=[...] around {name_of_cut(cuts)}, also around a single one")
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
                f"cut {name_of_cut(cut)} parts no solid cleanly: it passes by, or leaves slivers or short edges; "
                f"corners of the part lie from ({low}) to ({high})"
            )
    return part


def name_of_cut(cut: Any) -> str:
    """What a message calls a cut: the user's words in quotes, a plane as one would write it, else its kind."""
    text = _as_text(cut)
    return f"a shape ({type(cut).__name__})" if text is None else f"'{text}'"


def _as_text(cut: Any) -> str | None:
    """A cut in the words of the table above; None for a shape."""
    if isinstance(cut, str | Path):
        return str(cut).strip()
    normal = getattr(cut, "zDir", getattr(cut, "z_dir", None))
    if normal is None or not hasattr(cut, "origin"):
        return None
    square, through = (
        np.array(tuple(vector.toTuple() if hasattr(vector, "toTuple") else vector)) for vector in (normal, cut.origin)
    )
    return f"plane {','.join(repr(float(number)) for number in (*square, square @ through))}"


def _tools(part: Part, cut: Any) -> list[Any]:
    """The faces of a cut, working units."""
    text = _as_text(cut)
    if text is None:
        return [tool for face in _foreign(part, cut) for tool in _extended_if_own(part, face)]
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


def _extended_if_own(part: Part, tool: Any) -> tuple[Any, ...]:
    """The surface of the part's face that a user's face is, which itself lies on the part and cuts nothing."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(tool, properties)
    center = np.array(properties.CentreOfMass().Coord())
    for solid in part.solids:
        for j, face in enumerate(solid.faces):
            is_there = np.linalg.norm(face.center - center) < _SAME * math.sqrt(face.area)
            if is_there and math.isclose(face.area, properties.Mass(), rel_tol=_SAME):
                return extended_face(solid, j) or (tool,)
    return (tool,)


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
    try:
        shape = read_model(source).shape
    except InputError as error:
        raise InputError(f"cut {name_of_cut(source)}: {error.message}") from error
    if part.scale != 1.0 or part.offset.any():
        shift, stretch = gp_Trsf(), gp_Trsf()
        shift.SetTranslation(gp_Vec(*map(float, -part.offset)))
        stretch.SetScaleFactor(1.0 / part.scale)
        shape = BRepBuilderAPI_Transform(shape, stretch.Multiplied(shift), True).Shape()
    faces = subshapes(shape, FACE)
    if not faces:
        raise InputError(f"cut {name_of_cut(source)} has no face to cut along: give a plane, a face or a solid")
    return faces
