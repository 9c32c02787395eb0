"""Cells of a part that hang together, a part with some of its cells alone, and one whose solids share nothing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
import scipy

from ...blocks.joined import neighbours_of
from ...brep import Part
from ...errors import InputError, did_you_mean


def touching_groups(part: Part) -> list[list[int]]:
    """Cells that hang together by faces, edges or vertices."""
    pairs = []
    for kind in ("vertex_keys", "edge_keys", "face_keys"):
        seen: dict[int, int] = {}
        for cell, solid in enumerate(part.solids):
            pairs += [(seen.setdefault(key, cell), cell) for key in getattr(solid, kind).tolist()]
    n, ends = len(part.solids), np.array(pairs).T
    graph = scipy.sparse.coo_matrix((np.ones(len(pairs), dtype=np.int8), ends), shape=(n, n))
    _, group = scipy.sparse.csgraph.connected_components(graph, directed=False)
    return sorted(np.flatnonzero(group == j).tolist() for j in range(group.max() + 1))


def subset(part: Part, cells: Sequence[int]) -> Part:
    """The part with some of its cells alone."""
    owners = sorted({part.owners[cell] for cell in cells})
    return replace(
        part,
        solids=tuple(part.solids[cell] for cell in cells),
        owners=tuple(owners.index(part.owners[cell]) for cell in cells),
        models=tuple(part.models[owner] for owner in owners),
    )


def chosen_solids(part: Part, *, only: Sequence[str] | None, skip: Sequence[str] | None) -> Part:
    """A part that is loaded, with the solids that the user wants.

    Raises
    ------
    InputError
        A name that no solid has, or nothing is left.
    """
    names = [model.name for model in part.models]

    def called(word: str) -> list[str]:
        """Unique names that a word is, or was before they were made unique."""
        return [name for name in names if word in (name, part.names.get(name))]

    for option, words in (("only", only), ("skip", skip)):
        for word in words or ():
            if not called(word):
                raise InputError(
                    f"{option}: no solid is called '{word}'{did_you_mean(word, names)}; "
                    f"the solids are {', '.join(names[:20])}"
                )
    wanted = set(names) if only is None else {name for word in only for name in called(word)}
    wanted -= {name for word in skip or () for name in called(word)}
    if not wanted:
        raise InputError("only and skip leave no solid to be meshed: name fewer to be skipped")
    cells = [cell for cell, owner in enumerate(part.owners) if names[owner] in wanted]
    return part if len(cells) == len(part.solids) else subset(part, cells)


def separated(part: Part, apart: Collection[int] | None = None) -> Part:
    """The part with nothing shared between its solids; faces in contact are called after both, by pairs.

    With `apart`, solids of the model by number, only these share nothing with the others.

    The contact of ``low`` and ``gasket`` is ``low__gasket_1`` on the first and ``low__gasket_2`` on the second: what a
    tie or a contact of a solver asks for.
    """
    beyond = neighbours_of(part)
    side = [1 + owner if apart is None or owner in apart else 0 for owner in range(len(part.models))]
    solids = []
    contacts = set(part.contacts)
    for cell, solid in enumerate(part.solids):
        owner = part.owners[cell]
        faces = list(solid.faces)
        for face in solid.faces:
            other = beyond.get((cell, face.id))
            if other is None or side[part.owners[other[0]]] == side[owner]:
                continue
            low, high = sorted((owner, part.owners[other[0]]))
            called = f"{part.models[low].name}__{part.models[high].name}_{1 if owner == low else 2}"
            contacts.add(called)
            faces[face.id] = replace(face, name=called, groups=face.names)
        shift = {kind: side[owner] * (1 + _largest(part, kind)) for kind in ("vertex_keys", "edge_keys", "face_keys")}
        solids.append(
            replace(
                solid,
                faces=tuple(faces),
                vertex_keys=solid.vertex_keys + shift["vertex_keys"],
                edge_keys=solid.edge_keys + shift["edge_keys"],
                face_keys=solid.face_keys + shift["face_keys"],
            )
        )
    return replace(part, solids=tuple(solids), contacts=frozenset(contacts))


def _largest(part: Part, kind: str) -> int:
    return max(int(getattr(solid, kind).max()) for solid in part.solids)
