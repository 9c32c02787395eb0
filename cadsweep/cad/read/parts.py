"""One solid of a model that holds several: chosen by name or number, or asked for with a list.

Place in the flow: after reading, before healing. Names, materials and colours of the other solids go with them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from ...errors import InputError
from ..names.unique import number_repeated, plain
from ..shapes import EDGE, FACE, SOLID, bounds, explore, index_map, subshapes
from .model import Colored, Model, Named

_MOST_LISTED = 20


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
        problem = f"{part!r} names {len(numbers)} solids" if numbers else f"there is no solid {part!r}"
        listed = _listed(numbers or range(len(solids)), solids, model.names) or "no solids"
        hint = "choose one by its number" if numbers else "choose one of them by name or number"
        raise InputError(f"{model.source}: {problem}: there are {listed}; {hint}.")
    return _only(model, solids[numbers[0]])


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
    """The model of one solid. A name on a face that is in no solid any more (a tag) may still find its place."""
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
