"""What the faces of a part are called in its mesh, and in which colours: names of the user, or roles.

Place in the flow: ``pipeline`` names the faces of a complex once its cells have roles; the mesh, what it is checked
against and its pictures know a boundary by the names of its faces.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arrays import IntArray
from ..brep import Part
from .joined import neighbours_of

Place = tuple[int, int]
"""A cell, and its id of a face."""
Piece = tuple[int, int, int]
"""A cell, its id of a face, and the number of a patch of it; -1 for what of the face is no patch."""

CUT = "cut"
"""The role of a face where a ring was cut open: it is inside the mesh."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NamedFaces:
    """What the faces of the cells are called.

    Attributes
    ----------
    outside : dict of (cell, face) to tuple of str
        Boundary names.
    between : dict of (cell, face) to tuple of str
        Interface names, of both cells' faces.
    first : dict of (cell, face) to bool
        Whether an interface's face is that of the solid which its name begins with.
    patches : dict of (cell, face, patch) to tuple of str
        Boundary names of the patches of merged faces.
    """

    outside: dict[Place, tuple[str, ...]]
    between: dict[Place, tuple[str, ...]]
    first: dict[Place, bool]
    patches: dict[Piece, tuple[str, ...]] = field(default_factory=dict)

    def of(self, place: Place) -> tuple[str, ...]:
        """All names of a face; none of a cut."""
        return self.outside.get(place) or self.between.get(place) or ()

    def pieces(self) -> dict[Piece, tuple[str, ...]]:
        """Names of all faces that are no cuts, and of their patches."""
        return {(*place, -1): own for place, own in (self.outside | self.between).items()} | self.patches

    def by_name(self) -> dict[str, list[Piece]]:
        """Faces and patches of every boundary and interface."""
        found: dict[str, list[Piece]] = {}
        for piece, names in self.pieces().items():
            for name in names:
                found.setdefault(name, []).append(piece)
        return found


def name_faces(part: Part, roles: Mapping[Any, str]) -> NamedFaces:
    """Name every face, and every patch of a merged face.

    They keep the names that their user gave them. The others are called by their role in the filling of their cell
    (``source``, ``target``, else ``side``), numbered where there are several (sides always), behind the name of their
    solid where the model has several; pieces of one face of the input share a name. An interface is
    ``first__second``, after the solids that it is between, in the order of the model.

    Parameters
    ----------
    part : Part
    roles : mapping of (cell, face), or (cell, face, patch), to str
        In the order in which the faces of a cell are numbered; sides that are not there come after. A patch has the
        role of its face where it has none of its own.
    """
    beyond = neighbours_of(part)
    named = NamedFaces(outside={}, between={}, first={})
    faces = [face for solid in part.solids for face in solid.faces]
    taken = {name for face in faces for names in (face.names, *(own.names for own in face.former)) for name in names}
    unnamed: dict[tuple[int, str], dict[str, list[Piece]]] = {}
    role_of: dict[tuple[int, str], str] = {}
    every = dict.fromkeys(
        [*(own[:2] for own in roles), *((c, face.id) for c, solid in enumerate(part.solids) for face in solid.faces)]
    )
    for place in sorted(every, key=lambda own: own[0]):
        cell, face = place[0], part.solids[place[0]].faces[place[1]]
        owner, role = part.owners[cell], roles.get(place, "side")
        other = beyond.get(place)
        if role == CUT or (other is not None and part.owners[other[0]] == owner):
            continue
        if other is not None:
            theirs = part.owners[other[0]]
            low, high = sorted((owner, theirs))
            users = (*face.names, *part.solids[other[0]].faces[other[1]].names)
            named.between[place] = tuple(dict.fromkeys((f"{part.models[low].name}__{part.models[high].name}", *users)))
            named.first[place] = owner == low
            continue
        pieces = [(-1, face.names, face.key or f"key {int(part.solids[cell].face_keys[face.id])}")]
        pieces += [(j, patch.names, patch.key) for j, patch in enumerate(face.former)]
        for j, given, key in pieces:
            if given:
                _take(named, (*place, j), given)
            else:
                own = role_of.setdefault((owner, key), roles.get((*place, j), role))
                unnamed.setdefault((owner, own), {}).setdefault(key, []).append((*place, j))
    for (owner, role), by_key in unnamed.items():
        prefix = f"{part.models[owner].name}_" if len(part.models) > 1 else ""
        for number, pieces_of_key in enumerate(by_key.values(), start=1):
            name = prefix + (role if role != "side" and len(by_key) == 1 else f"{role}_{number}")
            while name in taken:
                name += "_"
            for piece in pieces_of_key:
                _take(named, piece, (name,))
    return named


def _take(named: NamedFaces, piece: Piece, names: tuple[str, ...]) -> None:
    """Keep the names of a piece."""
    if piece[2] < 0:
        named.outside[piece[:2]] = names
    else:
        named.patches[piece] = names


def unite_quads(owned: Iterable[tuple[tuple[str, ...], IntArray]]) -> dict[str, IntArray]:
    """Quads of every name, from the names and quads of owners."""
    groups: dict[str, list[IntArray]] = {}
    for names, quads in owned:
        for name in names:
            groups.setdefault(name, []).append(quads)
    return {name: np.concatenate(pieces) for name, pieces in groups.items()}


def find_colors(part: Part, names: NamedFaces) -> dict[str, dict[str, str]]:
    """Colours of the CAD model: ``boundaries`` and ``parts`` by name, empty where there are none.

    A boundary has a colour where all its faces are of that one, and not by being of the part's.
    """
    seen: dict[str, set[str | None]] = {}
    for (cell, f, j), given in names.pieces().items():
        if (cell, f) in names.outside:
            face = part.solids[cell].faces[f]
            for name in given:
                seen.setdefault(name, set()).add((face if j < 0 else face.former[j]).color)
    own = {name: next(iter(colors)) for name, colors in seen.items() if len(colors) == 1}
    return {
        "boundaries": {name: color for name, color in own.items() if color is not None},
        "parts": {model.name: model.color for model in part.models if model.color is not None},
    }
