"""Does a mesh run into itself? Boundary quads that cross each other, and solids inside one another.

Place in the flow: called by :func:`cadsweep.quality.check.check_surface`, and by the pipeline on finer facets of the
CAD faces, to find out whether it is the model that crosses itself.

Method. Where all Jacobians are positive, the mesh of a connected solid overlaps itself nowhere if its boundary does not
cross itself; of several, if besides none lies inside another. The boundary's bilinear quads are looked at exactly: a
tree of boxes leaves the pairs that are near, planes part nearly all of these, and quads that no plane parts are cut in
four until planes part the pieces, or they are too small to tell. No pair is called apart without proof. Before, every
node is moved a hair's breadth into the hexahedra, and a tenth of that at random: sheets that touch from outside then
keep apart, and sheets that touch from inside (a wall flush with another's, an edge on the inside of a face) cross as
sheets in general position do. The closed pieces of the boundary are nested as they must be where the winding number of
all of them together is one on the side of the hexahedra and none on the other.

Order 2: each quad counts as `FACETS` x `FACETS` bilinear ones; what crosses less deep than these lie off the
curved quad is not seen.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray, distinct, limits
from ..threads import map_chunks
from . import overlap_kernels as kernels
from .hulls import crossing_pairs

FACETS = 4
"""Bilinear facets a direction that stand for a quad of order 2."""

MOST_PAIRS = 32
"""Crossing pairs that are looked for among `LEAVES` leaves: where a mesh runs into itself, some of them say so."""

LEAVES = 1024
"""Leaves of the tree that a thread works on at once."""

MOST_NEAR = 2**16
"""Pairs of near quads that are kept at once; of sound meshes some hundred leaves have fewer."""

HAIR = 1e-8
"""How far nodes are moved inward, over the size of the boundary: a hundredth of what a node may be off its CAD face."""

TOLERANCE = 1e-3
"""Overlap up to which hulls count as apart, over the hair's breadth: a hundredth of the random part of a move."""

