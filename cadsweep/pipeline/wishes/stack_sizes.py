"""Sizes that change from place to place, in a stack: columns by the least one over them, layers by that beside them.

The plane's quads are carried through all heights, and a level goes through all columns: what is fine somewhere is fine
along the whole column and the whole layer through it, as far as there is material.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...arrays import FloatArray
from ...brep import Part
from ...errors import InputError
from ...options import SweepOptions
from ...stack import Stack
from ...stacks import Sheets
from ...surface import Division
from .local_sizes import Field, size_field
from .size_divisions import by_density, divide_by_sizes, divided_by
from .stack_hints import StackHints

_HEIGHTS = 65
"""Heights at which the size over a place of the plane is looked at."""
_STEPS = 200
"""Steps between two sheets at which it is looked at."""
_ALONG = 17
"""Places along an edge of the plane over which it is looked at."""


def by_place(  # noqa: PLR0917
    part: Part, stack: Stack, sheets: Sheets, options: SweepOptions, hints: StackHints, size: float
) -> StackHints:
    """The hints with what the sizes at places ask for, nowhere above `size`; as they were where there are none.

    Raises
    ------
    InputError
        A place that nothing is called, a function that gives no lengths, or layers are asked for besides.
    """
    field = size_field(part, options, size)
    if field is None:
        return hints
    if options.layers is not None:
        raise InputError("local_sizes divide the stack along its columns, too: without layers")
    field_ = field
    heights = np.linspace(float(sheets.heights.min()), float(sheets.heights.max()), _HEIGHTS)

    def least(points: FloatArray) -> FloatArray:
        """Least size over places of the plane."""
        flat = points - np.outer(points @ stack.direction, stack.direction)
        return np.min([field_(flat + height * stack.direction) for height in heights], axis=0)

    solid = stack.plan.solid
    sides = [(solid, side) for side in stack.plan.linking_sides]
    by_key, divided_by_key = divide_by_sizes([solid], [stack.plan], sides, least)
    keys = solid.edge_keys.tolist()
    on_plane = set(stack.arrangement.over)
    layers, gradings = _layers(stack, sheets, field)
    return replace(
        hints,
        inside=least,
        most_sizes={e: by_key[key] for e, key in enumerate(keys) if e in on_plane},
        divisions={e: divided_by_key[k] for e, k in enumerate(keys) if e in on_plane and k in divided_by_key}
        | hints.divisions,
        layer_sizes=layers | hints.layer_sizes,
        gradings=gradings | hints.gradings,
    )


def _layers(
    stack: Stack, sheets: Sheets, field: Field
) -> tuple[dict[tuple[int, int], float], dict[tuple[int, int], Division]]:
    """Mean height of the layers between two sheets, and how they divide it, from the lower one."""
    prism = stack.arrangement.prism
    at = np.linspace(0.0, 1.0, _ALONG)
    places: dict[tuple[int, int], list[FloatArray]] = {}
    for f, inside, columns in zip(stack.arrangement.bottoms, stack.arrangement.places, stack.columns, strict=True):
        rim = np.concatenate([prism.edges[e].curve.evaluate(at) for e in prism.faces[f].edges])
        own = np.concatenate([rim, inside[None]])
        own -= np.outer(own @ stack.direction, stack.direction)
        for low, high in columns:
            bottom, top = sheets.heights[[sheets.caps[low], sheets.caps[high]]]
            for a, b in sheets.spans:
                if sheets.heights[a] >= bottom and sheets.heights[b] <= top:
                    places.setdefault((a, b), []).append(own)
    sizes: dict[tuple[int, int], float] = {}
    gradings: dict[tuple[int, int], Division] = {}
    for pair, found in places.items():
        points = np.concatenate(found)
        bottom, top = sheets.heights[list(pair)].tolist()
        between = np.linspace(bottom, top, _STEPS + 1)
        least = np.array([field(points + height * stack.direction).min() for height in between])
        sizes[pair], division = divided_by(least)
        if division is not None:
            gradings[pair] = partial(by_density, places=division)
    return sizes, gradings
