"""Small features of a solid: its roundings, its holes, and the faces that a user names.

Place in the flow: :mod:`.defeaturing` removes them where the user asks for it; refusals count them.

Method. A rounding is a piece of a cylinder, torus or sphere that runs tangent into its neighbours and turns by less
than half a turn, so that the ends of slots are none; roundings that touch are one feature. A hole is a cylinder that
goes all around with the material outside, its two halves together, and whatever is reached through it alone, as its
floor.

Not handled: roundings that are splines, and holes that are not round.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from math import pi

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Sphere, GeomAbs_Torus

from ...brep import Part, Solid
from ...errors import InputError
from ..names.selection import select_faces
from ..shapes import shapes_of
from .axes import is_hollow

TANGENT = 1e-3
"""Radians from pi up to which a rounding runs tangent into its neighbour."""
HALF_TURN = 0.97 * pi
"""Turn of a rounding, at most: more is the end of a slot."""

_WORDS = re.compile(r"(fillets|holes)(?:\s+([rd])\s*<\s*(\S+))?", re.IGNORECASE)
_LETTER = {"fillets": "r", "holes": "d"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Feature:
    """Faces that are removed together.

    Attributes
    ----------
    what : str
        ``"fillet of radius 0.5"``, model units.
    faces : tuple of int
    """

    what: str
    faces: tuple[int, ...]


def find_features(part: Part, word: str) -> list[Feature]:
    """What a user's word means: ``"fillets r<0.5"``, ``"holes d<2"``, ``"fillets"``, ``"face 12"``, a name.

    Raises
    ------
    InputError
        It is not understood.
    """
    (solid,) = part.solids
    match = _WORDS.fullmatch(word.strip())
    if match is None:
        faces = select_faces(part, word)
        return [Feature(what=", ".join(solid.faces[f].label() for f in faces), faces=faces)]
    kind, letter, number = match[1].lower(), (match[2] or "").lower(), match[3]
    limit = np.inf
    if number is not None:
        try:
            limit = float(number) / part.scale
        except ValueError:
            limit = np.nan
        if letter != _LETTER[kind] or not limit > 0:
            raise InputError(f"suppress '{word}': write 'fillets r<0.5', 'holes d<2', or a face's name or number")
    return list(find_fillets(solid, limit, part.scale) if kind == "fillets" else find_holes(solid, limit, part.scale))


def find_fillets(solid: Solid, below: float, scale: float = 1.0) -> Iterator[Feature]:
    """Roundings of a radius below a limit, working units, those that touch together; labels in units of `scale`."""
    radii: dict[int, float] = {}
    for face, shape in zip(solid.faces, shapes_of(solid).faces, strict=True):
        adaptor = BRepAdaptor_Surface(shape)
        kind = adaptor.GetType()
        if kind == GeomAbs_Cylinder:
            radius, turn = adaptor.Cylinder().Radius(), adaptor.LastUParameter() - adaptor.FirstUParameter()
        elif kind == GeomAbs_Torus:
            radius, turn = adaptor.Torus().MinorRadius(), adaptor.LastVParameter() - adaptor.FirstVParameter()
        elif kind == GeomAbs_Sphere:
            radius, turn = adaptor.Sphere().Radius(), 0.0
        else:
            continue
        n_tangent = sum(abs(solid.edges[e].dihedral - pi) < TANGENT for e in face.edges)
        if radius < below and turn < HALF_TURN and n_tangent >= 2:
            radii[face.id] = radius
    for faces in hanging_together(solid, radii):
        radius = max(radii[f] for f in faces)
        yield Feature(what=f"fillet of radius {radius * scale:.4g}", faces=tuple(faces))


def find_holes(solid: Solid, below: float, scale: float = 1.0) -> Iterator[Feature]:
    """Round holes of a diameter below a limit, working units; labels in units of `scale`."""
    walls: dict[int, float] = {}
    for face, shape in zip(solid.faces, shapes_of(solid).faces, strict=True):
        adaptor = BRepAdaptor_Surface(shape)
        if adaptor.GetType() != GeomAbs_Cylinder or 2.0 * adaptor.Cylinder().Radius() >= below:
            continue
        axis = adaptor.Cylinder().Axis()
        place = np.array([axis.Location().X(), axis.Location().Y(), axis.Location().Z()])
        along = np.array([axis.Direction().X(), axis.Direction().Y(), axis.Direction().Z()])
        u, v = (
            0.5 * (adaptor.FirstUParameter() + adaptor.LastUParameter()),
            0.5 * (adaptor.FirstVParameter() + adaptor.LastVParameter()),
        )
        at = adaptor.Value(u, v)
        if is_hollow(face, np.array([at.X(), at.Y(), at.Z()]), place, along):
            walls[face.id] = adaptor.LastUParameter() - adaptor.FirstUParameter()
    for faces in hanging_together(solid, walls):
        if sum(walls[f] for f in faces) < 2.0 * pi - TANGENT:
            continue
        radius = max(BRepAdaptor_Surface(shapes_of(solid).faces[f]).Cylinder().Radius() for f in faces)
        inside = _reached_through(solid, faces)
        yield Feature(what=f"hole of diameter {2.0 * radius * scale:.4g}", faces=tuple(sorted({*faces, *inside})))


def hanging_together(solid: Solid, faces: Collection[int]) -> list[list[int]]:
    """Groups of the given faces that hang together at edges."""
    left, found = set(faces), []
    while left:
        waiting, own = [min(left)], set[int]()
        while waiting:
            face = waiting.pop()
            if face in own:
                continue
            own.add(face)
            waiting += [f for e in solid.faces[face].edges for f in solid.edges[e].faces if f in left]
        left -= own
        found.append(sorted(own))
    return found


def _reached_through(solid: Solid, faces: Collection[int]) -> set[int]:
    """Faces that hang together with the rest of the solid by the given ones alone."""
    others = hanging_together(solid, {face.id for face in solid.faces} - set(faces))
    if len(others) < 2:
        return set()
    outside = max(others, key=lambda group: sum(solid.faces[f].area for f in group))
    touched = {f for face in faces for e in solid.faces[face].edges for f in solid.edges[e].faces}
    return {f for group in others if group is not outside and touched & set(group) for f in group}


__all__ = ["Feature", "find_features", "find_fillets", "find_holes", "hanging_together"]
