"""The cells of a mesh as arrays for a file: of those that are swept their factors, which do not grow with the layers.

Place in the flow: ``pipeline`` puts them beside what a mesh like it must know, and multiplies them out again, bit for
bit. :mod:`.files` is the same for a mesh of one sweep.

A sweep's caps and rings are left out where they are the nodes of the skeleton, which all cells share: in a stack of
columns nearly all of them. Arrays of one kind stand one after another, cell by cell: a stack of thousands of columns
would be tens of thousands of entries in the file.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray, small_ints
from ..projection import FactoredSweep
from .cells import CellBlocks, FilledCell, SweptCell

_WORDS = ("format", "functional", "strategy")
"""What of a sweep is text."""
_SHARED = {"source_points": "bottom", "target_points": "top", "rings": "rings"}
"""What of a sweep may be the skeleton's nodes, and the numbers that say which."""


def cells_as_arrays(cells: CellBlocks) -> dict[str, Any]:
    """Arrays from which :func:`cells_from_arrays` makes cells with the same nodes and hexahedra."""
    kinds: dict[str, list[np.ndarray | None]] = {}
    words: list[dict[str, str] | None] = []
    for number, own in enumerate(cells.cells):
        if isinstance(own, FilledCell):
            arrays, text = {"hexes": small_ints(own.hexes)}, None
        else:
            arrays, text = _swept_arrays(own, cells.points)
        words.append(text)
        for name, array in arrays.items():
            kinds.setdefault(name, [None] * len(cells.cells))[number] = array
    shapes = {name: [None if a is None else a.shape for a in every] for name, every in kinds.items()}
    table = [
        [own.cell, own.after, first] if isinstance(own, SweptCell) else [own.cell, 0, 0]
        for own, first in zip(cells.cells, cells.firsts, strict=True)
    ]
    flat = {name: np.concatenate([a.reshape(-1) for a in every if a is not None]) for name, every in kinds.items()}
    return {
        "cells": np.array(json.dumps({"shapes": shapes, "words": words})),
        "table": np.array(table, dtype=np.int64),
        "skeleton": cells.points,
        "steps": small_ints(np.diff(cells.numbers, prepend=0)),  # ones, for the most part
        "moved_nodes": cells.moved_nodes,
        "moved_points": cells.moved_points,
        **{f"each_{name}": array for name, array in flat.items()},
    }


def cells_from_arrays(arrays: Mapping[str, Any]) -> CellBlocks:
    """The cells again, without names of their faces and edges."""
    text = json.loads(str(arrays["cells"]))
    table, points = arrays["table"], arrays["skeleton"]
    every = {name: _parted(arrays[f"each_{name}"], shapes) for name, shapes in text["shapes"].items()}
    cells: list[SweptCell | FilledCell] = []
    for number, (cell, after, _) in enumerate(table.tolist()):
        own = {name: array for name, arrays in every.items() if (array := arrays[number]) is not None}
        words = text["words"][number]
        if words is None:
            cells.append(FilledCell(cell=cell, hexes=own["hexes"].astype(np.int64)))
        else:
            cells.append(_swept_cell(cell, after, own | {name: np.array(word) for name, word in words.items()}, points))
    nothing = np.empty(0, dtype=np.int64)
    return CellBlocks(
        points=points,
        cells=tuple(cells),
        firsts=tuple(table[:, 2].tolist()),
        numbers=np.cumsum(arrays["steps"]),
        quads=np.empty((0, 4), dtype=np.int64),
        quad_cells=nothing,
        quad_faces=nothing,
        moved_nodes=arrays["moved_nodes"],
        moved_points=arrays["moved_points"],
    )


def _swept_arrays(own: SweptCell, points: FloatArray) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    arrays = own.sweep.to_arrays()
    text = {name: str(arrays.pop(name)) for name in _WORDS}
    nodes = {"bottom": own.bottom, "top": own.top, "rings": own.rings}
    for name, where in _SHARED.items():
        if name in arrays and np.array_equal(arrays[name], points[nodes[where]]):
            del arrays[name]
    if own.sweep.target_points is None:
        text["no_target"] = "yes"
    return arrays | {f"{name}_nodes": small_ints(ids) for name, ids in nodes.items()}, text


def _swept_cell(cell: int, after: int, own: dict[str, np.ndarray], points: FloatArray) -> SweptCell:
    nodes: dict[str, IntArray] = {name: own[f"{name}_nodes"].astype(np.int64) for name in _SHARED.values()}
    for name, where in _SHARED.items():
        if name not in own and not (name == "target_points" and "no_target" in own):
            own[name] = points[nodes[where]]
    return SweptCell(cell=cell, sweep=FactoredSweep.of_arrays(own), after=after, **nodes)


def _parted(flat: np.ndarray, shapes: Sequence[Sequence[int] | None]) -> list[np.ndarray | None]:
    """Arrays that stand one after another in `flat`, by their shapes; None where there is none."""
    parts: list[np.ndarray | None] = []
    at = 0
    for shape in shapes:
        size = 0 if shape is None else int(np.prod(shape))
        parts.append(None if shape is None else flat[at : at + size].reshape(shape))
        at += size
    if at != len(flat):
        raise ValueError("arrays of cells are shorter or longer than their table says")
    return parts
