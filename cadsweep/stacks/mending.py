"""Quads of an arrangement mended where they are poor on the part's own levels, though fair in the plane.

Place in the flow: after the arrangement has been meshed, before it is judged. A mesher sees the plane alone. Where
outlines were laid together, a corner of 130 degrees there may be none at all on the level where one of them is
real, and a quad that has it is flat.

Method: around every poor quad the inner nodes look for places where the worst corner, over all levels with material,
is best; where that does not help, the edge to one of its neighbours is turned inside the hexagon of both ::

    +-----+-----+        +-----+-----+
    |     |     |   ->   |  .-----'  |     a flat corner gets an edge of its own
    +-----+-----+        +-'---+-----+

Nodes on lines stay, and so do edges that lie on them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from .along import across
from .blocks import find_presence
from .mending_kernels import look_around, worst_sines
from .places import find_places

_GOOD = 0.35
"""Worst corner sine from which on a quad is left alone: somewhat more than is promised of hexahedra."""
_LEAST_GAIN = 0.02
"""Gain of the worst corner's sine for which nodes are moved, or an edge is turned."""
_MOST_MENDED = 400
"""Quads that are looked at, the worst first."""
_ROUNDS = 6
"""How often the nodes around a quad look around themselves."""
_OFFSETS = np.concatenate(
    [
        reach * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        for angles in [2.0 * np.pi * np.arange(8) / 8]
        for reach in (0.4, 0.12, 0.03)
    ]
)
"""Where a node looks, in lengths of its shortest edge."""


def mend_quads(stack: Stack, levels: Levels, mesh: QuadMesh) -> QuadMesh:
    """Move inner nodes and turn inner edges where that raises the worst corner that quads have on any level.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    mesh : QuadMesh
        The source cap of ``stack.plan``.

    Returns
    -------
    QuadMesh
        With as many quads and nodes, in the same cells; `mesh` itself where nothing is gained, where all levels are as
        the plane is (no outlines were laid together), or where rows of quads along walls were asked for.
    """
    if mesh.walls or not stack.arrangement.claims:
        return mesh
    work = _Quads(stack, levels, mesh)
    work.mend()
    if not work.changed:
        return mesh
    return replace(mesh, points=mesh.points + work.moves @ work.frame, quads=work.quads)


