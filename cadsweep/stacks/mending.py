"""Quads of an arrangement mended where they are poor on the part's own levels, though fair in the plane.

Place in the flow: after the arrangement has been meshed, before it is judged. A mesher sees the plane alone. Where
outlines were laid together, a corner of 130 degrees there may be none at all on the level where one of them is
real, and a quad that has it is flat.

Method: around every poor quad the inner nodes look for places where the worst corners, over all levels with material,
lack least of what is good; where that does not help, what is around it is divided otherwise (:mod:`.rewrites`), in the
way that helps most, so that a flat corner gets edges of its own. Nodes on lines stay, and so do edges that lie on them.
The places on all levels are kept with the mesh: carried there anew, nodes would be elsewhere than they were judged.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from .along import across
from .blocks import find_presence
from .mending_kernels import look_around, worst_sines
from .places import find_places
from .rewrites import Around, Rewrite, rewrites

_GOOD = 0.35
"""Worst corner sine from which on a quad is left alone: somewhat more than is promised of hexahedra."""
_LEAST_MOVED = 0.001
"""Squares of what the corners' sines lack, in sum, for which nodes are moved: one that no move opens is not all."""
_LEAST_DIVIDED = 0.005
"""The same for which quads are divided otherwise."""
_SPARE = 400
"""Quads and nodes that may come to those of the plane."""
_MOST_MENDED = 400
"""Quads that are looked at, the worst first."""
_PASSES = 8
"""How often all quads are looked at at most."""
_FOLDED = 1e-6
"""Worst corner below which a quad makes no valid hexahedron."""
_SAME = 1e-9
"""Difference of corner sines up to which they are the same."""
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
    """Move inner nodes and divide quads otherwise where that raises the worst corner that quads have on any level.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    mesh : QuadMesh
        The source cap of ``stack.plan``.

    Returns
    -------
    QuadMesh
        With the same nodes on lines, but for their numbers; `mesh` itself where nothing is gained, where all levels are
        as the plane is (no outlines were laid together), or where rows of quads along walls were asked for.
    """
    if mesh.walls or not stack.arrangement.claims:
        return mesh
    work = _Quads(
        points=mesh.points,
        quads=mesh.quads,
        cells=mesh.faces,
        places=find_places(stack, levels, mesh) @ across(stack.direction).T,
        there=find_presence(stack, levels, mesh),
        lines=mesh.edge_nodes.values(),
        frame=across(stack.direction),
    )
    before = work.lacking()
    for _ in range(_PASSES):
        if not work.mend():
            break
    return work.mended(mesh) if work.lacking() < before else mesh


