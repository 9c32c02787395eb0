"""Other ways to divide the cells of an arrangement around one quad, for :mod:`.mending`.

Four ways, of which the last two are those where no node around the quad is free ::

    turned                        closed
    +-----+-----+    +-----+-----+    a           a
    |     |     | -> |  .-----'  |   / \\         |
    +-----+-----+    +-'---+-----+  b   d -> ----b----
                                     \\ /         |
                                      c           c
    starred                       inset
    v-----b-----e    v-----b-----e    a-----------d     a-----------d
    |     |     |    | '-.   .-' |    |           |     | \\_______/ |
    |     |     | -> |    '-'    |    |           |  -> |  |_____|  |
    |     |     |    |     |     |    b-----------c     b/_________\\c
    a-----c-----f    a-----c-----f
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
        yield from _starred(around, q, side)
    for corner in range(4):
        yield from _closed(around, q, corner)
    yield _inset(around, q)


def _hexagon(around: Around, q: int, side: int) -> tuple[int, tuple[int, ...]] | None:
    """The quad of the same cell across a side, and the six nodes around both; the side joins the second and fifth."""
    b, c, a, v = np.roll(around.quads[q], -side).tolist()
    if (min(b, c), max(b, c)) in around.lines:
        return None
    shared = (around.at[b] & around.at[c]) - {q}
    other = next((r for r in sorted(shared) if around.cells[r] == around.cells[q]), None)
    if other is None:
        return None
    beyond = around.quads[other].tolist()
    k = beyond.index(c)
    if beyond[(k + 1) % 4] != b:
        return None
    nodes = (v, b, beyond[(k + 2) % 4], beyond[(k + 3) % 4], c, a)
    return (other, nodes) if len(set(nodes)) == 6 else None


def _turned(around: Around, q: int, side: int) -> Iterator[Rewrite]:
    """Both other ways to divide the hexagon of a quad and the one of the same cell across a side."""
    found = _hexagon(around, q, side)
    if found is None:
        return
    other, (v, b, e, f, c, a) = found
    if not all(_spares(around, n) for n in (b, c)):
        return
    # A new edge between nodes of another quad would lie across that.
    for (m, n), rows in (((v, f), [[v, b, e, f], [v, f, c, a]]), ((a, e), [[b, e, a, v], [e, f, c, a]])):
        if around.at[m] & around.at[n] <= {q, other}:
            yield Rewrite(removed=(q, other), rows=np.array(rows), shares=_NO_NODES)


def _starred(around: Around, q: int, side: int) -> Iterator[Rewrite]:
    """The same hexagon as three quads around a new node: at the tip of a wedge the only way without a flat corner."""
    found = _hexagon(around, q, side)
    if found is None:
        return
    other, (v, b, e, f, c, a) = found
    middle = 0.5 * (np.eye(4)[[side]] + np.eye(4)[[(side + 1) % 4]])
    upper = [[v, b, e, -1], [e, f, c, -1], [c, a, v, -1]]
    lower = [[b, e, f, -1], [f, c, a, -1], [a, v, b, -1]]
    for alone, rows in ((b, upper), (c, lower)):
        if _spares(around, alone):
            yield Rewrite(removed=(q, other), rows=np.array(rows), shares=middle)


def _spares(around: Around, node: int) -> bool:
    """Whether a node can do with a quad less."""
    return bool(around.fixed[node]) or len(around.at[node]) >= 4


def _closed(around: Around, q: int, corner: int) -> Iterator[Rewrite]:
    """A quad closed over its diagonal: the free node across goes to the corner, and its other quads with it."""
    b, c, d, a = np.roll(around.quads[q], -corner).tolist()
    if around.fixed[d] or not all(_spares(around, n) for n in (a, c)):
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
