"""How often edges of an arrangement run across others, as far as their samples tell.

Place in the flow: :mod:`.merging` makes no step that makes outlines cross.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray
from .graph import Graph

_ON_LINE = 1e-9
"""Sine of the angle off a line below which a point is on it."""


def n_crossings(graph: Graph, edges: set[int], cells: set[int]) -> int:
    """How often some edges run across any edges of cells, as far as their samples tell."""
    there = {h >> 1 for h, c in graph.cell.items() if c in cells} | edges
    courses = {e: graph.samples(e) for e in there}
    every = np.concatenate([np.stack([courses[e][:-1], courses[e][1:]], axis=1) for e in there])
    owner = np.repeat(list(there), [len(courses[e]) - 1 for e in there])
    found = 0
    for e in edges:
        own = np.stack([courses[e][:-1], courses[e][1:]], axis=1)
        others = every[owner != e]
        sides = _sides_of(own[:, None], others[None])
        opposite = _sides_of(others[None], own[:, None])
        found += int(((sides == -1) & (opposite == -1)).sum())
    return found


def _sides_of(lines: FloatArray, others: FloatArray) -> npt.NDArray[np.int8]:
    """-1 where other segments' ends lie on two sides of lines (both (..., 2, 2)), 1 on one, 0 where one is on it."""
    start, along = lines[..., 0, :], lines[..., 1, :] - lines[..., 0, :]
    off = others - start[..., None, :]
    area = along[..., None, 0] * off[..., 1] - along[..., None, 1] * off[..., 0]
    reach = np.linalg.norm(along, axis=-1)[..., None] * np.abs(off).max(axis=-1)
    side = np.where(np.abs(area) <= _ON_LINE * reach, 0, np.sign(area)).astype(np.int8)
    return np.asarray(side[..., 0] * side[..., 1])