class _Quads:
    """Quads, and where their nodes are on every level."""

    def __init__(self, stack: Stack, levels: Levels, mesh: QuadMesh) -> None:
        self.frame = across(stack.direction)
        self.quads = np.array(mesh.quads, dtype=np.int64, order="C")
        self.cells = mesh.faces
        self.places = np.ascontiguousarray(find_places(stack, levels, mesh) @ self.frame.T)
        self.there = np.ascontiguousarray(find_presence(stack, levels, mesh))
        self.moves = np.zeros((len(mesh.points), 2))
        self.fixed = np.zeros(len(mesh.points), dtype=bool)
        self.lines: set[tuple[int, int]] = set()
        for nodes in mesh.edge_nodes.values():
            self.fixed[nodes] = True
            self.lines.update(
                (min(a, b), max(a, b)) for a, b in zip(nodes[:-1].tolist(), nodes[1:].tolist(), strict=True)
            )
        self.around: dict[int, set[int]] = {}
        for q, nodes in enumerate(self.quads.tolist()):
            for node in nodes:
                self.around.setdefault(node, set()).add(q)
        self.changed = False

    def worst(self, quads: Iterable[int]) -> FloatArray:
        """Worst corner sine of quads on all levels where they have material beside them."""
        ids = np.fromiter(quads, dtype=np.int64)
        out = np.empty(len(ids))
        worst_sines(self.places, self.quads, self.there, ids, out)
        return out

    def mend(self) -> None:
        """Go through the poor quads, the worst first, those that have come off badly again."""
        values = self.worst(range(len(self.quads)))
        queue = np.flatnonzero(values < _GOOD)
        queue = queue[np.argsort(values[queue], kind="stable")][:_MOST_MENDED]
        for q in queue.tolist():
            if self.worst([q])[0] < _GOOD and self._relax([q]) < _GOOD:
                self._turn(q)

    def _relax(self, quads: list[int]) -> float:
        """Let the inner nodes of quads look for better places; return the worst corner around them then."""
        nodes = [n for n in np.unique(self.quads[quads]).tolist() if not self.fixed[n]]
        near = sorted({q for n in nodes for q in self.around[n]} | set(quads))
        for _ in range(_ROUNDS):
            moved = [self._look_around(n) for n in nodes]
            if not any(moved):
                break
        return float(self.worst(near).min())

    def _look_around(self, node: int) -> bool:
        """Move a node to the best of the places around it, where that gains enough."""
        ids = np.array(sorted(self.around[node]))
        move = np.empty(2)
        gain = look_around(self.places, self.quads, self.there, ids, node, _OFFSETS, move)
        if not gain > 0.25 * _LEAST_GAIN:
            return False
        self.places[:, node] += move
        self.moves[node] += move
        self.changed = True
        return True

    def _turn(self, q: int) -> None:
        """Turn that edge of a quad which helps most, if one does."""
        best: tuple[float, int, IntArray] | None = None
        for side in range(4):
            other = self._beyond(q, side)
            if other is None:
                continue
            for pair in self._turned(q, side, other):
                gain = self._gain(q, other, pair)
                if gain > _LEAST_GAIN and (best is None or gain > best[0]):
                    best = gain, other, pair
        if best is not None:
            self._put(q, best[1], best[2])
            self._relax([q, best[1]])
            self.changed = True

    def _beyond(self, q: int, side: int) -> int | None:
        """The quad of the same cell across a side that is on no line."""
        a, b = (int(n) for n in self.quads[q, [side, (side + 1) % 4]])
        if (min(a, b), max(a, b)) in self.lines:
            return None
        shared = (self.around[a] & self.around[b]) - {q}
        return next((r for r in shared if self.cells[r] == self.cells[q]), None)

    def _turned(self, q: int, side: int, other: int) -> list[IntArray]:
        """Both other ways to divide the hexagon of two quads."""
        b, c, a, v = np.roll(self.quads[q], -side).tolist()  # the side runs from b to c
        beyond = self.quads[other].tolist()
        k = beyond.index(c)
        if beyond[(k + 1) % 4] != b:
            return []
        e, f = beyond[(k + 2) % 4], beyond[(k + 3) % 4]
        if len({a, b, c, v, e, f}) < 6 or any(not self.fixed[n] and len(self.around[n]) < 4 for n in (b, c)):
            return []  # an inner node of two quads: one of them is no quad
        # Around the hexagon: v, b, e, f, c, a. A new edge between nodes of another quad would lie across that.
        pairs = (((v, f), [[v, b, e, f], [v, f, c, a]]), ((a, e), [[b, e, a, v], [e, f, c, a]]))
        return [np.array(pair) for (m, n), pair in pairs if self.around[m] & self.around[n] <= {q, other}]

    def _gain(self, q: int, other: int, pair: IntArray) -> float:
        """What the worst quad around gains where two are divided otherwise; nothing is changed."""
        nodes = np.unique(pair).tolist()
        near = sorted({r for n in nodes if not self.fixed[n] for r in self.around[n]} | {q, other})
        before = float(self.worst(near).min())
        kept = self.quads[[q, other]].copy(), self.places[:, nodes].copy(), self.moves[nodes].copy(), self.changed
        self._put(q, other, pair)
        after = float(self.worst(near).min())
        if after < _GOOD:
            self._relax([q, other])
            after = float(self.worst(near).min())
        self._put(q, other, kept[0])
        self.places[:, nodes], self.moves[nodes], self.changed = kept[1:]
        return min(after, _GOOD) - before

    def _put(self, q: int, other: int, pair: IntArray) -> None:
        for r, row in zip((q, other), pair, strict=True):
            for node in self.quads[r].tolist():
                self.around[node].discard(r)
            self.quads[r] = row
        for r in (q, other):
            for node in self.quads[r].tolist():
                self.around[node].add(r)
