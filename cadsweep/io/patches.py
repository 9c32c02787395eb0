"""Rectangles of the sides of structured blocks: what bounds them, or which side of which block they meet, and how.

Place in the flow: for :mod:`.plot3d` and :mod:`.cgns_grids`, after :mod:`.grids`; and the way back, which makes one
mesh of blocks and the rectangles that they share.

A side has the number and the two directions that neutral map files give it: 1 and 2 are k least and greatest with
(i, j), 3 and 4 i with (j, k), 5 and 6 j with (k, i).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..mesh import HexMesh
from .grids import Grids
from .labels import LabelledMesh
from .pairing import first_rows
from .sides import find_sides

NORMALS = (2, 2, 0, 0, 1, 1)
"""Axis across a side, 0 for i; :data:`AXES` are those along it."""

AXES = ((0, 1), (0, 1), (1, 2), (1, 2), (2, 0), (2, 0))

_ROWS = np.array([0, 1, 5, 3, 2, 4])
"""Row of ``HEX_FACES`` of a side."""

_CORNERS = np.array([[0, 1, 3, 2], [4, 5, 7, 6], [0, 3, 4, 7], [1, 2, 5, 6], [0, 4, 1, 5], [3, 7, 2, 6]])
"""Corners (0, 0), (1, 0), (0, 1), (1, 1) of a side of a hexahedron in its two directions."""

_PLACES = np.array([[0, 0], [1, 0], [0, 1], [1, 1]])


@dataclass(frozen=True, kw_only=True)
class Range:
    """Nodes of a block's side, from a corner to the one across.

    Attributes
    ----------
    block, side : int
        The side from 0.
    begin, end : (int, int)
        Nodes along the side's two directions, from 0; `end` may be less.
    """

    block: int
    side: int
    begin: tuple[int, int]
    end: tuple[int, int]

    def nodes(self, shape: Sequence[int]) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Both corners as (i, j, k), of a block of so many hexahedra."""
        found = []
        for place in (self.begin, self.end):
            node = [shape[NORMALS[self.side]] if self.side % 2 else 0] * 3
            for axis, step in zip(AXES[self.side], place, strict=True):
                node[axis] = step
            found.append(tuple(node))
        return found[0], found[1]


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A rectangle of a side.

    Attributes
    ----------
    here : Range
        Ascending.
    label : int
        Block of the mesh's named quads that it belongs to as this side sees it, -1 none.
    there : Range or None
        The same nodes in the side that it meets.
    there_label : int
        As that side sees it.
    swapped : bool
        The first direction here is the second there.
    """

    here: Range
    label: int
    there: Range | None = None
    there_label: int = -1
    swapped: bool = False


def find_patches(mesh: LabelledMesh, grids: Grids) -> list[Patch]:
    """The rectangles of all sides; one where two sides meet stands once."""
    label = np.full(6 * len(grids.hexes), -1, dtype=np.int64)
    if len(mesh.quads):
        of, rows = find_sides(grids.hexes, mesh.quads[:, :4], len(mesh.points))
        label[6 * of + rows] = mesh.faces.of_cell
    places = _places(grids)
    side_of_row = np.argsort(_ROWS)
    patches = []
    for block, shape in enumerate(grids.shapes.tolist()):
        ids = np.arange(grids.first[block], grids.first[block + 1]).reshape(shape[::-1])
        for side in range(6):
            own = np.take(ids, -1 if side % 2 else 0, axis=2 - NORMALS[side])
            if NORMALS[side] == 1:  # what is left is (k, i), and rows should be the second direction
                own = own.T
            quads = 6 * own + _ROWS[side]
            across = grids.across[quads]
            meets = (across >= 0) & (quads < across)
            codes = np.full((*own.shape, 10), -1, dtype=np.int64)
            codes[..., 0] = np.where(across < 0, 0, np.where(meets, 1, 2))
            codes[..., 1] = label[quads]
            there = across[meets]
            codes[meets, 2] = label[there]
            codes[meets, 3:] = _meeting(grids, places, (quads[meets], there), side=side, at=np.argwhere(meets)[:, ::-1])
            kinds = codes.reshape(-1, 10)
            for (u0, v0), (u1, v1), which in _rectangles(first_rows(kinds).reshape(own.shape)):
                met, name, other_name, other, at, *motion = kinds[which].tolist()
                if met == 2:
                    continue
                here = Range(block=block, side=side, begin=(u0, v0), end=(u1, v1))
                if met == 0:
                    patches.append(Patch(here=here, label=name))
                    continue
                shift, first, second = np.array(motion[:2]), *_directions(motion[2:4])
                corners = [tuple((shift + u * first + v * second).tolist()) for u, v in ((u0, v0), (u1, v1))]
                beyond = Range(block=other, side=int(side_of_row[at]), begin=corners[0], end=corners[1])
                swapped = bool(first[1])
                patches.append(Patch(here=here, label=name, there=beyond, there_label=other_name, swapped=swapped))
    return patches


def _places(grids: Grids) -> IntArray:
    """Block, and place (i, j, k) in it, of every hexahedron (m, 4)."""
    places = np.empty((len(grids.hexes), 4), dtype=np.int64)
    for block, shape in enumerate(grids.shapes.tolist()):
        own = places[grids.first[block] : grids.first[block + 1]]
        own[:, 0] = block
        own[:, 1:] = np.indices(shape[::-1]).reshape(3, -1)[::-1].T
    return places


def _meeting(grids: Grids, places: IntArray, quads: tuple[IntArray, IntArray], *, side: int, at: IntArray) -> IntArray:
    """For quads that meet others: block, row of the side, where node (0, 0) of this side would be there, directions."""
    here, there = quads
    other_side = np.argsort(_ROWS)[there % 6]
    own = grids.hexes[here[:, None] // 6, _CORNERS[side]]
    other = grids.hexes[there[:, None] // 6, _CORNERS[other_side]]
    match = (own[:, :3, None] == other[:, None]).argmax(axis=2)
    origin, first, second = (_PLACES[match[:, k]] for k in range(3))
    first, second = first - origin, second - origin
    axes = np.array(AXES)[other_side]
    node = np.take_along_axis(places[there // 6, 1:], axes, axis=1) + origin
    shift = node - at[:, :1] * first - at[:, 1:] * second
    turned = (first * [1, 2]).sum(axis=1), (second * [1, 2]).sum(axis=1)
    return np.column_stack([places[there // 6, 0], there % 6, shift, *turned, np.zeros(len(here), dtype=np.int64)])


def _directions(turned: Sequence[int]) -> list[IntArray]:
    """Steps (2,) along a side of the directions of another: 1 and 2, or minus that."""
    return [np.sign(code) * np.array([abs(code) == 1, abs(code) == 2], dtype=np.int64) for code in turned]


def _rectangles(kind: IntArray) -> list[tuple[tuple[int, int], tuple[int, int], int]]:
    """Rectangles of one kind each that cover a table (v, u): lower corner, upper corner, kind."""
    free = np.ones(kind.shape, dtype=bool)
    found = []
    n_rows, n_columns = kind.shape
    for v in range(n_rows):
        u = 0
        while u < n_columns:
            if not free[v, u]:
                u += 1
                continue
            which = kind[v, u]
            run = (kind[v, u:] == which) & free[v, u:]
            width = len(run) if run.all() else int(np.argmin(run))
            same = ((kind[v:, u : u + width] == which) & free[v:, u : u + width]).all(axis=1)
            height = len(same) if same.all() else int(np.argmin(same))
            free[v : v + height, u : u + width] = False
            found.append(((u, v), (u + width, v + height), int(which)))
            u += width
    return found


def side_quads(nodes: IntArray, part: Range) -> IntArray:
    """Outward quads (q, 4) of a rectangle of a block's nodes (nk + 1, nj + 1, ni + 1)."""
    own = np.take(nodes, -1 if part.side % 2 else 0, axis=2 - NORMALS[part.side])
    if NORMALS[part.side] == 1:
        own = own.T
    low, high = (np.sort([part.begin[k], part.end[k]]) for k in range(2))
    own = own[high[0] : high[1] + 1, low[0] : low[1] + 1]
    quads = np.stack([own[:-1, :-1], own[:-1, 1:], own[1:, 1:], own[1:, :-1]], axis=-1).reshape(-1, 4)
    return quads if part.side % 2 else quads[:, [0, 3, 2, 1]]


