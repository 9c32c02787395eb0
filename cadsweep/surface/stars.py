"""Faces of cells that have a block at every corner: a patch of quads at each of theirs, and their middle.

Place in the flow: after the grids, before the caps of swept cells, which take these quads as they find them.

Method: lines from the node at the half of every side to the middle of the face; the patches between them are filled
as logical rectangles on the face's surface.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face, Surface
from ..corner_blocks import CornerBlocks, balanced
from ..errors import SurfaceMeshError
from ..sweep import DirectedEdge, turned_chain
from .skeleton import Skeleton
from .transfinite import fill, join_chains

Patches = dict[int, IntArray]
"""Corner vertex to nodes (h + 1, w + 1): the corner first, rows away from it along the chain that leads into it."""


def lay_star(skeleton: Skeleton, cell: int, blocks: CornerBlocks, face: int, sheets: IntArray) -> None:
    """Mesh a face that has not four corners, unless a neighbour did.

    Raises
    ------
    SurfaceMeshError
        The surface gives no finite points.
    """
    solid = blocks.solid
    if int(solid.face_keys[face]) in skeleton.faces:
        return
    surface = solid.faces[face].surface
    sides = blocks.outlines[face]
    nodes = [skeleton.chain(cell, _directed(blocks, *side)) for side in sides]
    uv = [_chain_uv(skeleton, cell, blocks.solid.faces[face], _directed(blocks, *side)) for side in sides]
    halves = _halves(blocks, face, sheets)
    points = skeleton.points
    middles = np.array([n[h] for n, h in zip(nodes, halves, strict=True)])
    middle_uv = np.array([row[h] for row, h in zip(uv, halves, strict=True)])
    # The line to the middle of a side crosses the sheets of the sides beside it, as far as the middle.
    depths = np.array([halves[(j + 1) % len(sides)] for j in range(len(sides))])
    place = blocks.face_views[face].nearest(balanced(points[middles], depths))
    center, center_uv = _center(surface, place, middle_uv)
    center_node = int(skeleton.add(center[None])[0])
    lines, lines_uv = [], []
    for j, n in enumerate(depths.tolist()):
        line_uv, line = _line(surface, (middle_uv[j], center_uv), (points[middles[j]], center), n)
        lines.append(np.concatenate([middles[j : j + 1], skeleton.add(line), [center_node]]))
        lines_uv.append(line_uv)
    points = skeleton.points
    patches: Patches = {}
    for j, (chain, forward) in enumerate(sides):
        before = j - 1
        chains = (nodes[j][: halves[j] + 1], lines[j], lines[before], nodes[before][halves[before] :][::-1])
        own_uv = (uv[j][: halves[j] + 1], lines_uv[j], lines_uv[before], uv[before][halves[before] :][::-1])
        bottom, right, top, left = chains
        filled, _, _ = fill(surface, own_uv, tuple(points[c] for c in chains))
        if not np.isfinite(filled).all():
            raise SurfaceMeshError(
                f"{solid.faces[face].label()} could not be filled: its surface gives no finite points"
            )
        patch = np.empty((len(left), len(bottom)), dtype=np.int64)
        patch[1:-1, 1:-1] = skeleton.add(filled[1:-1, 1:-1].reshape(-1, 3)).reshape(
            patch.shape[0] - 2, patch.shape[1] - 2
        )
        patch[0], patch[:, -1], patch[-1], patch[:, 0] = bottom, right, top, left
        corner = blocks.ends[chain][not forward]
        patches[int(solid.vertex_keys[corner])] = patch
    skeleton.keep_patches(cell, face, patches)


def patches_of(skeleton: Skeleton, cell: int, blocks: CornerBlocks, face: int, sheets: IntArray) -> Patches:
    """The patches of a face that is meshed, by the corner's vertex: rows along the chain into it, turned outward."""
    solid = blocks.solid
    mesh = skeleton.faces[int(solid.face_keys[face])]
    corners = [blocks.ends[chain][not forward] for chain, forward in blocks.outlines[face]]
    if face not in blocks.grids:
        found = {corner: mesh.patches[int(solid.vertex_keys[corner])] for corner in corners}
        return found if mesh.place == (cell, face) else {corner: patch.T for corner, patch in found.items()}
    grid = skeleton.grid_of(cell, blocks.grids[face])
    halves = _halves(blocks, face, sheets)
    patches = {}
    for j, corner in enumerate(corners):
        patches[corner] = grid[: grid.shape[0] - halves[j - 1], : halves[j] + 1]
        grid = grid[:, ::-1].T  # from the next corner, along the next side
    return patches


def _halves(blocks: CornerBlocks, face: int, sheets: IntArray) -> list[int]:
    """Segments of every side of a face from where it begins to its middle node."""
    return [int(sheets[blocks.across[chain][not forward]]) for chain, forward in blocks.outlines[face]]


def _directed(blocks: CornerBlocks, chain: int, forward: bool) -> tuple[DirectedEdge, ...]:
    """The edges of a chain in its direction or against it."""
    return blocks.chains[chain] if forward else turned_chain(blocks.chains[chain])


def _chain_uv(skeleton: Skeleton, cell: int, face: Face, chain: Sequence[DirectedEdge]) -> FloatArray:
    """Parameters on a face of the nodes along a chain."""
    return join_chains([skeleton.edge_uv(cell, face, e)[:: 1 if ahead else -1] for e, ahead in chain])


def _center(surface: Surface, place: FloatArray, middle_uv: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The point of the surface at a place, and its parameters beside those of the middles of the sides."""
    uv = _beside(surface, surface.project(place[None]), middle_uv.mean(axis=0))
    return surface.evaluate(uv)[0], uv[0]


def _line(
    surface: Surface, uv: tuple[FloatArray, FloatArray], ends: tuple[FloatArray, FloatArray], n: int
) -> tuple[FloatArray, FloatArray]:
    """Parameters (n + 1, 2) of a line between two points of a surface, and its inner points (n - 1, 3)."""
    t = np.linspace(0.0, 1.0, n + 1)[:, None]
    straight = (1.0 - t) * uv[0] + t * uv[1]
    if n > 1:
        wanted = ((1.0 - t) * ends[0] + t * ends[1])[1:-1]
        straight[1:-1] = _beside(surface, surface.project(wanted), straight[1:-1])
    return straight, surface.evaluate(straight[1:-1]) if n > 1 else np.empty((0, 3))


def _beside(surface: Surface, uv: FloatArray, reference: FloatArray) -> FloatArray:
    """Parameters in the branch of a reference."""
    uv = np.array(uv, dtype=np.float64)
    for axis, period in enumerate(surface.periods):
        if period is not None:
            uv[..., axis] -= period * np.round((uv[..., axis] - reference[..., axis]) / period)
    return uv
