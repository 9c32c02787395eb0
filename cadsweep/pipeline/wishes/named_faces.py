"""Which faces of a part's cells the user's words mean, and which of its solids have any.

A selector chooses among the faces of the whole model: ``"<Y"`` are its outermost faces, and not those of every solid.
"""

from __future__ import annotations

from ... import cad
from ...blocks.joined import neighbours_of
from ...brep import Part
from ...errors import InputError

Place = tuple[int, int]
"""A cell, and its id of a face."""


def faces_called(part: Part, model: Part, word: str | int, *, outer: bool = True) -> frozenset[Place]:
    """The (outer) faces of a part's cells that are pieces of what a word names in the part before it was cut.

    Raises
    ------
    InputError
        Nothing has such a name.
    """
    named = cad.select_faces_of_all(model, word)
    beyond = neighbours_of(part)
    if part is model:
        return frozenset(place for place in named if not (outer and place in beyond))
    wanted = {(model.models[model.owners[cell]].name, model.solids[cell].faces[f].key) for cell, f in named}
    return frozenset(
        (cell, face.id)
        for cell, solid in enumerate(part.solids)
        for face in solid.faces
        if (part.models[part.owners[cell]].name, face.key) in wanted and not (outer and (cell, face.id) in beyond)
    )


def solids_with(part: Part, word: str | int) -> frozenset[int]:
    """The solids of a part that have a face which a word means; none where nothing is called so."""
    try:
        return frozenset(cell for cell, _ in cad.select_faces_of_all(part, word))
    except InputError:
        return frozenset()  # whoever asks says what the word was for
