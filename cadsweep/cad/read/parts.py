"""Some solids of a model that holds several: one chosen by name or number, or those that are wanted or not, by name.

Place in the flow: after reading, before healing, so that a broken solid can be left out. Names, materials and colours
of the solids that are left out go with them; the others are called as they are in the whole model.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from ...errors import InputError, did_you_mean
from ..names.unique import number_repeated, plain
from ..shapes import EDGE, FACE, SOLID, bounds, compound, explore, index_map, subshapes
from .model import Colored, Model, Named

_MOST_LISTED = 20
"""Solids in a message: what fits a screen."""


def choose_part(model: Model, part: str | int | None) -> Model:
    """Return the model with one of its solids alone.

    Parameters
    ----------
    model : Model
    part : str, int or None
        A solid's name, as the user gave it or as it is written, or its number from 0 in the order of the model. None
        takes the model as it is.

    Raises
    ------
    InputError
        No solid, or several, go by that name.
    """
    solids = subshapes(model.shape, SOLID)
    if part is None:
        return model
    numbers = _matching(part, solids, model.names)
    if len(numbers) != 1:
        meant = did_you_mean(str(part), [name or "" for name in solid_names(solids, model.names)])
        problem = f"{part!r} names {len(numbers)} solids" if numbers else f"there is no solid {part!r}{meant}"
        listed = _listed(numbers or range(len(solids)), solids, model.names) or "no solids"
        hint = "choose one by its number" if numbers else "choose one of them by name or number"
        raise InputError(f"{model.source}: {problem}: there are {listed}; {hint}.")
    return _only(model, solids[numbers[0]])


def choose_solids(model: Model, *, only: Sequence[str] | None = None, skip: Sequence[str] | None = None) -> Model:
    """Return the model with some of its solids alone.

    Parameters
    ----------
    model : Model
    only, skip : sequence of str, optional
        Names of solids, unique as in the part that is made of the model, or as the user gave them.

    Raises
    ------
    InputError
        A name that no solid has, or nothing is left.
    """
    if only is None and skip is None:
        return model
    solids = subshapes(model.shape, SOLID)
    own = solid_names(solids, model.names)
    unique, _ = number_repeated(own, what="solid")

    def called(option: str, words: Sequence[str]) -> set[int]:
        found: set[int] = set()
        for word in words:
            numbers = [j for j in range(len(solids)) if word in (unique[j], own[j])]
            if not numbers:
                listed = ", ".join(unique[:_MOST_LISTED]) + (", ..." if len(unique) > _MOST_LISTED else "")
                raise InputError(
                    f"{option}: no solid is called '{word}'{did_you_mean(word, unique)}; the solids are {listed}"
                )
            found.update(numbers)
        return found

    wanted = set(range(len(solids))) if only is None else called("only", only)
    wanted -= called("skip", skip or ())
    if not wanted:
        raise InputError("only and skip leave no solid to be meshed: name fewer to be skipped")
    kept = sorted(wanted)
    # Alone, bolt_2 and bolt_3 of three would be called bolt_1 and bolt_2.
    again, _ = number_repeated([own[j] for j in kept], what="solid")
    renamed = [Named(solids[j], unique[j]) for j, name in zip(kept, again, strict=True) if name != unique[j]]
    chosen = _only(model, compound([solids[j] for j in kept]))
    return replace(chosen, names=[*renamed, *chosen.names])


def n_solids(model: Model) -> int:
    """How many solids a model holds, one that is there twice counted twice."""
    return sum(1 for _ in explore(model.shape, SOLID))


def solid_names(solids: Sequence[Any], names: Iterable[Named]) -> list[str | None]:
    """The first name of every solid."""
    named = [entry for entry in names if entry.shape.ShapeType() == SOLID]
    return [next((entry.name for entry in named if entry.shape.IsSame(solid)), None) for solid in solids]


def _matching(part: str | int, solids: Sequence[Any], names: Iterable[Named]) -> list[int]:
    text = str(part).strip()
    own = solid_names(solids, names)
    if not isinstance(part, int):
        unique = number_repeated(own, what="solid")[0]
        for words in (own, [None if name is None else plain(name) for name in own], unique):
            numbers = [j for j, name in enumerate(words) if name == text]
            if numbers:
                return numbers
    return [int(text)] if text.isdecimal() and int(text) < len(solids) else []


def _listed(numbers: Sequence[int], solids: Sequence[Any], names: Iterable[Named]) -> str:
    own = solid_names(solids, names)
    words = []
    for j in numbers[:_MOST_LISTED]:
        x, y, z = (float(f"{c:.4g}") + 0.0 for c in bounds(solids[j]).mean(axis=0))
        name = "" if own[j] is None else f" {own[j]!r}"
        words.append(f"{j}{name} at ({x:g}, {y:g}, {z:g})")
    more = f", and {len(numbers) - _MOST_LISTED} more" if len(numbers) > _MOST_LISTED else ""
    return ", ".join(words) + more


def _only(model: Model, solid: Any) -> Model:
    """The model of one solid, or of a compound of several.

    A name on a face that is in no solid any more (a tag) may still find its place.
    """
    kept = {kind: index_map(solid, kind) for kind in (SOLID, FACE, EDGE)}
    every = {kind: index_map(model.shape, kind) for kind in (SOLID, FACE, EDGE)}

    def belongs(entry: Named | Colored) -> bool:
        kind = entry.shape.ShapeType()
        return kind in kept and (kept[kind].Contains(entry.shape) or not every[kind].Contains(entry.shape))

    return replace(
        model,
        shape=solid,
        names=[entry for entry in model.names if belongs(entry)],
        materials=[entry for entry in model.materials if belongs(entry)],
        colors=[entry for entry in model.colors if belongs(entry)],
    )
