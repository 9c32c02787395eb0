"""Other ways to divide the cells of an arrangement around one quad, for :mod:`.mending`.

Three ways, of which the last is the only one where no node around the quad is free ::

    turned                        closed                           inset
    +-----+-----+    +-----+-----+    a           a                a-----------d     a-----------d
    |     |     | -> |  .-----'  |   / \\         |                |           |     | \\_______/ |
    +-----+-----+    +-'---+-----+  b   d -> ----b----             |           |  -> |  |_____|  |
                                     \\ /         |                b-----------c     b/_________\\c
                                      c           c
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray

_INSET = 0.45
"""How far the inner quad's corners are from their own, in parts of the way to the middle."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Around:
    """Quads, and what is known of their nodes.

    Attributes
    ----------
    quads : (q, 4) int64
    cells : (q,) int64
        Two quads of one cell may be divided otherwise.
    fixed : (n,) bool
        Nodes on lines.
    lines : set of (int, int)
        Sides that lie on lines, the lower node first.
    at : dict of int to set of int
        Quads at every node.
    """

    quads: IntArray
    cells: IntArray
    fixed: BoolArray
    lines: set[tuple[int, int]]
    at: dict[int, set[int]]

    def neighbours(self, node: int) -> set[int]:
        """Nodes at the other ends of the sides at a node."""
        found: set[int] = set()
        for q in self.at[node]:
            row = self.quads[q].tolist()
            j = row.index(node)
            found |= {row[j - 1], row[(j + 1) % 4]}
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Rewrite:
    """Quads that take the place of others.

    Attributes
    ----------
    removed : tuple of int
        The quads that go.
    rows : (k, 4) int64
        Those that come; -1 - j is new node j.
    shares : (m, 4) float64
        Of the corners of the first quad that goes in the place of every new node.
    """

    removed: tuple[int, ...]
    rows: IntArray
    shares: FloatArray


_NO_NODES = np.empty((0, 4))


def rewrites(around: Around, q: int) -> Iterator[Rewrite]:
    """All other ways to divide the cell around a quad that leave no inner node with two quads."""
    for side in range(4):
        yield from _turned(around, q, side)
    for corner in range(4):
        yield from _closed(around, q, corner)
    yield _inset(around, q)


def _turned(around: Around, q: int, side: int) -> Iterator[Rewrite]:
    """Both other ways to divide the hexagon of a quad and the one of the same cell across a side."""
    b, c, a, v = np.roll(around.quads[q], -side).tolist()  # the side runs from b to c
    if (min(b, c), max(b, c)) in around.lines:
        return
    shared = (around.at[b] & around.at[c]) - {q}
    other = next((r for r in sorted(shared) if around.cells[r] == around.cells[q]), None)
    if other is None:
        return
    beyond = around.quads[other].tolist()
    k = beyond.index(c)
    if beyond[(k + 1) % 4] != b:
        return
    e, f = beyond[(k + 2) % 4], beyond[(k + 3) % 4]
    if len({a, b, c, v, e, f}) < 6 or any(not around.fixed[n] and len(around.at[n]) < 4 for n in (b, c)):
        return
    # Around the hexagon: v, b, e, f, c, a. A new edge between nodes of another quad would lie across that.
    for (m, n), rows in (((v, f), [[v, b, e, f], [v, f, c, a]]), ((a, e), [[b, e, a, v], [e, f, c, a]])):
        if around.at[m] & around.at[n] <= {q, other}:
            yield Rewrite(removed=(q, other), rows=np.array(rows), shares=_NO_NODES)


def _closed(around: Around, q: int, corner: int) -> Iterator[Rewrite]:
    """A quad closed over its diagonal: the free node across goes to the corner, and its other quads with it."""
    b, c, d, a = np.roll(around.quads[q], -corner).tolist()
    if around.fixed[d] or any(not around.fixed[n] and len(around.at[n]) < 4 for n in (a, c)):
        return
    if around.neighbours(b) & around.neighbours(d) != {a, c}:
        return
    others = sorted(around.at[d] - {q})
    rows = around.quads[others]
    if (rows == b).any():
        return
    yield Rewrite(removed=(q, *others), rows=np.where(rows == d, b, rows), shares=_NO_NODES)


def _inset(around: Around, q: int) -> Rewrite:
    """A quad with a smaller one inside of it, and four around that."""
    corners = around.quads[q].tolist()
    new = [-1, -2, -3, -4]
    rows = [[corners[j - 1], corners[j], new[j], new[j - 1]] for j in range(4)]
    return Rewrite(
        removed=(q,), rows=np.array([*rows, new]), shares=(1.0 - _INSET) * np.eye(4) + _INSET * np.full((4, 4), 0.25)
    )


__all__ = ["Around", "Rewrite", "rewrites"]