MOST_SHOWN = 3
"""Crossings that become sentences."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BoundaryCrossing:
    """Where two boundaries, or two parts of one, cross each other.

    Attributes
    ----------
    names : (str, str)
        Equal where one boundary crosses itself.
    n_pairs : int
        Pairs of quads that were found to cross; there may be more.
    place : (float, float, float)
        Where one of the pairs crosses.
    corners : (p, 2, 4, 3) float64
        Corners of the crossing quads, pair by pair.
    """

    names: tuple[str, str]
    n_pairs: int
    place: tuple[float, float, float]
    corners: FloatArray

    def __str__(self) -> str:
        one, other = self.names
        where = "(" + ", ".join(f"{c:.5g}" for c in self.place) + ")"
        who = f"'{one}' crosses itself" if one == other else f"'{one}' and '{other}' cross each other"
        return f"{who} at {where}" + (f" and at least {self.n_pairs - 1} more places" if self.n_pairs > 1 else "")


def find_crossings(points: FloatArray, quads: IntArray) -> tuple[IntArray, FloatArray]:
    """Find pairs of quads that cross each other: some of them, where there are many, and none where there is none.

    Parameters
    ----------
    points : (n, 3) float64
        Quads with a node that is not finite are left out.
    quads : (q, 4), (q, 8) or (q, 9) int64

    Returns
    -------
    pairs : (p, 2) int64
        Rows of `quads`, the lesser first, each pair once.
    places : (p, 3) float64
        A point where the pair crosses.
    """
    nodes = distinct(quads)
    own = points.take(nodes, axis=0)
    rows: IntArray | None = None
    if not np.isfinite(own).all():
        rows = np.flatnonzero(np.isfinite(points[quads]).all(axis=(1, 2)))
        quads = quads[rows]
        nodes = distinct(quads)
        own = points.take(nodes, axis=0)
    if len(quads) < 2:
        return np.zeros((0, 2), dtype=np.int64), np.zeros((0, 3))
    number = np.empty(len(points), dtype=np.int64)
    number[nodes] = np.arange(len(nodes))
    low, high = limits(own)
    # Coordinates are no better than their rounding: far from the origin a hair is wider.
    rounding = 64.0 * np.finfo(np.float64).eps * float(np.abs([low, high]).max())
    hair = max(HAIR * float(np.linalg.norm(high - low)), rounding / TOLERANCE)
    numbered = number.take(quads)
    owners, moved, facets = _facets(_moved_inward(own - low, numbered, hair), numbered)
    owners = owners if rows is None else rows[owners]
    order = _order_on_curve(moved, facets, high - low)
    corners = moved.take(facets.take(order, axis=0), axis=0)
    tolerance = TOLERANCE * hair
    boxes, own_boxes = _box_tree(corners)

    def search(leaves: slice) -> tuple[IntArray, FloatArray]:
        found, places, n_found = [np.zeros((0, 2), dtype=np.int64)], [np.zeros((0, 3))], 0
        waiting = [(leaves.start, leaves.stop)]
        while waiting and n_found < MOST_PAIRS:
            first, last = waiting.pop()
            near, count = _near_pairs(corners, (boxes, own_boxes), (first, last), tolerance)
            if count > len(near):  # a heap of hexahedra: half as many leaves at a time, until some of them are crossing
                middle = (first + last) // 2
                waiting += [(middle, last), (first, middle)]
                continue
            crossing, at = crossing_pairs(corners, near[:count], tolerance=tolerance, close=4 * hair, most=MOST_PAIRS)
            found.append(crossing)
            places.append(at)
            n_found += len(crossing)
        return np.concatenate(found), np.concatenate(places)

    n_leaves = -(-len(corners) // kernels.LEAF)
    results = list(map_chunks(search, n_leaves, chunk=LEAVES))
    pairs = np.sort(owners[order[np.concatenate([found for found, _ in results])]], axis=1)
    places = np.concatenate([found for _, found in results]) + low
    apart = pairs[:, 0] != pairs[:, 1]
    pairs, first = np.unique(pairs[apart], axis=0, return_index=True)
    return pairs, places[apart][first]


def _near_pairs(
    corners: FloatArray, trees: tuple[FloatArray, FloatArray], leaves: tuple[int, int], tolerance: float
) -> tuple[IntArray, int]:
    """Pairs that are near, and their number: one more than there is room for where there are more than `MOST_NEAR`."""
    near, count = np.empty((0, 2), dtype=np.int64), 1
    everything = len(corners) * kernels.LEAF  # as many pairs as one leaf can have
    for room in (256, MOST_NEAR, *([everything] if leaves[1] - leaves[0] == 1 else [])):
        if count > len(near):
            near = np.empty((room, 2), dtype=np.int64)
            count = kernels.find_pairs(corners, *trees, *leaves, tolerance, near)
    return near, count


def describe_crossings(
    points: FloatArray, quads: IntArray, boundaries: Mapping[str, IntArray], pairs: IntArray, places: FloatArray
) -> tuple[BoundaryCrossing, ...]:
    """Sort crossing pairs of quads by the boundaries that they belong to, the most frequent first.

    Parameters
    ----------
    points : (n, 3) float64
    quads : (q, 4 or more) int64
    boundaries : mapping of name to (b, 4 or more) int64
        A quad in several goes by the first; one in none by ``boundary``.
    pairs, places
        As :func:`find_crossings` returns them.
    """
    if not len(pairs):
        return ()
    wanted = distinct(pairs)
    names = dict.fromkeys(wanted.tolist(), "boundary")
    by_nodes = {tuple(sorted(quads[i, :4].tolist())): i for i in wanted.tolist()}
    involved = np.zeros(len(points), dtype=np.bool_)
    involved[quads[wanted, :4]] = True
    for name, own in reversed(list(boundaries.items())):
        for quad in own[involved[own[:, :4]].all(axis=1), :4].tolist():
            at = by_nodes.get(tuple(sorted(quad)))
            if at is not None:
                names[at] = name
    groups: dict[tuple[str, str], list[int]] = {}
    for row, (i, j) in enumerate(pairs.tolist()):
        one, other = sorted((names[i], names[j]))
        groups.setdefault((one, other), []).append(row)
    found = [
        BoundaryCrossing(
            names=key,
            n_pairs=len(rows),
            place=(float(places[rows[0], 0]), float(places[rows[0], 1]), float(places[rows[0], 2])),
            corners=points[quads[pairs[rows], :4]],
        )
        for key, rows in groups.items()
    ]
    return tuple(sorted(found, key=lambda one: -one.n_pairs))


def crossing_problems(crossings: tuple[BoundaryCrossing, ...]) -> list[str]:
    """Say where a mesh runs into itself, a sentence in all."""
    if not crossings:
        return []
    more = "" if len(crossings) <= MOST_SHOWN else f", and {len(crossings) - MOST_SHOWN} more pairs of boundaries"
    return ["the mesh runs into itself: " + "; ".join(str(one) for one in crossings[:MOST_SHOWN]) + more]


def nesting_problems(points: FloatArray, quads: IntArray) -> list[str]:
    """Find closed pieces of a boundary, none crossing another, that lie where they cannot: solid within solid.

    Parameters
    ----------
    points : (n, 3) float64
    quads : (q, 4) int64
        Closed surfaces, outward.
    """
    label = np.empty(len(points), dtype=np.int64)
    kernels.label_pieces(quads, label)
    piece_of_quad = label[quads[:, 0]]
    if np.all(piece_of_quad == piece_of_quad[:1]):
        return []
    pieces = distinct(piece_of_quad)
    corners = {int(p): np.ascontiguousarray(points[quads[piece_of_quad == p]]) for p in pieces}
    boxes = {p: (c.min(axis=(0, 1)), c.max(axis=(0, 1))) for p, c in corners.items()}
    problems = []
    for p, own in corners.items():
        center = own.mean(axis=(0, 1))
        around = [
            other
            for q, other in corners.items()
            if q != p and np.all(boxes[q][0] <= boxes[p][1]) and np.all(boxes[p][0] <= boxes[q][1])
        ]
        # A node may lie between a warped quad and the triangles that stand for it: three nodes are asked.
        nodes_asked = own[[0, len(own) // 3, 2 * len(own) // 3], 0]
        winding = [round(sum(_winding(c, node) for c in around)) for node in nodes_asked]
        n_around = int(np.median(winding))
        outward = _signed_volume(own - center) > 0
        if n_around != (0 if outward else 1):
            where = "(" + ", ".join(f"{c:.5g}" for c in own[0, 0]) + ")"
            piece = f"the boundary's piece of {len(own)} quads at {where}"
            problems.append(
                f"hexahedra lie inside others: {piece} is inside another one"
                if outward
                else f"{piece} turns inward, and no hexahedra are around it"
            )
    return problems[:MOST_SHOWN]


def _winding(corners: FloatArray, point: FloatArray) -> float:
    """How often quads (q, 4, 3), each as two triangles, wind around a point (3,): their solid angles over 4 pi."""
    total = 0.0
    rays = corners - point
    for a, b, c in ((rays[:, 0], rays[:, 1], rays[:, 2]), (rays[:, 0], rays[:, 2], rays[:, 3])):
        la, lb, lc = (np.linalg.norm(ray, axis=1) for ray in (a, b, c))
        below = la * lb * lc + np.sum(a * b, axis=1) * lc + np.sum(b * c, axis=1) * la + np.sum(c * a, axis=1) * lb
        total += float(np.sum(2.0 * np.arctan2(np.sum(a * np.cross(b, c), axis=1), below)))
    return total / (4.0 * np.pi)


def _signed_volume(corners: FloatArray) -> float:
    """Volume inside quads (q, 4, 3), each as two triangles."""
    a, b, c, d = (corners[:, i] for i in range(4))
    return float(np.sum(np.einsum("ij,ij->i", a, np.cross(b, c)) + np.einsum("ij,ij->i", a, np.cross(c, d)))) / 6.0


def _moved_inward(points: FloatArray, quads: IntArray, step: float) -> FloatArray:
    """Nodes (n, 3) of outward quads, moved a step against the normal there and a tenth of it at random."""
    normals, moved = np.zeros_like(points), points.copy()
    kernels.add_normals(points, quads, normals)
    kernels.move_inward(moved, normals, step, np.random.default_rng(1).uniform(-0.1 * step, 0.1 * step, points.shape))
    return moved


def _order_on_curve(points: FloatArray, quads: IntArray, extent: FloatArray) -> IntArray:
    """Quads (q, 4) in a box from 0 to `extent` as they come along a space-filling curve of 2**20 cells a side."""
    code = np.empty(len(quads), dtype=np.int64)
    kernels.fill_places(points, quads, (2**20 - 1) / 4 / np.where(extent > 0, extent, 1.0), code)
    bits = len(quads).bit_length()
    # Where they stand in the bits that matter least: a sort of values takes a tenth of what one of places does.
    return np.sort((code >> bits << bits) | np.arange(len(quads))) & ((1 << bits) - 1)


def _box_tree(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Boxes (2 n, 6) of a complete binary tree of n leaves over sorted quads (q, 4, 3), and the quads' own (q, 6)."""
    own = np.empty((len(corners), 6))
    n = 1 << max(0, (len(corners) - 1) // kernels.LEAF).bit_length()
    boxes = np.empty((2 * n, 6))
    kernels.fill_boxes(corners, own, boxes)
    return boxes, own


def _facets(points: FloatArray, quads: IntArray) -> tuple[IntArray, FloatArray, IntArray]:
    """Bilinear facets of quads (q, 4, 8 or 9): the row that each stands for (f,), their points, and nodes (f, 4)."""
    if quads.shape[1] == 4:
        return np.arange(len(quads)), points, quads
    nodes = points[quads]
    n_quads = len(nodes)
    if nodes.shape[1] == 8:  # the serendipity quad is the one whose centre follows from its rim
        centers = nodes[:, 4:].sum(axis=1) / 2 - nodes[:, :4].sum(axis=1) / 4
        nodes = np.concatenate([nodes, centers[:, None]], axis=1)
    grid = nodes[:, [[0, 4, 1], [7, 8, 5], [3, 6, 2]]]
    t = np.linspace(0.0, 1.0, FACETS + 1)
    shape = np.stack([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)], axis=1)
    fine = np.einsum("ja,ib,qabc->qjic", shape, shape, grid, optimize=True)
    cells = [fine[:, :-1, :-1], fine[:, :-1, 1:], fine[:, 1:, 1:], fine[:, 1:, :-1]]
    corners = np.stack(cells, axis=3).reshape(-1, 3)
    return np.repeat(np.arange(n_quads), FACETS**2), corners, np.arange(len(corners)).reshape(-1, 4)
