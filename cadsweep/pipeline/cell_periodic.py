"""Matched faces of a part of several cells: pieces of two faces that answer each other under one motion.

The faces that the user names are those of the part before it was cut; their pieces belong to any cells. The cuts must
divide both alike.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import cad
from ..blocks.joined import neighbours_of
from ..brep import Edge, Part
from ..errors import InputError, SurfaceMeshError
from ..options import SweepOptions
from ..surface import Motion, Partners
from .periodic import SAME, edge_images, motions_between

Place = tuple[int, int]
"""A cell, and its id of a face."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CellMatch:
    """Two groups of faces and what carries the one to the other.

    Attributes
    ----------
    words : (str, str)
    places : (frozenset of (int, int), frozenset of (int, int))
    motion : Motion
    """

    words: tuple[str, str]
    places: tuple[frozenset[Place], frozenset[Place]]
    motion: Motion


def faces_called(part: Part, model: Part, word: str | int, *, outer: bool = True) -> frozenset[Place]:
    """The (outer) faces of a part's cells that are pieces of what a word names in the part before it was cut.

    Raises
    ------
    InputError
        Nothing has such a name.
    """
    wanted = {
        (model.models[model.owners[cell]].name, model.solids[cell].faces[f].key)
        for cell, f in cad.select_faces_of_all(model, word)
    }
    beyond = neighbours_of(part)
    return frozenset(
        (cell, face.id)
        for cell, solid in enumerate(part.solids)
        for face in solid.faces
        if (part.models[part.owners[cell]].name, face.key) in wanted and not (outer and (cell, face.id) in beyond)
    )


def find_cell_matches(part: Part, model: Part, options: SweepOptions) -> list[CellMatch]:
    """The matched faces of a part, before it is known how its cells divide them.

    Raises
    ------
    InputError
        A name that no face has, or faces that no translation or rotation carries to each other.
    """
    found = []
    for one, other in (options.periodic or {}).items():
        words = (str(one), str(other))
        places = (faces_called(part, model, one), faces_called(part, model, other))
        for word, own in zip(words, places, strict=True):
            if not own:
                raise InputError(f"periodic: '{word}' lies between solids: there it is no boundary of the mesh")
        if places[0] & places[1]:
            raise InputError(f"periodic: '{words[0]}' and '{words[1]}' have a face in common")
        sets = [[part.solids[cell].faces[f] for cell, f in sorted(own)] for own in places]
        near = SAME * max(solid.size for solid in part.solids) + max(solid.tolerance for solid in part.solids)
        rims = [_rim(part, own) for own in places]
        for motion in motions_between(sets[0], sets[1]):
            back = motion.inverse()
            if _lies_on(rims[0], rims[1], motion, near) and _lies_on(rims[1], rims[0], back, near):
                found.append(CellMatch(words=words, places=places, motion=motion))
                break
        else:
            raise InputError(
                f"periodic: no translation or rotation carries '{words[0]}' to '{words[1]}': their outlines differ"
            )
    return found


_SAMPLES = 9
"""Places along an edge of an outline that is held against the other one."""


def _edges(part: Part, places: frozenset[Place]) -> dict[int, Edge]:
    """Edges of faces, by key."""
    return {
        int(part.solids[cell].edge_keys[e]): part.solids[cell].edges[e]
        for cell, f in sorted(places)
        for e in part.solids[cell].faces[f].edges
    }


def _rim(part: Part, places: frozenset[Place]) -> list[Edge]:
    """The edges that one of the faces alone has: the outline, whatever divides it inside."""
    seen = Counter(key for place in places for key in _outline(part, place))
    return [edge for key, edge in _edges(part, places).items() if seen[key] == 1]


def _lies_on(rim: Sequence[Edge], other: Sequence[Edge], motion: Motion, near: float) -> bool:
    """Whether an outline is carried onto another one."""
    at = np.linspace(0.0, 1.0, _SAMPLES)
    image = motion(np.concatenate([edge.curve.evaluate(at) for edge in rim]))
    return bool((np.min([edge.curve.distance(image) for edge in other], axis=0) <= near).all())


def partners_of(part: Part, matches: Sequence[CellMatch]) -> list[Partners]:
    """Which edges and faces of the cells are the images of which.

    Raises
    ------
    SurfaceMeshError
        The cells divide two matched faces in different places; names the cell and the edge without an image.
    """
    found = []
    for match in matches:
        one, other = (_edges(part, own) for own in match.places)
        size, tolerance = max(s.size for s in part.solids), max(s.tolerance for s in part.solids)
        edges, alone = edge_images(one, other, match.motion, SAME * size + tolerance)
        if alone:
            raise _divided_differently(part, match, alone[0])
        by_edges = {_outline(part, place): place for place in match.places[1]}
        faces = {}
        for cell, f in match.places[0]:
            image = by_edges.get(frozenset(edges[key][0] for key in _outline(part, (cell, f))))
            if image is None:
                raise _divided_differently(part, match, min(_outline(part, (cell, f))))
            there, g = image
            faces[int(part.solids[cell].face_keys[f])] = int(part.solids[there].face_keys[g])
        found.append(Partners(motion=match.motion, edges=edges, faces=faces))
    return found


def _outline(part: Part, place: Place) -> frozenset[int]:
    cell, f = place
    solid = part.solids[cell]
    return frozenset(int(solid.edge_keys[e]) for e in solid.faces[f].edges)


def _divided_differently(part: Part, match: CellMatch, key: int) -> SurfaceMeshError:
    for own, (word, partner), motion in zip(
        match.places, (match.words, match.words[::-1]), (match.motion, match.motion.inverse()), strict=True
    ):
        for cell, f in sorted(own):
            solid = part.solids[cell]
            if key in solid.edge_keys[list(solid.faces[f].edges)]:
                edge = solid.edges[solid.edge_keys.tolist().index(key)]
                where = solid.units.place(motion(edge.midpoint[None])[0])
                return SurfaceMeshError(
                    f"periodic: {edge.label()} divides {solid.faces[f].label()} of '{word}' (cell {cell} of "
                    f"'{part.models[part.owners[cell]].name}'), and nothing divides '{partner}' at its image, around "
                    f"({where}): cut there, too, with cuts"
                )
    raise AssertionError("the edge is on one of the faces")
