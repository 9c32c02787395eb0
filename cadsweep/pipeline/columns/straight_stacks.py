"""A straight stack as blocks: each of its columns a factored sweep between nodes that columns share."""

from __future__ import annotations

import numpy as np

from ...blocks.cells import CellBlocks, SweptCell
from ...projection import FactoredSweep
from ...projection.factored import make_basis
from ...stack import Stack
from ...stack_mesh import StraightColumn, StraightStack


def blocks_of(stack: Stack, built: StraightStack) -> CellBlocks:
    """The blocks of a stack, whose nodes inside are numbered after the skeleton, column by column."""
    n = len(built.points)
    cells = tuple(
        SweptCell(
            cell=0,
            sweep=_factored(own, stack.direction),
            bottom=own.bottom,
            top=own.top,
            rings=own.rings,
            after=n,
            seen=own.seen,
        )
        for own in built.columns
    )
    firsts = np.cumsum([n, *(own.n_own for own in cells)])[:-1]
    return CellBlocks(
        points=built.points,
        cells=cells,
        firsts=tuple(firsts.tolist()),
        numbers=np.arange(n, dtype=np.int64),
        quads=built.quads,
        quad_cells=np.zeros(len(built.quads), dtype=np.int64),
        quad_faces=built.faces,
        edge_nodes={int(stack.solid.edge_keys[e]): nodes for e, nodes in built.edge_nodes.items()},
        roles={(0, f): role for role, own in (("source", stack.source), ("target", stack.target)) for f in own},
    )


def _factored(own: StraightColumn, up: np.ndarray) -> FactoredSweep:
    """Places of the plane times one, and what its layers rise by."""
    ring = np.concatenate(own.loops)
    rows = own.points + own.rises[[0, -1], None, None] * up
    center = rows[0, ring].mean(axis=0)
    lifts = (own.rises - own.rises[0])[:, None, None] * up
    coefficients = np.concatenate(
        [
            np.broadcast_to(np.eye(3), (len(lifts), 3, 3)),
            center + lifts,
            own.amounts[:, :, None] * up,
        ],
        axis=1,
    )
    return FactoredSweep(
        basis=make_basis(rows[0], center, None, None, own.modes),
        coefficients=coefficients,
        rings=own.points[ring] + own.rims[:, :, None] * up,
        loops=own.loops,
        quads=own.quads,
        source_points=rows[0],
        source_center=center,
        target_points=rows[1],
        ranks=np.full(len(lifts), 3),
        conditions=np.ones(len(lifts)),
        weights=np.linspace(0.0, 1.0, len(lifts)),
        n_modes=own.modes.shape[1],
    )


__all__ = ["blocks_of"]
