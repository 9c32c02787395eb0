"""Plane annuli divided across: the ends of a round tube and the rim of a drawn box become linking sides.

Place in the flow: called by the pipeline for a part that has no sweep as it is. A tube with holes through its wall is
swept across the wall, from outside to inside, and so is a box of sheet; its ends are then sides, but a face with a
hole is no rectangle. Straight edges from vertices of the hole to those of the outer loop divide it, where the closed
faces beside it are divided already.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.gp import gp_Pnt

from ...brep import Face, Part, Solid
from ..shapes import SolidShape
from .notes import ANNULI_NOTE
from .splitting import divided_part

_STRAIGHT = pi / 6
"""Radians by which a loop may turn at a vertex that is no corner."""


def divide_annuli(part: Part) -> Part | None:
    """Divide every plane face with one hole whose loops have no corners.

    Parameters
    ----------
    part : Part
        One solid.

    Returns
    -------
    Part
        The same solid, its old faces first.
    None
        Where no face is to be divided, or OpenCASCADE fails at it.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return None
    solid = part.solids[0]
    lines = [_dividing_lines(solid, face) for face in solid.faces if _is_annulus(face)]
    cuts = [line for across in lines for line in across]
    n_divided = sum(bool(across) for across in lines)
    divided = divided_part(part, cuts, n_more=len(cuts) - n_divided)
    return None if divided is None else replace(divided, notes=(*part.notes, f"{ANNULI_NOTE}: {n_divided}"))


def _is_annulus(face: Face) -> bool:
    """Whether a face is plane and bounded by two loops without corners."""
    angles = [angle for loop in face.loops for angle in loop.angles]
    return face.kind == "plane" and len(face.loops) == 2 and all(abs(angle - pi) < _STRAIGHT for angle in angles)


def _dividing_lines(solid: Solid, face: Face) -> list[Any]:
    """Straight edges between the loops of a face.

    Where the loops have their vertices opposite each other, one at each; else two, at the vertices of the hole that
    lie farthest apart.
    """
    outer, hole = (
        np.array([solid.vertices[solid.first_vertex(directed)] for directed in loop.directed]) for loop in face.loops
    )
    across = np.linalg.norm(hole[:, None] - outer, axis=2)
    nearest = np.argmin(across, axis=1)
    apart = np.linalg.norm(hole[:, None] - hole, axis=2) * (nearest[:, None] != nearest)
    j, k = np.unravel_index(int(np.argmax(apart)), apart.shape)
    if not apart[j, k] > 0.0 or not across.min() > 0.0:
        return []  # loops that touch leave no way around between them
    alike = len(hole) == len(outer) == len(set(nearest.tolist()))
    ends = [(hole[i], outer[nearest[i]]) for i in (range(len(hole)) if alike else (j, k))]
    return [BRepBuilderAPI_MakeEdge(gp_Pnt(*a), gp_Pnt(*b)).Edge() for a, b in ends]


__all__ = ["divide_annuli"]
