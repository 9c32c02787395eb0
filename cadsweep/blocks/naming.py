"""What boundaries are called: names of the user, roles in the sweep, and colours.

Place in the flow: called by ``block`` and ``reference``, which both know a boundary by the names of its faces.
"""

from __future__ import annotations

from ..sweep import Sweep


def name_pieces(sweep: Sweep) -> dict[tuple[int, int], tuple[str, ...]]:
    """Name every face of the solid, and every patch of a face.

    They keep the names that their user gave them. The others are ``source``, ``target`` and
    ``side_1``, ``side_2``, ... in the order of the loops; a cap of several unnamed faces is
    ``source_1``, ``source_2``, ... Pieces of one divided face share a name.

    Returns
    -------
    dict of (int, int) to tuple of str
        Boundary names of the faces (face id, -1) and of their patches (face id, number).
    """
    faces = sweep.solid.faces
    roles = [("source", sweep.source), ("target", sweep.target), ("side", [s.face for s in sweep.linking_sides])]
    names: dict[tuple[int, int], tuple[str, ...]] = {}
    pieces: list[tuple[str, list[tuple[tuple[int, int], tuple[str, ...], str]]]] = []
    for role, ids in roles:
        own: list[tuple[tuple[int, int], tuple[str, ...], str]] = []
        for i in ids:
            own.append(((i, -1), faces[i].names, faces[i].key or f"face {i}"))
            own += [((i, j), patch.names, patch.key) for j, patch in enumerate(faces[i].former)]
        pieces.append((role, own))
    taken = {name for _, own in pieces for _, given, _ in own for name in given}
    for role, own in pieces:
        numbers: dict[str, int] = {}
        for _, given, key in own:
            if not given:
                numbers.setdefault(key, len(numbers) + 1)
        for place, given, key in own:
            names[place] = given
            if not given:
                name = role if role != "side" and len(numbers) == 1 else f"{role}_{numbers[key]}"
                while name in taken:
                    name += "_"
                names[place] = (name,)
    return names


def pieces_by_name(sweep: Sweep) -> dict[str, list[tuple[int, int]]]:
    """Faces and patches of every boundary."""
    found: dict[str, list[tuple[int, int]]] = {}
    for piece, names in name_pieces(sweep).items():
        for name in names:
            found.setdefault(name, []).append(piece)
    return found


def find_colors(sweep: Sweep, part: str) -> dict[str, dict[str, str]]:
    """Colours of the CAD model: ``boundaries`` and ``parts`` by name, empty where there are none.

    A boundary has a colour where all its faces are of that one, and not by being of the part's.
    """
    solid = sweep.solid
    boundaries = {}
    for name, pieces in pieces_by_name(sweep).items():
        own = {(solid.faces[i] if j < 0 else solid.faces[i].former[j]).color for i, j in pieces}
        if len(own) == 1 and None not in own:
            boundaries[name] = str(own.pop())
    return {"boundaries": boundaries, "parts": {} if solid.color is None else {part: solid.color}}
