"""Mending quads that lie with one corner flat on the boundary, or share two edges.

Place in the flow: ``gmsh_quads`` hands every mesh through here before it is relaxed.

Method: where a boundary node that is no corner has one quad alone, that quad's angle there is flat,
and no relaxing helps. An edge of the quad is turned (of the two quads that share it, the hexagon is
divided anew) so that the node gets an edge of its own; an inner node left with two quads is taken
out. Which edge is turned is decided by how many quads each node should have: one for each right
angle of the boundary, four inside. Where turns do not get rid of it (a fillet whose mesh has its
corner on the arc), a smaller quad is set into the flat one, with a quad on each side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..topology import FloatArray, IntArray

_FLAT = np.radians(150)


def wanted_valences(loops: Sequence[FloatArray]) -> tuple[IntArray, FloatArray]:
    """How many quads each boundary node should have, and the angle there, inside on the left."""
    angles = []
    for loop in loops:
        after = np.roll(loop, -1, axis=0) - loop
        before = np.roll(loop, 1, axis=0) - loop
        turn = np.arctan2(before[:, 1], before[:, 0]) - np.arctan2(after[:, 1], after[:, 0])
        angles.append(np.mod(turn, 2 * np.pi))
    angle: FloatArray = np.concatenate(angles)
    return np.maximum(1, np.round(angle / (np.pi / 2))).astype(np.int64), angle


def mend_flat_corners(loops: Sequence[FloatArray], inner: FloatArray, quads: IntArray) -> tuple[FloatArray, IntArray]:
    """Mend quads with a flat corner on the boundary.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise; their nodes come first in `quads`.
    inner : (n, 2) float64
    quads : (q, 4) int64
        Counter-clockwise.

    Returns
    -------
    inner, quads
        Some inner nodes may be gone, others new.
    """
    wanted, angle = wanted_valences(loops)
    n_boundary = len(wanted)
    uses = np.bincount(quads.ravel(), minlength=n_boundary + len(inner))
    flat = np.flatnonzero(angle / np.maximum(uses[:n_boundary], 1) > _FLAT)
    doublets = n_boundary + np.flatnonzero(uses[n_boundary:] == 2)
    if not len(flat) and not len(doublets):
        return inner, quads
    mender = _Mender(quads, wanted, np.concatenate([*loops, inner]))
    for node in doublets:
        mender.take_out(int(node))
    for node in flat.tolist():
        mender.mend(node, float(angle[node]))
    for node in range(n_boundary):  # a turn may have made a neighbour flat
        mender.open(node, float(angle[node]))
    kept: IntArray = np.array([q for q in mender.quads if q is not None], dtype=np.int64)
    used = np.unique(kept[kept >= n_boundary])
    number = np.arange(len(mender.points))
    number[used] = n_boundary + np.arange(len(used))
    return np.array(mender.points)[used], number[kept]


class _Mender:
    """Quads as lists that may change, and the quads of every node."""

    def __init__(self, quads: IntArray, wanted: IntArray, points: FloatArray) -> None:
        self.points = list(points)
        self.quads: list[list[int] | None] = quads.tolist()
        self.wanted = wanted
        self.of_node: dict[int, set[int]] = {}
        for q, quad in enumerate(quads.tolist()):
            for node in quad:
                self.of_node.setdefault(node, set()).add(q)

    def _excess(self, node: int, change: int) -> int:
        """Squared distance of a node's number of quads from the wanted one, after a change."""
        wanted = int(self.wanted[node]) if node < len(self.wanted) else 4
        return (len(self.of_node[node]) + change - wanted) ** 2

    def mend(self, node: int, angle: float) -> None:
        for _ in range(4):
            if angle / len(self.of_node[node]) <= _FLAT:
                return
            if not self._turn_edge(node):
                break

    def open(self, node: int, angle: float) -> None:
        """Give a node that is still flat a second quad, by setting a smaller one into its own."""
        if angle > _FLAT and len(self.of_node[node]) == 1:
            self._set_in(min(self.of_node[node]))

    def _set_in(self, q: int) -> None:
        """Set a smaller quad into a quad."""
        outer = self._from(q, (self.quads[q] or [0])[0])
        corners = np.array([self.points[node] for node in outer])
        first = len(self.points)
        self.points += list(corners.mean(axis=0) + 0.4 * (corners - corners.mean(axis=0)))
        inner = list(range(first, first + 4))
        for node in inner:
            self.of_node[node] = set()
        self._replace(q, inner)
        for j in range(4):
            self.quads.append(None)
            k = (j + 1) % 4
            self._replace(len(self.quads) - 1, [outer[j], outer[k], inner[k], inner[j]])

    def _turn_edge(self, node: int) -> bool:
        """Give a node one more edge by the best turn; False where none is possible."""
        best: tuple[int, int, int, list[int]] | None = None
        for q in sorted(self.of_node[node]):
            quad = self._from(q, node)
            for a, b in ((quad[1], quad[2]), (quad[2], quad[3])):
                others = (self.of_node[a] & self.of_node[b]) - {q}
                if len(others) != 1:
                    continue
                other = others.pop()
                hexagon = self._hexagon(q, other, node)
                if hexagon is None:
                    continue
                gained = hexagon[3]
                cost = sum(self._excess(n, 1) - self._excess(n, 0) for n in (node, gained))
                cost += sum(self._excess(n, -1) - self._excess(n, 0) for n in (a, b))
                if best is None or cost < best[0]:
                    best = (cost, q, other, hexagon)
        if best is None:
            return False
        _, q, other, hexagon = best
        self._replace(q, hexagon[:4])
        self._replace(other, [hexagon[0], *hexagon[3:]])
        for corner in hexagon:
            self.take_out(corner)
        return True

    def _from(self, q: int, node: int) -> list[int]:
        quad = self.quads[q]
        assert quad is not None
        at = quad.index(node)
        return quad[at:] + quad[:at]

    def _hexagon(self, q: int, other: int, node: int) -> list[int] | None:
        """The six nodes around two neighbours, counter-clockwise from `node`."""
        first, second = self._from(q, node), self.quads[other]
        assert second is not None
        successor = {}
        for quad in (first, second):
            for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
                successor[a, b] = True
        border = {a: b for a, b in successor if (b, a) not in successor}
        ring = [node]
        while len(ring) < 6 and border.get(ring[-1]) is not None:
            ring.append(border[ring[-1]])
        return ring if len(set(ring)) == 6 and border.get(ring[-1]) == node else None

    def _replace(self, q: int, new: list[int]) -> None:
        old = self.quads[q]
        for node in old or ():
            self.of_node[node].discard(q)
        for node in new:
            self.of_node[node].add(q)
        self.quads[q] = new

    def take_out(self, node: int) -> None:
        """Merge the two quads of an inner node that has no more."""
        if node < len(self.wanted) or len(self.of_node[node]) != 2:
            return
        p, q = sorted(self.of_node[node])
        first, second = self._from(p, node), self._from(q, node)
        if {first[1], first[3]} != {second[1], second[3]}:
            return
        self._replace(p, [first[1], first[2], first[3], second[2]])
        for corner in second:
            self.of_node[corner].discard(q)
        self.quads[q] = None
