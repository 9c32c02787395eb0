"""A cell of blocks at its corners, filled with hexahedra when its faces are meshed.

Place in the flow: the counterpart of a sweep's projection in :mod:`.cells`. Every block has three sides on faces of the
cell and three inside, where two corners meet at the middle of a chain; nodes inside both are interpolated
transfinitely between the sides.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray, IntArray
from ...corner_blocks import CornerBlocks, balanced
from ...surface import Skeleton, grid_quads, patches_of


def fill_corners(
    skeleton: Skeleton, cell: int, blocks: CornerBlocks, sheets: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Place the nodes inside a cell whose faces are meshed.

    Returns
    -------
    hexes : (m, 8) int64
    quads : (q, 4) int64
        On its faces, outward.
    faces : (q,) int64
    """
    patches = {face: patches_of(skeleton, cell, blocks, face, sheets) for face in blocks.outlines}
    inside = _Inside(skeleton, blocks, patches, sheets)
    hexes = np.concatenate([_block_hexes(inside.block(corner)) for corner in blocks.corners])
    quads = [(face, grid_quads(patch)) for face, own in patches.items() for patch in own.values()]
    return (
        hexes,
        np.concatenate([own for _, own in quads]),
        np.repeat([face for face, _ in quads], [len(own) for _, own in quads]),
    )


class _Inside:
    """Nodes of the lines, surfaces and blocks inside one cell."""

    def __init__(
        self, skeleton: Skeleton, blocks: CornerBlocks, patches: dict[int, dict[int, IntArray]], sheets: IntArray
    ) -> None:
        self.skeleton = skeleton
        self.blocks = blocks
        self.patches = patches
        centers = {face: next(iter(own.values()))[-1, -1] for face, own in patches.items()}
        faces = list(centers)
        wanted = balanced(skeleton.points[[centers[face] for face in faces]], sheets[faces])
        self.center = int(skeleton.add(blocks.view.nearest(wanted)[None])[0])
        self.spokes = {face: self.spoke(int(node), int(sheets[face])) for face, node in centers.items()}
        self.walls = {chain: self.wall(chain) for chain in range(len(blocks.chains))}

    def spoke(self, node: int, n: int) -> IntArray:
        """Nodes (n + 1,) of the line from the middle of a face to the middle of the cell."""
        t = np.linspace(0.0, 1.0, n + 1)[1:-1, None]
        ends = self.skeleton.points[[node, self.center]]
        return np.concatenate([[node], self.skeleton.add((1.0 - t) * ends[0] + t * ends[1]), [self.center]])

    def wall(self, chain: int) -> tuple[int, IntArray]:
        """The surface between the blocks at the ends of a chain: a face beside it, and nodes, rows towards that face's
        middle."""
        corner = self.blocks.ends[chain][0]
        one, other = (f for f, outline in self.blocks.outlines.items() if chain in {c for c, _ in outline})
        if not self.leaves(one, chain, corner):
            one, other = other, one
        near = self.patches[one][corner][:, -1]  # on the face that the chain leaves the corner on: its patch's columns
        far = self.patches[other][corner][-1]
        return one, self.filled(near, far, self.spokes[one], self.spokes[other])

    def leaves(self, face: int, chain: int, corner: int) -> bool:
        """Whether a face's outline runs along a chain away from a corner."""
        return any(c == chain and self.blocks.ends[c][not ahead] == corner for c, ahead in self.blocks.outlines[face])

    def filled(self, near: IntArray, far: IntArray, beyond_near: IntArray, beyond_far: IntArray) -> IntArray:
        """Nodes of a surface between four lines: first column and row, then last row and column."""
        grid = np.zeros((len(near), len(far)), dtype=np.int64)
        grid[:, 0], grid[0], grid[-1], grid[:, -1] = near, far, beyond_near, beyond_far
        inner = _between(self.skeleton.points[grid], grid.shape)
        grid[1:-1, 1:-1] = self.skeleton.add(inner.reshape(-1, 3)).reshape(len(near) - 2, len(far) - 2)
        return grid

    def block(self, corner: int) -> IntArray:
        """Nodes (a + 1, b + 1, c + 1) of the block at a corner, right-handed."""
        blocks = self.blocks
        first = next(face for face, own in self.patches.items() if corner in own)
        outline = blocks.outlines[first]
        at = next(j for j, (c, ahead) in enumerate(outline) if blocks.ends[c][not ahead] == corner)
        into, out = outline[at - 1][0], outline[at][0]
        third = next(c for c, ends in enumerate(blocks.ends) if corner in ends and c not in (into, out))
        second = next(f for f in self.patches if f != first and self.has(f, into) and self.has(f, third))
        last = next(f for f in self.patches if f not in (first, second) and self.has(f, out) and self.has(f, third))
        low, left, right = (self.patches[face][corner] for face in (first, second, last))
        nodes = np.zeros((*low.shape, right.shape[1]), dtype=np.int64)
        nodes[:, :, 0], nodes[:, 0, :], nodes[0, :, :] = low, left.T, right
        nodes[:, :, -1] = self.towards(third, second)
        nodes[-1, :, :] = self.towards(into, first)
        nodes[:, -1, :] = self.towards(out, first)
        inner = _within(self.skeleton.points[nodes], nodes.shape)
        nodes[1:-1, 1:-1, 1:-1] = self.skeleton.add(inner.reshape(-1, 3)).reshape(tuple(n - 2 for n in nodes.shape))
        return nodes

    def has(self, face: int, chain: int) -> bool:
        """Whether a chain is on the outline of a face."""
        return any(c == chain for c, _ in self.blocks.outlines[face])

    def towards(self, chain: int, face: int) -> IntArray:
        """The wall at the middle of a chain, rows towards the middle of a face."""
        one, nodes = self.walls[chain]
        return nodes if one == face else nodes.T


