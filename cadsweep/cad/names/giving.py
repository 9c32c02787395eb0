"""Names that a user gives to faces and edges of a loaded part, beside those of the model.

Place in the flow: after loading, before anything is changed or cut; names go with the faces from there on, as those
that the model came with.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ...brep import Edge, Face, ModelSolid, Part, Solid
from ...errors import InputError
from ..imprinting.apart import Original
from .selection import select_edges, select_faces
from .unique import make_plain_names


def give_names(part: Part, names: Mapping[str, str | int | Sequence[str | int]]) -> Part:
    """Name faces and edges.

    Parameters
    ----------
    part : Part
    names : mapping of str to str, int, or sequence of them
        To each name what it is given to: an id (``"face 7"``, ``"edge 12"``), a name, a CadQuery selector; of one
        solid of several ``"pin: face 7"``. What has a name already is found by it still.

    Returns
    -------
    Part

    Raises
    ------
    InputError
        Nothing is chosen, or something else has the name already.
    """
    words, notes = make_plain_names(names)
    given: dict[int, dict[tuple[str, str], list[str]]] = {}
    for name, chosen in names.items():
        for word in [chosen] if isinstance(chosen, str | int) else chosen:
            for cell, kind, ids in _meant(part, word):
                solid = part.solids[cell]
                items: Sequence[Face | Edge] = solid.faces if kind == "face" else solid.edges
                keys = {items[j].key or f"{kind} {j}" for j in ids}
                every = {j for j, item in enumerate(items) if item.key in keys} | set(ids)
                _check_free(items, every, words[name], part)
                for j in ids:
                    given.setdefault(cell, {}).setdefault((kind, str(j)), []).append(words[name])
    if not given:
        return part
    shared = _of_neighbours(part, given)
    solids = tuple(_named(solid, shared.get(cell, {})) for cell, solid in enumerate(part.solids))
    models = tuple(
        _model_named(model, [s for s, owner in zip(solids, part.owners, strict=True) if owner == number])
        for number, model in enumerate(part.models)
    )
    changed = {words[name]: name for name in names if words[name] != name}
    return replace(part, solids=solids, models=models, names=part.names | changed, notes=(*part.notes, *notes))


def _meant(part: Part, word: str | int) -> list[tuple[int, str, tuple[int, ...]]]:
    """Cell, kind and ids of what a word chooses."""
    text = str(word).strip()
    head, colon, rest = text.partition(":")
    cells = [j for j, owner in enumerate(part.owners) if colon and head.strip() == part.models[owner].name]
    if cells and rest.strip():
        text = rest.strip()
    else:
        cells = list(range(len(part.solids)))
    kind = "edge" if text.startswith(("edge ", "edges:")) else "face"
    select = select_edges if kind == "edge" else select_faces
    found, missing = [], None
    for cell in cells:
        one = replace(part, solids=(part.solids[cell],), owners=(0,), models=(part.models[part.owners[cell]],))
        try:
            found.append((cell, kind, select(one, text)))
        except InputError as error:
            missing = error
    if not found:
        assert missing is not None, "a part has solids"
        raise missing
    if len(found) > 1 and text.removeprefix(kind).strip().isdigit():
        raise InputError(
            f"every solid has its own {text}; write '{part.models[0].name}: {text}', or another solid's name"
        )
    return found


def _check_free(items: Sequence[Face | Edge], mine: set[int], name: str, part: Part) -> None:
    """Refuse a name that something else has; written alike in another case it is the same to a solver."""
    for j, item in enumerate(items):
        if j not in mine and name.casefold() in (known.casefold() for known in item.names):
            raise InputError(f"{item.label()} is called '{name}' already; choose another name")


def _of_neighbours(
    part: Part, given: Mapping[int, Mapping[tuple[str, str], list[str]]]
) -> dict[int, dict[tuple[str, str], list[str]]]:
    """The same, with what two cells share named in both."""
    found: dict[int, dict[tuple[str, str], list[str]]] = {cell: dict(own) for cell, own in given.items()}
    for cell, own in given.items():
        for (kind, number), names in own.items():
            keys = part.solids[cell].face_keys if kind == "face" else part.solids[cell].edge_keys
            for other, solid in enumerate(part.solids):
                theirs = solid.face_keys if kind == "face" else solid.edge_keys
                for j in (theirs == keys[int(number)]).nonzero()[0] if other != cell else ():
                    found.setdefault(other, {}).setdefault((kind, str(j)), []).extend(names)
    return found


def _named(solid: Solid, given: Mapping[tuple[str, str], list[str]]) -> Solid:
    if not given:
        return solid

    def names(item: Face | Edge, kind: str) -> dict[str, Any]:
        own = given.get((kind, str(item.id)), [])
        every = tuple(dict.fromkeys((*own, *item.names)))
        return {"name": every[0], "groups": every[1:]} if own else {}

    return replace(
        solid,
        faces=tuple(replace(face, **names(face, "face")) for face in solid.faces),
        edges=tuple(replace(edge, **names(edge, "edge")) for edge in solid.edges),
    )


def _model_named(model: ModelSolid, cells: Sequence[Solid]) -> ModelSolid:
    """The solid as it was before others were imprinted on it, which has labels of its own."""
    if not isinstance(model.kernel, Original):
        return model
    labels = model.kernel.labels
    faces = {face.key: face.names for solid in cells for face in solid.faces if face.key}
    edges = {edge.key: edge.names for solid in cells for edge in solid.edges if edge.key}
    now = labels._replace(
        faces=[label._replace(names=faces.get(label.key, label.names)) for label in labels.faces],
        edges=[label._replace(names=edges.get(label.key, label.names)) for label in labels.edges],
    )
    return replace(model, kernel=replace(model.kernel, labels=now))


__all__ = ["give_names"]
