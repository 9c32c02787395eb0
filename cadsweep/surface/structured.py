"""A lattice of quads on caps whose corners are all right or re-entrant.

Place in the flow: one of the ways of :mod:`.filling`.

Method: the outline alone tells which quads there are. Between right and re-entrant corners its nodes are places of a
lattice (submapping: Whiteley, White, Benzley and Blacker, "Two and three-quarter dimensional meshing facilitators",
1996)::

    o--o--o--o
    |  |  |  |
    o--o--o--o--o--o
    |  |  |  |  |  |
    o--o--o--o--o--o

Not handled: outlines on which quads should grow towards the inside.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import quarter_turns
from .chart import Chart
from .embedding import embedded
from .lattice import STEPS, numbered, quads_of
from .outline import Outline
from .pierced import pierce


def find_lattice(outline: Outline) -> tuple[Chart, int, IntArray] | None:
    """A lattice on a face whose corners are all right or re-entrant, its holes round or of four corners.

    Its chart, the number of inner nodes, and quads in ids of the outline's nodes, then of these.
    """
    if outline.grows():
        return None
    lattice = _lattice_of(outline)
    chart = None if lattice is None else next(outline.charts(outline.nodes), None)
    if lattice is None or chart is None:
        return None
    number, cells = _inside_of(lattice)
    if len(outline.loops) > 1:
        whole = _whole_of(chart.boundary[0], number, cells)
        pierced = pierce(outline, chart, number, cells, whole)
        if pierced is None:
            return None
        number, cells = pierced
    return chart, int(number.max()) + 1 - sum(map(len, outline.nodes)), quads_of(number, cells)


def _lattice_of(outline: Outline) -> IntArray | None:
    """Lattice places (n, 2) of the outer loop's nodes; None where they close to no simple polygon."""
    loop = outline.loops[0]
    turns = quarter_turns(outline.angles(loop))
    if turns is None or sum(turns) != 4:
        return None
    ways = np.repeat(np.cumsum(turns) % 4, [int(outline.counts[e]) for e, _ in loop])
    places = np.cumsum(STEPS[ways], axis=0)
    lattice: IntArray = places - places.min(axis=0)
    closed = not places[-1].any()  # the ways there and back have as many segments
    return np.roll(lattice, 1, axis=0) if closed and len(np.unique(lattice, axis=0)) == len(lattice) else None


def _inside_of(lattice: IntArray) -> tuple[IntArray, IntArray]:
    """Numbers of the nodes of a simple lattice polygon (n, 2), its own first, by place; and the cells (m, 2) inside."""
    width, height = lattice.max(axis=0)
    winding = np.zeros((width + 1, height), dtype=np.int64)
    step = np.roll(lattice, -1, axis=0) - lattice
    up, down = (step[:, 1] == 1), (step[:, 1] == -1)
    np.subtract.at(winding, (lattice[up, 0], lattice[up, 1]), 1)
    np.add.at(winding, (lattice[down, 0], lattice[down, 1] - 1), 1)
    cells = np.argwhere(np.cumsum(winding, axis=0)[:-1] > 0)
    number = np.full((width + 1, height + 1), -1, dtype=np.int64)
    number[lattice[:, 0], lattice[:, 1]] = np.arange(len(lattice))
    return numbered(number, cells, len(lattice)), cells


def _whole_of(rim: FloatArray, number: IntArray, cells: IntArray) -> FloatArray:
    """About where the nodes (n, 2) of a lattice without its holes are, the first ones at `rim`."""
    if 2 * (sum(number.shape) - 2) != len(rim):
        return embedded(rim, int(number.max()) + 1 - len(rim), quads_of(number, cells))
    # A rectangle: between its four sides, which is as good to look for holes as a solution for all its nodes.
    south, north, west, east = (rim[side] for side in (number[:, 0], number[:, -1], number[0], number[-1]))
    x, y = (np.linspace(0.0, 1.0, n)[:, None] for n in number.shape)
    at = (1 - y) * south[:, None] + y * north[:, None]
    at += (1 - x)[:, None] * (west - at[0]) + x[:, None] * (east - at[-1])
    places = np.empty((number.size, 2))
    places[number.ravel()] = at.reshape(-1, 2)
    return places