class _Quads:
    """Quads, and where their nodes are on every level."""

    def __init__(
        self,
        *,
        points: FloatArray,
        quads: IntArray,
        cells: IntArray,
        places: FloatArray,
        there: BoolArray,
        lines: Iterable[IntArray],
        frame: FloatArray,
    ) -> None:
        self.frame = frame
        self.n_nodes, self.n_quads = len(points), len(quads)
        self.points = np.pad(points, ((0, _SPARE), (0, 0)))
        self.places = np.pad(places, ((0, 0), (0, _SPARE), (0, 0)))
        self.there = np.pad(there, ((0, 0), (0, _SPARE)))
        self.alive = np.pad(np.ones(len(quads), dtype=bool), (0, _SPARE))
        fixed = np.zeros(len(self.points), dtype=bool)
        sides: set[tuple[int, int]] = set()
        for nodes in lines:
            fixed[nodes] = True
            sides.update((min(a, b), max(a, b)) for a, b in zip(nodes[:-1].tolist(), nodes[1:].tolist(), strict=True))
        at: dict[int, set[int]] = {}
        for q, own in enumerate(quads.tolist()):
            for node in own:
                at.setdefault(node, set()).add(q)
        self.around = Around(
            quads=np.pad(quads, ((0, _SPARE), (0, 0))),
            cells=np.pad(cells, (0, _SPARE)),
            fixed=fixed,
            lines=sides,
            at=at,
        )
        self.changed = False

    @property
    def quads(self) -> IntArray:
        """Rows of nodes (q, 4), those of quads that are gone among them."""
        return self.around.quads

    def worst(self, quads: Iterable[int]) -> FloatArray:
        """Worst corner sine of quads on all levels where they have material beside them."""
        ids = np.fromiter(quads, dtype=np.int64)
        out = np.empty(len(ids))
        worst_sines(self.places, self.quads, self.there, ids, out)
        return out

    def lacking(self) -> tuple[float, float]:
        """How many quads are folded, and the squares of what the worst corners of all quads lack, in sum."""
        worst = self.worst(np.flatnonzero(self.alive).tolist())
        return float(np.count_nonzero(worst < _FOLDED)), float((np.maximum(_GOOD - worst, 0.0) ** 2).sum())

    def mend(self) -> bool:
        """Go through the poor quads, the worst first; whether anything was changed."""
        self.changed = False
        ids = np.flatnonzero(self.alive)
        values = np.full(len(self.alive), np.inf)
        values[ids] = self.worst(ids.tolist())
        queue = np.flatnonzero(values < _GOOD)
        queue = queue[np.argsort(values[queue], kind="stable")][:_MOST_MENDED]
        for q in queue.tolist():
            if self.alive[q] and self.worst([q])[0] < _GOOD and self._relax([q]) < _GOOD:
                self._divide(q)
        return self.changed

    def mended(self, mesh: QuadMesh) -> QuadMesh:
        """The mesh with these quads, and their nodes numbered anew."""
        used = np.zeros(len(self.points), dtype=bool)
        used[self.quads[self.alive]] = True
        number = np.cumsum(used) - 1
        return replace(
            mesh,
            points=self.points[used],
            quads=number[self.quads[self.alive]],
            faces=self.around.cells[self.alive],
            loops=tuple(number[loop] for loop in mesh.loops),
            edge_nodes={e: number[nodes] for e, nodes in mesh.edge_nodes.items()},
            places=self.places[:, used] @ self.frame,
        )

    def _relax(self, quads: Sequence[int]) -> float:
        """Let the inner nodes of quads look for better places; return the worst corner around them then."""
        nodes = [n for n in np.unique(self.quads[quads]).tolist() if not self.around.fixed[n]]
        near = sorted({q for n in nodes for q in self.around.at[n]} | set(quads))
        for _ in range(_ROUNDS):
            moved = [self._look_around(n) for n in nodes]
            if not any(moved):
                break
        return float(self.worst(near).min())

    def _look_around(self, node: int) -> bool:
        """Move a node to the best of the places around it, where that gains enough."""
        ids = np.array(sorted(self.around.at[node]))
        move = np.empty(2)
        gain = look_around(self.places, self.quads, self.there, ids, node, _OFFSETS, _GOOD, move)
        if not gain > _LEAST_MOVED:
            return False
        self.places[:, node] += move
        self.points[node] += move @ self.frame
        self.changed = True
        return True

    def _divide(self, q: int) -> None:
        """Divide what is around a quad in that other way which helps most, if one does."""
        best: tuple[float, Rewrite] | None = None
        for found in rewrites(self.around, q):
            gain = self._gain(found)
            if gain > _LEAST_DIVIDED and (best is None or gain > best[0]):
                best = gain, found
        if best is not None:
            self._relax(self._put(best[1]))
            self.changed = True

    def _gain(self, found: Rewrite) -> float:
        """How much less the quads around lack where some are divided otherwise; nothing is changed."""
        n_new = len(found.shares)
        if self.n_nodes + n_new > len(self.points) or self.n_quads + n_new > len(self.alive):
            return 0.0
        removed = list(found.removed)
        nodes = {*self.quads[removed].ravel().tolist(), *found.rows[found.rows >= 0].tolist()}
        free = sorted(n for n in nodes if not self.around.fixed[n])
        changed, places, points = self.changed, self.places[:, free].copy(), self.points[free].copy()
        before = self.worst({r for n in free for r in self.around.at[n]} | set(removed))
        old = self.quads[removed].copy()
        own = self._put(found)
        self._relax(own)
        after = self.worst({r for n in free for r in self.around.at[n]} | set(own))
        self._take(own)
        self._lay(removed, old)
        self.n_nodes, self.n_quads = self.n_nodes - n_new, self.n_quads - max(len(own) - len(removed), 0)
        self.changed, self.places[:, free], self.points[free] = changed, places, points
        if after.min() < before.min() - _SAME:
            return 0.0
        return float((np.maximum(_GOOD - before, 0.0) ** 2).sum() - (np.maximum(_GOOD - after, 0.0) ** 2).sum())

    def _put(self, found: Rewrite) -> list[int]:
        """Put quads in the place of others; their numbers."""
        removed, n_new, n_more = list(found.removed), len(found.shares), len(found.rows) - len(found.removed)
        new = np.arange(self.n_nodes, self.n_nodes + n_new)
        corners = self.quads[removed[0]]
        self.points[new] = found.shares @ self.points[corners]
        self.places[:, new] = found.shares @ self.places[:, corners]
        rows = np.where(found.rows < 0, self.n_nodes - 1 - found.rows, found.rows)
        self._take(removed)
        own = [*removed, *range(self.n_quads, self.n_quads + n_more)][-len(found.rows) :]
        self.around.cells[own], self.there[:, own] = self.around.cells[removed[0]], self.there[:, removed[:1]]
        self.n_nodes, self.n_quads = self.n_nodes + n_new, self.n_quads + max(n_more, 0)
        self._lay(own, rows)
        return own

    def _take(self, quads: Sequence[int]) -> None:
        self.alive[quads] = False
        for q in quads:
            for node in self.quads[q].tolist():
                self.around.at[node].discard(q)

    def _lay(self, quads: Sequence[int], rows: IntArray) -> None:
        self.alive[quads], self.quads[quads] = True, rows
        for q, row in zip(quads, rows.tolist(), strict=True):
            for node in row:
                self.around.at.setdefault(node, set()).add(q)
