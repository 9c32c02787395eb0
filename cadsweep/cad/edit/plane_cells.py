"""Cells between lines of a plane, the faces of a part over each of them, and their prism.

Place in the flow: called for the projected outlines of a part's caps, and again for those that were laid together.

Method: :mod:`.plane_loops` makes the cells. Which faces lie over a cell follows from its neighbour by the edge
between them: who crosses it enters some faces and leaves others. The cells are extruded to a prism, so that whatever
meshes the source cap of a sweep can mesh them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...brep import Face, Solid
from ...errors import CadError
from ...stack import Arrangement
from ..extract.prism import extrude_cells
from ..extract.prism_plane import Overhead
from ..extract.shared import read_edge_curves
from ..geometry.convert import read_surface
from ..geometry.curves import EdgeCurve
from .plane_loops import Cell, find_cells


class Line(NamedTuple):
    """An edge of the plane, and the edges of the part that lie over it, whether run the same way."""

    shape: Any
    over: list[tuple[int, bool]]


def cells_between(  # noqa: PLR0917
    solid: Solid, direction: FloatArray, sides: Mapping[int, int], pieces: Sequence[Line], plane: Any, along: FloatArray
) -> Arrangement:
    """Make the cells between lines that meet in their ends alone, and the prism over them.

    Raises
    ------
    CadError
        OpenCASCADE fails, or what it makes is no division of the plane by these lines.
    """
    edges = [piece.shape for piece in pieces]
    read = read_edge_curves(edges)
    cells = find_cells(edges, [curve for curve, _ in read], plane, lambda j: _named(solid, pieces[j]))
    beside = _beside(cells, len(edges))
    caps = _caps_over(solid, direction, sides, pieces, beside, len(cells))
    kept = [j for j, own in enumerate(caps) if own]
    overhead = _overhead(solid, direction, sides, pieces, caps)
    return _prism(cells, kept, pieces, read, beside, caps, plane, along, overhead)


def _overhead(
    solid: Solid,
    direction: FloatArray,
    sides: Mapping[int, int],
    pieces: Sequence[Line],
    caps: Sequence[frozenset[int]],
) -> Overhead:
    """What of the part messages name for the lines and the cells."""
    heights = (np.array([face.center for face in solid.faces]) @ direction).tolist()
    middles = (np.array([edge.midpoint for edge in solid.edges]) @ direction).tolist()

    def rising(some: Iterable[int]) -> tuple[Face, ...]:
        return tuple(solid.faces[f] for f in sorted(some, key=lambda f: (heights[f], f)))

    over = [sorted({e for e, _ in piece.over}, key=lambda e: (middles[e], e)) for piece in pieces]
    return Overhead(
        edges=[tuple(solid.edges[e] for e in some) for some in over],
        walls=[rising({f for e in some for f in solid.edges[e].faces if f not in sides}) for some in over],
        caps=[rising(own) for own in caps],
        units=solid.units,
    )


def _named(solid: Solid, piece: Line) -> str:
    """What messages call a line of the plane: the first edge of the part over it."""
    return solid.edges[piece.over[0][0]].label()


def _beside(cells: Sequence[Cell], n_edges: int) -> list[list[int]]:
    """For every edge the cells on its left and on its right, -1 outside."""
    beside = [[-1, -1] for _ in range(n_edges)]
    for c, cell in enumerate(cells):
        for wire in cell.wires:
            for j, left in wire:
                beside[j][not left] = c
    return beside


def _caps_over(  # noqa: PLR0917
    solid: Solid,
    direction: FloatArray,
    sides: Mapping[int, int],
    pieces: Sequence[Line],
    beside: Sequence[Sequence[int]],
    n_cells: int,
) -> list[frozenset[int]]:
    """The faces over every cell: who crosses an edge to its left enters the faces on its left and leaves the others."""
    left_of: dict[tuple[int, bool], set[int]] = {}
    for f, side in sides.items():
        for loop in solid.faces[f].loops:
            for e, forward in loop.directed:
                # The face lies on the left of its own loop seen from outside, from below where its normal points down.
                left_of.setdefault((e, forward == (side > 0)), set()).add(f)
    changes: list[tuple[set[int], set[int]]] = []
    for piece in pieces:
        entered, left = set(), set()
        for e, same in piece.over:
            entered |= left_of.get((e, same), set())
            left |= left_of.get((e, not same), set())
        changes.append((entered, left))
    around: list[list[tuple[int, int, bool]]] = [[] for _ in range(n_cells + 1)]
    for j, (a, b) in enumerate(beside):
        around[b].append((j, a, True))
        around[a].append((j, b, False))
    over: list[set[int] | None] = [None] * n_cells + [set()]
    waiting = [n_cells]
    while waiting:
        cell = waiting.pop()
        own = over[cell]
        assert own is not None
        for j, other, to_left in around[cell]:
            entered, left = changes[j] if to_left else changes[j][::-1]
            there = (own - (left - entered)) | (entered - left)
            known = over[other]
            if known is None:
                over[other] = there
                waiting.append(other)
            elif known != there or not left - entered <= own or (entered - left) & own:
                raise CadError(
                    f"beside {_named(solid, pieces[j])} the outlines of the caps, as seen along the columns, nearly "
                    "lie on each other: lay them on each other there or move them apart"
                )
    lost = [j for j, pair in enumerate(beside) if any(c >= 0 and over[c] is None for c in pair)]
    if lost:
        raise CadError(
            f"{_named(solid, pieces[lost[0]])} bounds nothing, as seen along the columns: is it in two places?"
        )
    return [frozenset(caps or ()) for caps in over[:-1]]


def _prism(  # noqa: PLR0917
    cells: Sequence[Cell],
    kept: Sequence[int],
    pieces: Sequence[Line],
    read: Sequence[tuple[EdgeCurve, str]],
    beside: Sequence[Sequence[int]],
    caps: Sequence[frozenset[int]],
    plane: Any,
    along: FloatArray,
    overhead: Overhead,
) -> Arrangement:
    """Extrude the cells that have material over them."""
    number = {j: k for k, j in enumerate(kept)}
    sides = [(number.get(left, -1), number.get(right, -1)) for left, right in beside]
    lines = [j for j, own in enumerate(sides) if own != (-1, -1)]  # others bound no material
    line_of = {j: k for k, j in enumerate(lines)}
    prism = extrude_cells(
        [[[(line_of[j], left) for j, left in wire] for wire in cells[c].wires] for c in kept],
        [pieces[j].shape for j in lines],
        [read[j] for j in lines],
        [sides[j] for j in lines],
        read_surface(plane),
        along,
        Overhead(
            edges=[overhead.edges[j] for j in lines],
            walls=[overhead.walls[j] for j in lines],
            caps=[overhead.caps[c] for c in kept],
            units=overhead.units,
        ),
    )
    return Arrangement(
        prism=prism.solid,
        bottoms=prism.bottoms,
        tops=prism.tops,
        top_edges=dict(zip(prism.lower, prism.upper, strict=True)),
        caps=tuple(caps[j] for j in kept),
        places=np.array([cells[c].place for c in kept]),
        over={e: tuple(one for one, _ in pieces[j].over) for e, j in zip(prism.lower, lines, strict=True)},
        ways={e: tuple(same for _, same in pieces[j].over) for e, j in zip(prism.lower, lines, strict=True)},
    )


__all__ = ["Line", "cells_between"]
