"""The user's words for sizes and counts, of solids, faces and edges, as keys: for sweeps, cells and columns alike."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from ... import cad
from ...brep import Part
from ...errors import InputError, did_you_mean
from ...intervals import KeyDemand, Wishes
from ...options import SweepOptions
from ..complexes.subsets import subset
from .edge_pieces import pieces_along
from .named_faces import faces_called

Select = Callable[[Part, str], tuple[str, tuple[int, ...]]]
"""What a word names in a part of one solid (``"face"`` or ``"edge"``), and the edges there."""


def _of_edges(part: Part, word: str) -> tuple[str, tuple[int, ...]]:
    """What is asked of edges, and of no faces."""
    return "edge", cad.select_edges(part, word)


def check_words(part: Part, options: SweepOptions) -> None:
    """Refuse words that nothing in the whole part is called by.

    Raises
    ------
    InputError
        Names the word, and what the solids are called.
    """
    solids = {model.name for model in part.models}
    asked = (("sizes", options.sizes, cad.select_edges_of), ("counts", options.counts, _of_edges))
    for option, words, select in (*asked, ("biases", options.biases, _of_edges)):
        for word in words or {}:
            if (option == "sizes" and word in solids) or any(_edges(part, word, select)):
                continue
            if len(part.solids) == 1:
                select(part, word)  # says what there is
            what = "face or edge" if option == "sizes" else "edge"
            raise InputError(
                f"{option}: no {what} of any solid is called '{word}'{did_you_mean(word, solids)}; the solids are "
                + ", ".join(sorted(solids)[:12])
            )


def meant_here(part: Part, options: SweepOptions) -> SweepOptions:
    """The options with those words alone that are about faces and edges of these solids."""
    names = {model.name for model in part.models}

    def kept(words: Mapping[str, Any] | None, select: Select) -> dict[str, Any] | None:
        return {w: value for w, value in (words or {}).items() if any(_edges(part, w, select))} or None

    sizes = {w: size for w, size in (options.sizes or {}).items() if w not in names}
    return replace(
        options,
        sizes=kept(sizes, cad.select_edges_of),
        counts=kept(options.counts, _of_edges),
        biases=kept(options.biases, _of_edges),
    )


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
    demands: dict[tuple[int, ...], KeyDemand] = {}
    for word, count in (options.counts or {}).items():
        pieces: dict[str, set[int]] = {}
        for _, key, whole in _pieces(part, model, word, _of_edges):
            # The pieces of one edge of the input get the count together: it is the edge that the user knows.
            pieces.setdefault(whole, set()).add(key)
        for keys in pieces.values():
            demand(part, demands, keys, count, f"counts of '{word}'")
    return Wishes(
        size=None if options.size is None else options.size / part.scale,
        layers=options.layers,
        cell_sizes={cell: by_owner[o] for cell, o in enumerate(part.owners) if o in by_owner},
        edge_sizes={key: size / part.scale for key, size in (found["face"] | found["edge"]).items()},
        demands=tuple(demands.values()),
    )


def demand(part: Part, demands: dict[tuple[int, ...], KeyDemand], keys: Collection[int], count: int, word: str) -> None:
    """Demand a count of edges together, by key, beside what is demanded already.

    Raises
    ------
    InputError
        Another one is demanded of the same edges.
    """
    own = tuple(sorted(keys))
    known = demands.setdefault(own, KeyDemand(keys=own, count=count, label=word))
    if known.count != count:
        edges = [e.label() for s in part.solids for e in s.edges if int(s.edge_keys[e.id]) in own]
        labels = ", ".join(dict.fromkeys(edges))
        raise InputError(f"{labels}: {known.label} asks for {known.count} segments, {word} for {count}")


def _across(part: Part, model: Part, word: str) -> Iterator[int]:
    """Keys of the edges along which cuts divide the faces that a word names: they are as fine as the face."""
    if part is not model and any(kind == "face" for kind, _, _ in _edges(model, word, cad.select_edges_of)):
        for cell, face in faces_called(part, model, word, outer=False):
            solid = part.solids[cell]
            yield from (int(solid.edge_keys[e]) for e in solid.faces[face].edges)


def _pieces(part: Part, model: Part, word: str, select: Select = cad.select_edges_of) -> Iterator[tuple[str, int, str]]:
    """What the word names, the keys of the edges of the cells there, and the edge of the input that each is of."""
    for kind, cell, edge in _edges(model, word, select):
        own = model.solids[cell].edges[edge]
        for key, _, _ in pieces_along(part, model, cell, edge):
            yield kind, key, own.key or f"solid {cell} edge {edge}"


def _edges(part: Part, word: str, select: Select) -> Iterator[tuple[str, int, int]]:
    """What the word names, the cell, and the edge, wherever it names something."""
    for cell in range(len(part.solids)):
        try:
            kind, edges = select(subset(part, [cell]), word)
        except InputError:
            continue  # the word is about other solids; `check_words` refuses those that are about none
        yield from ((kind, cell, edge) for edge in edges)