def grid_hexes(nodes: IntArray) -> IntArray:
    """Hexahedra (m, 8) of a block's nodes, i running fastest."""
    low, high = slice(-1), slice(1, None)
    square = ((low, low), (low, high), (high, high), (high, low))
    return np.stack([nodes[k, j, i] for k in (low, high) for j, i in square], axis=-1).reshape(-1, 8)


def along(nodes: IntArray, part: Range) -> IntArray:
    """Nodes (v, u) of a rectangle in the order in which it is walked."""
    own = np.take(nodes, -1 if part.side % 2 else 0, axis=2 - NORMALS[part.side])
    if NORMALS[part.side] == 1:
        own = own.T
    steps = [
        np.arange(a, b + 1) if a <= b else np.arange(a, b - 1, -1) for a, b in zip(part.begin, part.end, strict=True)
    ]
    if any(len(step) and not 0 <= step.min() <= step.max() < n for step, n in zip(steps, own.shape[::-1], strict=True)):
        raise InputError("a patch names nodes that its block does not have")
    return own[np.ix_(steps[1], steps[0])]


def join(
    places: Sequence[FloatArray], shared: Sequence[tuple[Range, Range, bool]], shapes: Sequence[tuple[int, int, int]]
) -> tuple[FloatArray, list[IntArray]]:
    """Points of blocks that share rectangles, each once, and the blocks' nodes (nk + 1, nj + 1, ni + 1).

    Parameters
    ----------
    places : sequence of (n, 3) float64
        Points of every block, i running fastest.
    shared : sequence of (Range, Range, bool)
        The same nodes in two sides; whether the directions change places.
    shapes : sequence of (int, int, int)
        Nodes along i, j, k.
    """
    first = np.concatenate([[0], np.cumsum([len(own) for own in places])])
    nodes = [np.arange(first[j], first[j + 1]).reshape(shape[::-1]) for j, shape in enumerate(shapes)]
    pairs = [np.empty((2, 0), dtype=np.int64)]
    for one, other, swapped in shared:
        if max(one.block, other.block) >= len(nodes):
            raise InputError("a patch names a block that is not there")
        ends = along(nodes[one.block], one), along(nodes[other.block], other)
        second = ends[1].T if swapped else ends[1]
        if ends[0].shape != second.shape:
            raise InputError("two patches that meet have not as many nodes")
        pairs.append(np.stack([ends[0].ravel(), second.ravel()]))
    n = int(first[-1])
    both = np.concatenate(pairs, axis=1)
    graph = scipy.sparse.coo_array((np.ones(both.shape[1]), both), shape=(n, n))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    _, kept, number = np.unique(label, return_index=True, return_inverse=True)
    order = np.argsort(kept)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    every = np.concatenate(places)
    return every[kept[order]], [rank[number[own]] for own in nodes]


def joined_mesh(
    points: FloatArray,
    nodes: Sequence[IntArray],
    named: Sequence[tuple[str, Range]],
    parts: Sequence[str],
) -> HexMesh:
    """The mesh of blocks whose nodes are joined, their named rectangles, and the part of each."""
    hexes = [grid_hexes(own) for own in nodes]
    boundaries: dict[str, list[IntArray]] = {}
    for name, part in named:
        along(nodes[part.block], part)
        boundaries.setdefault(name, []).append(side_quads(nodes[part.block], part))
    first = np.concatenate([[0], np.cumsum([len(own) for own in hexes])])
    own_parts: dict[str, list[IntArray]] = {}
    for j, name in enumerate(parts):
        own_parts.setdefault(name, []).append(np.arange(first[j], first[j + 1]))
    return HexMesh(
        points=points,
        hexes=np.concatenate(hexes),
        boundaries={name: np.concatenate(quads) for name, quads in boundaries.items()},
        parts={name: np.concatenate(ids) for name, ids in own_parts.items()},
    )