def _between(points: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Points (h - 1, w - 1, 3) inside a grid whose border is given, by transfinite interpolation."""
    s, t = (np.linspace(0.0, 1.0, n)[1:-1] for n in shape)
    s, t = s[:, None, None], t[None, :, None]
    p = points
    lines = (1 - s) * p[:1, 1:-1] + s * p[-1:, 1:-1] + (1 - t) * p[1:-1, :1] + t * p[1:-1, -1:]
    corners = (1 - s) * ((1 - t) * p[0, 0] + t * p[0, -1]) + s * ((1 - t) * p[-1, 0] + t * p[-1, -1])
    return np.asarray(lines - corners)


def _within(points: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Points inside a block whose six sides are given, by transfinite interpolation (Gordon and Hall)."""
    r, s, t = (np.linspace(0.0, 1.0, n)[1:-1] for n in shape)
    weights = (r[:, None, None, None], s[None, :, None, None], t[None, None, :, None])
    total = np.zeros((len(r), len(s), len(t), 3))
    inner, ends = slice(1, -1), (slice(0, 1), slice(-1, None))
    for axes in ((0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)):
        for which in np.ndindex(*(2,) * len(axes)):
            at = [inner, inner, inner]
            weight: FloatArray = np.ones((1, 1, 1, 1))
            for axis, end in zip(axes, which, strict=True):
                at[axis] = ends[end]
                weight = weight * (weights[axis] if end else 1.0 - weights[axis])
            total = total + (-1.0) ** (len(axes) - 1) * weight * points[tuple(at)]
    return total


def _block_hexes(nodes: IntArray) -> IntArray:
    """Hexahedra (m, 8) of a block of nodes, VTK order."""
    low, high = slice(None, -1), slice(1, None)
    corners = [(low, low), (high, low), (high, high), (low, high)]
    return np.stack([nodes[i, j, k] for k in (low, high) for i, j in corners], axis=-1).reshape(-1, 8)
