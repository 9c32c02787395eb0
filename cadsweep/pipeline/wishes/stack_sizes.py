"""Sizes that change from place to place, in a stack: columns by the least one over them, layers by that beside them.

The plane's quads are carried through all heights, and a level goes through all columns: what is fine somewhere is fine
along the whole column and the whole layer through it, as far as there is material.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ...arrays import FloatArray
from ...stack import Stack
from ...stacks import Sheets
from ...surface import Division
from .local_sizes import Field
from .size_divisions import by_density, divided_by

_HEIGHTS = 65
"""Heights at which the size over a place of the plane is looked at."""
_STEPS = 200
"""Steps between two sheets at which it is looked at."""
_ALONG = 17
"""Places along an edge of the plane over which it is looked at."""


def least_over(stack: Stack, sheets: Sheets, field: Field) -> Field:
    """Least size over places of the plane."""
    heights = np.linspace(float(sheets.heights.min()), float(sheets.heights.max()), _HEIGHTS)

    def least(points: FloatArray) -> FloatArray:
        flat = points - np.outer(points @ stack.direction, stack.direction)
        return np.asarray(np.min([field(flat + height * stack.direction) for height in heights], axis=0))

    return least


def layers_by_place(
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
