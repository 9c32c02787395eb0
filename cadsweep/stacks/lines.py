"""Nodes along the edges of the part, from their starts to their ends.

Place in the flow: beside :mod:`.blocks`, which numbers the nodes; order 2 bends its segments by them.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Edge
from ..mesh import QuadMesh
from ..stack import Levels, Stack

Row = Callable[[int, bool], IntArray]
"""Numbers of the nodes on a level: of those that begin the layer above it, or end the one below."""


def nodes_on_edges(stack: Stack, levels: Levels, mesh: QuadMesh, row: Row, points: FloatArray) -> dict[int, IntArray]:
    """Node numbers along every edge of the part.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    mesh : QuadMesh
    row : callable
    points : (n, 3) float64
        Places of the numbered nodes.

    Returns
    -------
    dict of int to (m,) int64
        By edge id; edges along the direction, too.
    """
    solid, over = stack.solid, stack.arrangement.over
    pieces: dict[int, list[int]] = {}
    for own, edges in over.items():
        for e in edges:
            pieces.setdefault(e, []).append(own)
    found: dict[int, IntArray] = {}
    corners: dict[int, tuple[int, int, bool]] = {}  # vertex: node of the arrangement, level, side
    sources = set(stack.source)
    for e, parts in pieces.items():
        edge = solid.edges[e]
        caps = [f for f in edge.faces if f in levels.caps]
        level = levels.caps[caps[0]] if caps else levels.stations[e]
        above = bool(caps) and caps[0] in sources
        numbers = row(level, above)
        chain = _chained([mesh.edge_nodes[piece] for piece in parts], numbers, points, solid.vertices[edge.start])
        found[e] = numbers[chain]
        corners[edge.start], corners[edge.end] = (int(chain[0]), level, above), (int(chain[-1]), level, above)
    for run in _along([edge for edge in solid.edges if edge.id not in found], corners):
        (node, one, _), (there, other, _) = corners[run[0][1]], corners[run[-1][2]]
        low, high = sorted((one, other))
        rise = [row(low, True)[node], *(row(k, False)[node] for k in range(low + 1, high + 1))]
        nodes = np.array(rise if one < other else rise[::-1], dtype=np.int64)
        if there != node or len(nodes) <= len(run):
            continue  # not along a column, or fewer layers than pieces
        between = solid.vertices[[end for _, _, end in run[:-1]]]
        away = np.linalg.norm(points[nodes][None] - between[:, None], axis=2)
        ends = [0, *(int(to.argmin()) for to in away), len(nodes) - 1]
        for k in range(1, len(run)):  # a segment at least for every piece
            ends[k] = min(max(ends[k], ends[k - 1] + 1), len(nodes) - 1 - (len(run) - k))
        for (edge, start, _), first, last in zip(run, ends[:-1], ends[1:], strict=True):
            part = nodes[first : last + 1]
            found[edge.id] = part if edge.start == start else part[::-1]
    return found


def _along(edges: Sequence[Edge], corners: Container[int]) -> Iterator[list[tuple[Edge, int, int]]]:
    """Edges between corners, each with the vertices that it leads from and to.

    One that is divided where nothing else ends comes with those in which it goes on.
    """
    at: dict[int, list[Edge]] = {}
    for edge in edges:
        for vertex in (edge.start, edge.end):
            at.setdefault(vertex, []).append(edge)
    left = {edge.id for edge in edges}
    for edge in edges:
        start = edge.start if edge.start in corners else edge.end
        if edge.id not in left or start not in corners:
            continue
        chain, onward = list[tuple[Edge, int, int]](), edge
        while True:
            left.discard(onward.id)
            end = onward.end if onward.start == start else onward.start
            chain.append((onward, start, end))
            following = [other for other in at[end] if other.id in left]
            if end in corners or len(following) != 1:
                break
            start, (onward,) = end, following
        if end in corners:
            yield chain


def _chained(pieces: list[IntArray], numbers: IntArray, points: FloatArray, start: FloatArray) -> IntArray:
    """Join rows of nodes to one, beginning at the end nearest to a point."""
    ends: dict[int, list[int]] = {}
    for j, piece in enumerate(pieces):
        for node in (int(piece[0]), int(piece[-1])):
            ends.setdefault(node, []).append(j)
    open_ends = [node for node, own in ends.items() if len(own) == 1] or list(ends)
    node = min(open_ends, key=lambda i: float(np.linalg.norm(points[numbers[i]] - start)))
    chain, left = [np.array([node], dtype=np.int64)], set(range(len(pieces)))
    while left:
        j = next(k for k in ends[node] if k in left)
        left.remove(j)
        piece = pieces[j] if int(pieces[j][0]) == node else pieces[j][::-1]
        chain.append(piece[1:])
        node = int(piece[-1])
    return np.concatenate(chain)
