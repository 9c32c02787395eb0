"""Where the columns of a stack touch: over which edges of the arrangement, and from which height to which.

Place in the flow: for who wants the columns as solids (:mod:`cadsweep.pipeline.columns.column_cells`).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arrays import FloatArray
from ..stack import Stack
from .along import heights_on_cap

_THIN = 1e-6
"""Height, in sizes of the part, below which columns do not touch."""
_AT = np.linspace(0.0, 1.0, 9)
"""Fractions of an edge at which heights are compared."""


def touching_columns(stack: Stack) -> Iterator[tuple[int, float, float]]:
    """Edges of the arrangement over which two columns touch, with the least and the greatest height of that."""
    prism = stack.arrangement.prism
    cell_of = {f: c for c, f in enumerate(stack.arrangement.bottoms)}
    rims = stack.rims
    for e in stack.arrangement.over:
        cells = [cell_of[f] for f in prism.edges[e].faces if f in cell_of]
        if len(cells) < 2:
            continue
        places = prism.edges[e].curve.evaluate(_AT)
        one, other = ([[_heights(stack, rims, f, e, places) for f in ends] for ends in stack.columns[c]] for c in cells)
        for begin, end in one:
            for start, stop in other:
                low, high = np.maximum(begin, start), np.minimum(end, stop)
                if (high - low).max() > _THIN * stack.solid.size:
                    yield e, float(low.min()), float(high.max())


def _heights(stack: Stack, rims: dict[int, list[tuple[int, int]]], cap: int, e: int, places: FloatArray) -> FloatArray:
    """Heights (m,) of a cap over places of an edge of the arrangement."""
    here = np.arange(len(places))
    own = [(stack.solid.edges[edge], here) for edge, over in rims.get(cap, ()) if over == e]
    return heights_on_cap(stack.solid.faces[cap], stack.direction, places, own)


__all__ = ["touching_columns"]
