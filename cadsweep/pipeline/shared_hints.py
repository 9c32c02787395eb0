"""The user's words for sizes and counts in a part of several cells: of solids, faces and edges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from .. import cad
from ..brep import Part
from ..errors import InputError, did_you_mean
from ..intervals import KeyDemand, Wishes
from ..options import SweepOptions
from .biases import names_edges
from .edge_pieces import pieces_along
from .named_faces import faces_called
from .subsets import subset


@dataclass(frozen=True, kw_only=True)
class LocalHints:
    """The words of `sizes`, `counts` and `biases` that mean something in one solid, or in several that touch."""

    sizes: dict[str, float]
    counts: dict[str, int]
    biases: dict[str, Any]


def check_words(part: Part, options: SweepOptions) -> None:
    """Refuse words that nothing in the whole part is called by.

    Raises
    ------
    InputError
        Names the word, and what the solids are called.
    """
    solids = {model.name for model in part.models}
    for option, words in (("sizes", options.sizes), ("counts", options.counts)):
        for word in words or {}:
            if option == "sizes" and word in solids:
                continue
            if not any(True for _ in _edges(part, word)):
                raise InputError(
                    f"{option}: no face or edge of any solid is called '{word}'"
                    f"{did_you_mean(word, solids)}; the solids are " + ", ".join(sorted(solids)[:12])
                )
    for word in options.biases or {}:
        if not names_edges(part, word):
            raise InputError(
                f"biases: no edge of any solid is called '{word}'; the solids are {', '.join(sorted(solids)[:12])}"
            )


def local_hints(part: Part, options: SweepOptions) -> LocalHints:
    """Of what is asked for, that which is about the faces and edges of this one solid."""
    names = {model.name for model in part.models}
    return LocalHints(
        sizes={w: s for w, s in (options.sizes or {}).items() if w not in names and any(True for _ in _edges(part, w))},
        counts={w: n for w, n in (options.counts or {}).items() if any(True for _ in _edges(part, w))},
        biases=local_biases(part, options),
    )


def local_biases(part: Part, options: SweepOptions) -> dict[str, Any]:
    """The gradings that are about edges of these solids."""
    return {word: bias for word, bias in (options.biases or {}).items() if names_edges(part, word)}


def resolve_wishes(part: Part, options: SweepOptions, model: Part) -> Wishes:
    """Find the cells and edges that the user means, by key, sizes in working units.

    The words are about `model`, the part before it was cut: its names, ids and selectors are those that the user knows.
    """
    sizes = options.sizes or {}
    owners = {model.name: j for j, model in enumerate(part.models)}
    by_owner = {owners[word]: size / part.scale for word, size in sizes.items() if word in owners}
    found: dict[str, dict[int, float]] = {"face": {}, "edge": {}}
    for word, size in sizes.items():
        if word in owners:
            continue
        for kind, key, _ in _pieces(part, model, word):
            found[kind][key] = min(found[kind].get(key, size), size)
        for key in _across(part, model, word):
            found["face"][key] = min(found["face"].get(key, size), size)
    demands = []
    for word, count in (options.counts or {}).items():
        pieces: dict[str, set[int]] = {}
        for _, key, whole in _pieces(part, model, word):
            # The pieces of one edge of the input get the count together: it is the edge that the user knows.
            pieces.setdefault(whole, set()).add(key)
        demands += [
            KeyDemand(keys=tuple(sorted(keys)), count=count, label=f"{count} on '{word}'") for keys in pieces.values()
        ]
    return Wishes(
        size=None if options.size is None else options.size / part.scale,
        layers=options.layers,
        cell_sizes={cell: by_owner[o] for cell, o in enumerate(part.owners) if o in by_owner},
        edge_sizes={key: size / part.scale for key, size in (found["face"] | found["edge"]).items()},
        demands=demands,
    )


def _across(part: Part, model: Part, word: str) -> Iterator[int]:
    """Keys of the edges along which cuts divide the faces that a word names: they are as fine as the face."""
    if part is not model and any(kind == "face" for kind, _, _ in _edges(model, word)):
        for cell, face in faces_called(part, model, word, outer=False):
            solid = part.solids[cell]
            yield from (int(solid.edge_keys[e]) for e in solid.faces[face].edges)


def _pieces(part: Part, model: Part, word: str) -> Iterator[tuple[str, int, str]]:
    """What the word names, the keys of the edges of the cells there, and the edge of the input that each is of."""
    for kind, cell, edge in _edges(model, word):
        own = model.solids[cell].edges[edge]
        for key, _, _ in pieces_along(part, model, cell, edge):
            yield kind, key, own.key or f"solid {cell} edge {edge}"


def _edges(part: Part, word: str) -> Iterator[tuple[str, int, int]]:
    """What the word names (``"face"`` or ``"edge"``), the cell, and the edge, wherever it names something."""
    for cell in range(len(part.solids)):
        try:
            kind, edges = cad.select_edges_of(subset(part, [cell]), word)
        except InputError:
            continue  # the word is about other solids; `check_words` refuses those that are about none
        yield from ((kind, cell, edge) for edge in edges)
