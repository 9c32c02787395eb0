"""Lines on the skin of a mesh, where quads of two patches meet.

Place in the flow: :mod:`.carrying` lays the lines on the model's edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Line:
    """Nodes (k,) head to tail between quads of two patches, the lower one first."""

    nodes: IntArray
    pair: tuple[int, int]


def find_lines(
    segments: IntArray, pairs: IntArray, points: FloatArray, corners: Sequence[FloatArray], close: float
) -> list[Line]:
    """Put segments (s, 2) between patches (s, 2) together to lines.

    Lines end where another number of segments than two meets, where the patches change, and at nodes that are `close`
    to a corner; a closed one is taken as two.
    """
    n_at = np.bincount(segments.ravel(), minlength=len(points))
    beside: dict[int, list[int]] = {}
    for s, (a, b) in enumerate(segments.tolist()):
        beside.setdefault(a, []).append(s)
        beside.setdefault(b, []).append(s)
    ends = {node for node, own in beside.items() if n_at[node] != 2 or (pairs[own[0]] != pairs[own[-1]]).any()}
    nodes = np.array(sorted(beside), dtype=np.int64)
    if len(corners) and len(nodes):
        away, nearest = cKDTree(points[nodes]).query(np.array(corners))
        ends |= set(nodes[nearest[away <= close]].tolist())
    used = np.zeros(len(segments), dtype=bool)
    lines = []

    def walk(start: int, s: int) -> list[int]:
        path = [start]
        while True:
            used[s] = True
            a, b = segments[s].tolist()
            path.append(b if path[-1] == a else a)
            if path[-1] in ends or path[-1] == start:
                return path
            s = next(other for other in beside[path[-1]] if other != s)

    for start in sorted(beside, key=lambda node: (node not in ends, node)):
        for s in beside[start]:
            if used[s]:
                continue
            path = walk(start, s)
            low, high = pairs[s].tolist()
            halves = [path[: len(path) // 2 + 1], path[len(path) // 2 :]] if path[0] == path[-1] else [path]
            lines += [Line(nodes=np.array(own, dtype=np.int64), pair=(low, high)) for own in halves]
    return lines


__all__ = ["Line", "find_lines"]
