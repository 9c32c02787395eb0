r"""Mending quads that lie with one corner flat on the boundary, or share two edges.

Place in the flow: ``gmsh_quads`` hands every mesh through here before it is relaxed.

Method: where a boundary node that is no corner has one quad alone, that quad's angle there is flat,
and no relaxing helps. The quad and a neighbour are a hexagon, which is divided anew so that the node
gets an edge of its own: in two, or in three about a new node::

        h4--h3          h4--h3          h4--h3        h0 the flat node;
        | \  |           |  / |           | \ |         an inner node left with
       h5  \ h2   ->    h5 /  h2   or    h5  p-h2       two quads is taken out
         \  \ /           \|  /            \ |  /
          h0-h1           h0-h1            h0-h1

Of all ways, the one is taken after which the nodes' numbers of quads are nearest to what they should
be: one for each right angle of the boundary, four inside. Where every way would flatten another
node, a smaller quad is set into the flat one, with a quad on each side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..polygons import interior_angles

_FLAT = np.radians(150)
"""Angle of a quad's corner from which on it counts as flat: a sine of a half."""
_FORBIDDEN = 1000
"""Cost of making another node flat."""


def wanted_valences(loops: Sequence[FloatArray], opposite: FloatArray | None = None) -> tuple[IntArray, FloatArray]:
    """How many quads each boundary node should have, and the angle there, inside on the left.

    Where `opposite` (see :func:`mend_flat_corners`) has another angle, the number suits both, and the greater
    angle of the two is given.
    """
    angle: FloatArray = np.concatenate([interior_angles(loop) for loop in loops])
    other = angle if opposite is None else np.where(np.isnan(opposite), angle, opposite)
    wanted = np.maximum(1, np.round((angle + other) / np.pi)).astype(np.int64)
    return wanted, np.maximum(angle, other)


def mend_flat_corners(
    loops: Sequence[FloatArray], inner: FloatArray, quads: IntArray, opposite: FloatArray | None = None
) -> tuple[FloatArray, IntArray]:
    """Mend quads with a flat corner on the boundary.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise; their nodes come first in `quads`.
    inner : (n, 2) float64
    quads : (q, 4) int64
        Counter-clockwise.
    opposite : (b,) float64, optional
        Angles of the boundary nodes on the cap that the quads are swept to, NaN where they are as here.

    Returns
    -------
    inner, quads
        Some inner nodes may be gone, others new.
    """
    wanted, angle = wanted_valences(loops, opposite)
    n_boundary = len(wanted)
    uses = np.bincount(quads.ravel(), minlength=n_boundary + len(inner))
    flat = np.flatnonzero(angle / np.maximum(uses[:n_boundary], 1) > _FLAT)
    doublets = n_boundary + np.flatnonzero(uses[n_boundary:] == 2)
    if not len(flat) and not len(doublets):
        return inner, quads
    mender = _Mender(quads, wanted, angle, np.concatenate([*loops, inner]))
    for node in doublets:
        mender.take_out(int(node))
    for at in flat:
        mender.mend(int(at))
    kept: IntArray = np.array([q for q in mender.quads if q is not None], dtype=np.int64)
    used = distinct(kept[kept >= n_boundary])
    number = np.arange(len(mender.points))
    number[used] = n_boundary + np.arange(len(used))
    return np.array(mender.points)[used], number[kept]


class _Mender:
    """Quads as lists that may change, and the quads of every node."""

    def __init__(self, quads: IntArray, wanted: IntArray, angle: FloatArray, points: FloatArray) -> None:
        self.angle = angle
        self.points = list(points)
        self.quads: list[list[int] | None] = quads.tolist()
        self.wanted = wanted
        self.of_node: dict[int, set[int]] = {}
        for q, quad in enumerate(quads.tolist()):
            for node in quad:
                self.of_node.setdefault(node, set()).add(q)

    def _cost(self, changes: dict[int, int]) -> int:
        """How much further the numbers of quads come from the wanted ones, squared, by some changes."""
        cost = 0
        for node, change in changes.items():
            off = len(self.of_node[node]) - (int(self.wanted[node]) if node < len(self.wanted) else 4)
            cost += (off + change) ** 2 - off**2
            if change < 0 and node < len(self.wanted):
                n_quads = len(self.of_node[node])
                flat = self.angle[node] > _FLAT * (n_quads + change)
                cost += _FORBIDDEN if flat and self.angle[node] <= _FLAT * n_quads else 0
        return cost

    def mend(self, node: int) -> None:
        """Divide hexagons anew until a node is not flat."""
        for _ in range(4):
            if self.angle[node] <= _FLAT * len(self.of_node[node]):
                return
            ways = sorted(self._ways(node), key=lambda way: way[0])
            if not ways or ways[0][0] >= _FORBIDDEN / 2:
                if len(self.of_node[node]) == 1:
                    self._set_in(min(self.of_node[node]))
                return
            _, q, other, hexagon, in_three = ways[0]
            if in_three:
                self._divide_in_three(q, other, hexagon)
            else:
                self._divide_in_two(q, other, hexagon)

    def _ways(self, node: int) -> Iterator[tuple[int, int, int, list[int], bool]]:
        """Cost, the two quads, their hexagon, and whether it is divided in three."""
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
                three = dict.fromkeys(hexagon, 0)
                for corner, change in ((a, -1), (b, -1), (hexagon[0], 1), (hexagon[2], 1), (hexagon[4], 1)):
                    three[corner] += change
                yield self._cost(three) + 1, q, other, hexagon, True
                two = dict.fromkeys(hexagon, 0)
                for corner, change in ((a, -1), (b, -1), (hexagon[0], 1), (hexagon[3], 1)):
                    two[corner] += change
                for corner in (a, b):
                    if corner >= len(self.wanted) and len(self.of_node[corner]) == 3:
                        # It is left with two quads and taken out; its two neighbours then lose one.
                        at = hexagon.index(corner)
                        two[hexagon[at - 1]] -= 1
                        two[hexagon[(at + 1) % 6]] -= 1
                        two[corner] = 1  # counts as four
                yield self._cost(two), q, other, hexagon, False

    def _divide_in_two(self, q: int, other: int, hexagon: list[int]) -> None:
        self._replace(q, hexagon[:4])
        self._replace(other, [hexagon[0], *hexagon[3:]])
        for corner in hexagon:
            self.take_out(corner)

    def _set_in(self, q: int) -> None:
        """Set a smaller quad into a quad."""
        outer = list(self.quads[q] or ())
        corners = np.array([self.points[node] for node in outer])
        inner = list(range(len(self.points), len(self.points) + 4))
        self.points += list(corners.mean(axis=0) + 0.4 * (corners - corners.mean(axis=0)))
        self.of_node |= {node: set() for node in inner}
        self._replace(q, inner)
        for j in range(4):
            k = (j + 1) % 4
            self.quads.append(None)
            self._replace(len(self.quads) - 1, [outer[j], outer[k], inner[k], inner[j]])

    def _divide_in_three(self, q: int, other: int, hexagon: list[int]) -> None:
        center = len(self.points)
        self.points.append(np.mean([self.points[corner] for corner in hexagon], axis=0))
        self.of_node[center] = set()
        self.quads.append(None)
        for cell, j in ((q, 0), (other, 2), (len(self.quads) - 1, 4)):
            self._replace(cell, [hexagon[j], hexagon[j + 1], hexagon[(j + 2) % 6], center])

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
