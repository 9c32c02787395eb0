"""What the user's words mean on the design of a solid: names, ids and selectors are those of the model.

Place in the flow: before a design is meshed (:mod:`..designs`). Each word gets a name of its own on the faces and edges
of the design that answer those it means on the model, and the options speak by these.

Method: the faces that a design keeps are known. An edge between two of them is that edge of the design between the same
two which is nearest; an edge between one of them and a blend is the nearest edge of the one. Sizes of what the design
has not hold around it, as local sizes do.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ... import cad
from ...asked import LocalSize, edge_bias
from ...blends import Blend
from ...brep import Part, Solid
from ...errors import InputError, NotSweepableError
from ...mesh import HexMesh
from ...options import SweepOptions
from .biases import SYMMETRIC
from .local_sizes import for_all_solids, no_larger_than, size_field

_TAG = "asked_{}"
"""Name of what a word means, on a design."""
_OF_ENTITIES = ("source", "target", "wall_layers", "periodic", "sizes", "counts", "biases", "local_sizes")


def speaks_of_entities(options: SweepOptions) -> bool:
    """Whether faces and edges of the model are spoken of, which its design has others of."""
    return any(getattr(options, name) is not None for name in _OF_ENTITIES)


def left_to_design(part: Part, blends: Sequence[Blend], options: SweepOptions) -> list[Blend]:
    """Those of the blends of one solid that a design may be without: no caps, walls or faces that answer each other.

    One that lies between such faces may go with them.

    Raises
    ------
    InputError
        Nothing is called so.
    """
    asked = {f for word in _words_of_faces(options) for f in cad.select_faces(part, word)}
    return [
        blend
        for blend in blends
        if asked.isdisjoint(blend.faces) or all(not asked.isdisjoint(side) for side in blend.supports)
    ]


def on_design(part: Part, design: cad.Design, options: SweepOptions) -> tuple[Part, SweepOptions]:
    """The design with names for what the user means, and the options by these names.

    Raises
    ------
    NotSweepableError
        A count or a bias is asked for along an edge that the design has not.
    InputError
        Nothing is called so.
    """
    words = _Words(part, design)
    sizes = dict[str, float]()
    around = list[LocalSize]()
    for word, size in (options.sizes or {}).items():
        if word in {model.name for model in part.models}:
            sizes[word] = size
            continue
        own, left = words.sized(word)
        sizes |= dict.fromkeys([own] if own else [], size)
        around += [LocalSize(at=name, size=size) for name in left]
    found = replace(
        options,
        source=_each_of(options.source, words.faces),
        target=_each_of(options.target, words.faces),
        wall_layers=_named(options.wall_layers, words.faces),
        periodic=_named(options.periodic, words.faces, words.faces),
        counts=_named(options.counts, words.edges),
        biases=_named(options.biases, words.edges, words.towards),
        sizes=sizes or None,
    )
    field = size_field(part, replace(options, local_sizes=around), np.inf) if around else None
    return words.tagged(), for_all_solids(part, found) if field is None else no_larger_than(field, part, found)


def without_words(mesh: HexMesh, design: Part) -> HexMesh:
    """The mesh of a design, its cells without the names that were given to what the user means."""
    origin = mesh.origin
    tags = set(origin.part.names) - set(design.names)
    if not tags:
        return mesh
    known = dict[Solid, Solid]()

    def kept(groups: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(name for name in groups if name not in tags)

    def plain(part: Part) -> Part:
        for solid in part.solids:
            if solid not in known:
                known[solid] = replace(
                    solid,
                    faces=tuple(replace(own, groups=kept(own.groups)) for own in solid.faces),
                    edges=tuple(replace(own, groups=kept(own.groups)) for own in solid.edges),
                )
        return replace(part, solids=tuple(known[solid] for solid in part.solids), names=dict(design.names))

    return replace(mesh, origin=replace(origin, model=plain(origin.model), part=plain(origin.part)))


def _words_of_faces(options: SweepOptions) -> Iterator[str | int]:
    """The words for caps, walls and faces that answer each other."""
    for cap in (options.source, options.target):
        yield from [] if cap is None else [cap] if isinstance(cap, str | int) else cap
    yield from options.wall_layers or ()
    for pair in (options.periodic or {}).items():
        yield from pair


def _each_of(words: Any, name: Callable[[str | int], str]) -> Any:
    """A cap, or each of several."""
    if words is None:
        return None
    return name(words) if isinstance(words, str | int) else tuple(name(word) for word in words)


def _named(
    words: Mapping[Any, Any] | None, name: Callable[[Any], str], value: Callable[[Any], Any] = lambda own: own
) -> dict[str, Any] | None:
    return None if words is None else {name(word): value(own) for word, own in words.items()}


class _Words:
    """The words so far, and what of the design each means."""

    def __init__(self, part: Part, design: cad.Design) -> None:
        self.part, self.design = part, design
        (self.solid,), (self.own,) = part.solids, design.part.solids
        self.names = dict[str, str]()
        self.of: dict[str, dict[int, list[str]]] = {"face": defaultdict(list), "edge": defaultdict(list)}

    def tagged(self) -> Part:
        """The design with these names."""
        solid = replace(
            self.own,
            faces=tuple(replace(f, groups=(*f.groups, *self.of["face"].get(f.id, ()))) for f in self.own.faces),
            edges=tuple(replace(e, groups=(*e.groups, *self.of["edge"].get(e.id, ()))) for e in self.own.edges),
        )
        part = self.design.part
        return replace(part, solids=(solid,), names={**part.names, **{tag: word for word, tag in self.names.items()}})

    def faces(self, word: str | int) -> str:
        """What names the faces of the design that a word means."""
        return self.name("face", word, self.kept(cad.select_faces(self.part, word)))

    def edges(self, word: str | int) -> str:
        """What names the edges of the design that a word means."""
        found = set[int]()
        for edge in cad.select_edges(self.part, word):
            own = self.answering(edge)
            if own is None:
                raise NotSweepableError(f"'{word}': the design has no {self.solid.edges[edge].label()}")
            found.add(own)
        return self.name("edge", word, found)

    def sized(self, word: str | int) -> tuple[str, list[str]]:
        """What names the faces or edges that a word means; and, by their ids, what the design has not."""
        kind, edges = cad.select_edges_of(self.part, word)
        if kind == "face":
            faces = cad.select_faces(self.part, word)
            own, left = self.kept(faces), [f"face {f}" for f in faces if f in self.design.gone]
        else:
            known = {edge: self.answering(edge) for edge in edges}
            own = {edge for edge in known.values() if edge is not None}
            left = [f"edge {edge}" for edge, there in known.items() if there is None]
        return (self.name(kind, word, own) if own else ""), left

    def towards(self, value: Any) -> Any:
        """A bias towards a face, in the design's words."""
        bias = edge_bias("the bias", value)
        at = bias.towards
        if at in SYMMETRIC or not isinstance(at, str | int) or str(at).startswith("vertices:"):
            return bias
        return replace(bias, towards=self.faces(at))

    def kept(self, faces: tuple[int, ...]) -> set[int]:
        """The faces of the design that are made of some of the model's."""
        return {own for own, of in enumerate(self.design.model_faces) if not set(of).isdisjoint(faces)}

    def name(self, kind: str, word: str | int, items: set[int]) -> str:
        """The word for these faces or edges."""
        if not items:
            raise InputError(f"'{word}': the design has no {kind} that answers what it names")
        text = f"{kind}s:{word}"
        if text not in self.names:
            self.names[text] = _TAG.format(len(self.names) + 1)
            for item in items:
                self.of[kind][item].append(self.names[text])
        return f"{kind}s:{self.names[text]}"

    def answering(self, edge: int) -> int | None:
        """The edge of the design that an edge of the model is a piece of, or the border of the blend of."""
        beside = [self.kept((f,)) for f in self.solid.edges[edge].faces]
        there = [own for own in beside if own]
        near = [e for e in self.own.edges if there and all(not own.isdisjoint(e.faces) for own in there)]
        middle = self.solid.edges[edge].midpoint[None]
        return min(near, key=lambda e: float(e.curve.distance(middle)[0])).id if near else None


__all__ = ["left_to_design", "on_design", "speaks_of_entities", "without_words"]
