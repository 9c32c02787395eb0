"""Compiled loops that find bilinear quads which cross each other: a tree of boxes, and separating axes.

Place in the flow: the inner loops of :mod:`cadsweep.quality.overlap`. The tree is implicit: quads sorted along a
space-filling curve, `LEAF` to a leaf; leaf j of a complete binary tree at ``n_leaves + j``, the children of i at 2 i
and 2 i + 1.
"""

from __future__ import annotations

import numpy as np
from numba import njit

_njit = njit(cache=True, error_model="numpy", nogil=True)

LEAF = 4
"""Quads of a leaf."""

MOST_PIECES = 1000
"""Pairs of pieces of two quads that are looked at before the quads count as crossing: they could not be told apart."""

MOST_HALVINGS = 6
"""How often each of two quads is cut in four before pieces that are not apart count as crossing."""


@_njit
def move_inward(points, quads, origin, step, jitter, nodes):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Fill nodes (q, 4 or more, 3), from the origin: those of outward quads, moved a step inward and one at random."""
    n, width = quads.shape
    normals = np.zeros(points.shape)
    for q in range(n):
        a, b, c, d = quads[q, 0], quads[q, 1], quads[q, 2], quads[q, 3]
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            normal = (points[c, y] - points[a, y]) * (points[d, z] - points[b, z])
            normal -= (points[c, z] - points[a, z]) * (points[d, y] - points[b, y])
            for i in range(width):
                normals[quads[q, i], x] += normal
    for q in range(n):
        for i in range(width):
            node = quads[q, i]
            length = np.sqrt(normals[node, 0] ** 2 + normals[node, 1] ** 2 + normals[node, 2] ** 2)
            scale = step / length if length > 0.0 else 0.0
            for x in range(3):
                # splitmix64 of the node's number: the same move wherever the node is met.
                h = np.uint64(3 * node + x) + np.uint64(0x9E3779B97F4A7C15)
                h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
                h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
                h = (h ^ (h >> np.uint64(31))) >> np.uint64(11)
                move = jitter * (2.0 * (np.float64(h) / 9007199254740992.0) - 1.0)
                nodes[q, i, x] = points[node, x] - origin[x] - normals[node, x] * scale + move


@_njit
def measure_box(points, quads, box):  # type: ignore[no-untyped-def]
    """Fill box (2, 3) with the least and largest coordinates of quads; whether all are finite."""
    box[0], box[1] = np.inf, -np.inf
    for q in range(quads.shape[0]):
        for i in range(quads.shape[1]):
            for x in range(3):
                c = points[quads[q, i], x]
                if not np.isfinite(c):
                    return False
                box[0, x] = min(box[0, x], c)
                box[1, x] = max(box[1, x], c)
    return True


@_njit
def place_on_curve(corners, low, scale, codes):  # type: ignore[no-untyped-def]
    """Fill codes (q,): where the centres of quads (q, 4, 3) come along a space-filling curve of 2**20 cells a side."""
    for q in range(corners.shape[0]):
        code = np.int64(0)
        for axis in range(3):
            center = 0.25 * (corners[q, 0, axis] + corners[q, 1, axis] + corners[q, 2, axis] + corners[q, 3, axis])
            x = np.int64(min(max((center - low[axis]) * scale[axis], 0.0), 1048575.0))
            x = (x | (x << 32)) & 0x1F00000000FFFF
            x = (x | (x << 16)) & 0x1F0000FF0000FF
            x = (x | (x << 8)) & 0x100F00F00F00F00F
            x = (x | (x << 4)) & 0x10C30C30C30C30C3
            x = (x | (x << 2)) & 0x1249249249249249
            code |= x << axis
        codes[q] = code


@_njit
def build_boxes(corners, n_leaves, boxes, leaf_boxes):  # type: ignore[no-untyped-def]
    """Fill the boxes (2 n_leaves, 6) of a tree and those (q, 6) of its quads, given by corners (q, 4, 3), sorted."""
    n = corners.shape[0]
    for q in range(n):
        for x in range(3):
            least = largest = corners[q, 0, x]
            for i in range(1, 4):
                least = min(least, corners[q, i, x])
                largest = max(largest, corners[q, i, x])
            leaf_boxes[q, x] = least
            leaf_boxes[q, 3 + x] = largest
    for j in range(n_leaves):
        for x in range(3):
            least, largest = np.inf, -np.inf
            for q in range(j * LEAF, min(n, (j + 1) * LEAF)):
                least = min(least, leaf_boxes[q, x])
                largest = max(largest, leaf_boxes[q, 3 + x])
            boxes[n_leaves + j, x] = least
            boxes[n_leaves + j, 3 + x] = largest
    for i in range(n_leaves - 1, 0, -1):
        for x in range(3):
            boxes[i, x] = min(boxes[2 * i, x], boxes[2 * i + 1, x])
            boxes[i, 3 + x] = max(boxes[2 * i, 3 + x], boxes[2 * i + 1, 3 + x])


@_njit
def _overlap(one, i, other, j):  # type: ignore[no-untyped-def]
    return (
        one[i, 0] <= other[j, 3]
        and one[i, 3] >= other[j, 0]
        and one[i, 1] <= other[j, 4]
        and one[i, 4] >= other[j, 1]
        and one[i, 2] <= other[j, 5]
        and one[i, 5] >= other[j, 2]
    )


@_njit
def find_pairs(corners, boxes, leaf_boxes, first, last, tolerance, close, found, places):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917
    """Find the crossing pairs of the quads in leaves `first` to `last` with quads that come after them.

    Hulls that overlap by no more than the tolerance are apart; corners nearer than `close` were in one place before all
    nodes were moved. Fills found (most, 2) and places (most, 3), and stops when they are full; returns how many there
    are.
    """
    n, n_leaves = corners.shape[0], boxes.shape[0] // 2
    stack = np.empty(128, dtype=np.int64)
    place, axis = np.empty(3), np.empty(3)
    count = 0
    for leaf in range(first, last):
        own = n_leaves + leaf
        top = 0
        # The leaves after this one: itself, and the right sibling of every left child on the way up.
        stack[0] = own
        top = 1
        i = own
        while i > 1:
            if i & 1 == 0:
                stack[top] = i + 1
                top += 1
            i >>= 1
        while top:
            top -= 1
            node = stack[top]
            if not _overlap(boxes, own, boxes, node):
                continue
            if node < n_leaves:
                stack[top] = 2 * node
                stack[top + 1] = 2 * node + 1
                top += 2
                continue
            begin = (node - n_leaves) * LEAF
            for a in range(leaf * LEAF, min(n, (leaf + 1) * LEAF)):
                if node != own and not _overlap(leaf_boxes, a, boxes, node):
                    continue
                for b in range(a + 1 if node == own else begin, min(n, begin + LEAF)):
                    if not _overlap(leaf_boxes, a, leaf_boxes, b) or _side_by_side(corners, a, b, tolerance, axis):
                        continue
                    if not _back_to_back(corners, a, b, close) and _cross(corners, a, b, tolerance, place):
                        found[count, 0], found[count, 1] = a, b
                        for x in range(3):
                            places[count, x] = place[x]
                        count += 1
                        if count == found.shape[0]:
                            return count
    return count


@_njit
def _side_by_side(corners, a, b, tolerance, m):  # type: ignore[no-untyped-def]
    """Whether a plane across the way `m` between their centres parts two quads: true of nearly all neighbours."""
    for x in range(3):
        m[x] = 0.0
        for i in range(4):
            m[x] += corners[b, i, x] - corners[a, i, x]
    # An edge in common: the plane goes through it.
    first = -1
    for i in range(4):
        for j in range(4):
            if (
                corners[a, i, 0] == corners[b, j, 0]
                and corners[a, i, 1] == corners[b, j, 1]
                and corners[a, i, 2] == corners[b, j, 2]
            ):
                if first < 0:
                    first = i
                else:
                    square, along = 0.0, 0.0
                    for x in range(3):
                        e = corners[a, i, x] - corners[a, first, x]
                        square += e * e
                        along += m[x] * e
                    if square > 0.0:
                        for x in range(3):
                            m[x] -= along / square * (corners[a, i, x] - corners[a, first, x])
                break
    return _apart_along(corners, a, corners, b, m, tolerance)


@_njit
def _apart_along(ones, a, others, b, m, tolerance):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Whether the shadows of the quads ones[a] and others[b] on an axis overlap by no more than the tolerance."""
    square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2]
    if square == 0.0:
        return False
    least, largest, low, high = 0.0, 0.0, np.inf, -np.inf
    for i in range(4):
        s, t = 0.0, 0.0
        for x in range(3):
            s += (ones[a, i, x] - ones[a, 0, x]) * m[x]
            t += (others[b, i, x] - ones[a, 0, x]) * m[x]
        least, largest = min(least, s), max(largest, s)
        low, high = min(low, t), max(high, t)
    return min(largest - low, high - least) <= tolerance * np.sqrt(square)


@_njit
def _hulls_apart(ones, a, others, b, tolerance):  # type: ignore[no-untyped-def]  # noqa: PLR0912
    """Whether the hulls of the corners of ones[a] and others[b] are apart; complete for tetrahedra and flat quads."""
    # Rows 0 to 5: edges and diagonals of one, 7 to 12 of the other; 6 and 13: their normals, from the diagonals.
    edges = np.empty((14, 3))
    k = 0
    for i in range(4):
        for j in range(i):
            for x in range(3):
                edges[k, x] = ones[a, i, x] - ones[a, j, x]
                edges[7 + k, x] = others[b, i, x] - others[b, j, x]
            k += 1
    for base in (0, 7):
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            edges[base + 6, x] = edges[base + 1, y] * edges[base + 4, z] - edges[base + 1, z] * edges[base + 4, y]
    # Two edges of one: a face of its tetrahedron; an edge and the normal: a side of a flat quad; else an edge of each.
    axis = np.empty(3)
    for i in (6, 13):
        for x in range(3):
            axis[x] = edges[i, x]
        if _apart_along(ones, a, others, b, axis, tolerance):
            return True
    for i in range(14):
        for j in range(i):
            if (i > 6 and j == 6) or (i == 13 and j < 7):  # a normal goes with edges of its own quad
                continue
            for x in range(3):
                y, z = (x + 1) % 3, (x + 2) % 3
                axis[x] = edges[i, y] * edges[j, z] - edges[i, z] * edges[j, y]
            if _apart_along(ones, a, others, b, axis, tolerance):
                return True
    return False


@_njit
def _cross(corners, a, b, tolerance, place):  # type: ignore[no-untyped-def]
    """Whether two bilinear quads, rows of corners (q, 4, 3), cross; fills the place where.

    A quad lies in the hull of its corners. Where two hulls are not apart, both quads are cut in four, and the pieces
    asked again: hulls of pieces lie ever closer on the quads, also beside an edge or a corner in common.
    """
    size = 16 * (MOST_HALVINGS + 1)
    first, second = np.empty((size, 4, 3)), np.empty((size, 4, 3))
    depth = np.empty(size, dtype=np.int64)
    pieces, others = np.empty((4, 4, 3)), np.empty((4, 4, 3))
    for i in range(4):
        for x in range(3):
            first[0, i, x], second[0, i, x] = corners[a, i, x], corners[b, i, x]
    depth[0] = 0
    top, looked = 1, 0
    while top:
        top -= 1
        if _hulls_apart(first, top, second, top, tolerance):
            continue
        looked += 1
        level = depth[top]
        if level == MOST_HALVINGS or looked > MOST_PIECES:
            for x in range(3):
                place[x] = 0.0
                for i in range(4):
                    place[x] += (first[top, i, x] + second[top, i, x]) / 8
            return True
        _quarter(first, top, pieces)
        _quarter(second, top, others)
        for both in range(16):
            for i in range(4):
                for x in range(3):
                    first[top, i, x], second[top, i, x] = pieces[both >> 2, i, x], others[both & 3, i, x]
            depth[top] = level + 1
            top += 1
    return False


@_njit
def _quarter(quads, q, pieces):  # type: ignore[no-untyped-def]
    """Fill the four pieces (4, 4, 3) of a bilinear quad of quads (n, 4, 3), cut in the middle of its parameters."""
    for x in range(3):
        centre = 0.25 * (quads[q, 0, x] + quads[q, 1, x] + quads[q, 2, x] + quads[q, 3, x])
        for i in range(4):
            pieces[i, 0, x] = quads[q, i, x]
            pieces[i, 1, x] = 0.5 * (quads[q, i, x] + quads[q, (i + 1) & 3, x])
            pieces[i, 2, x] = centre
            pieces[i, 3, x] = 0.5 * (quads[q, i, x] + quads[q, (i + 3) & 3, x])


@_njit
def _back_to_back(corners, a, b, close):  # type: ignore[no-untyped-def]
    """Whether two quads have the same corners the other way round, as the two sides of a contact do."""
    for shift in range(4):
        met = 0
        for i in range(4):
            square = 0.0
            for x in range(3):
                square += (corners[a, i, x] - corners[b, (shift - i) & 3, x]) ** 2
            met += square <= close * close
        if met == 4:
            return True
    return False


@_njit
def label_pieces(quads, n_nodes, parent):  # type: ignore[no-untyped-def]
    """Fill parent (n_nodes,): a node that stands for all that hang together with each, over quads that share nodes."""
    for i in range(n_nodes):
        parent[i] = i
    for q in range(quads.shape[0]):
        a = quads[q, 0]
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        for i in range(1, 4):
            b = quads[q, i]
            while parent[b] != b:
                parent[b] = parent[parent[b]]
                b = parent[b]
            if a < b:
                parent[b] = a
            elif b < a:
                parent[a] = b
                a = b
    for i in range(n_nodes):
        a = parent[i]
        while parent[a] != a:
            a = parent[a]
        parent[i] = a


@_njit
def solid_angle(corners, point):  # type: ignore[no-untyped-def]
    """How often quads (q, 4, 3), each as two triangles, wind around a point (3,): their solid angles over 4 pi."""
    total = 0.0
    r = np.empty((4, 3))
    length = np.empty(4)
    for q in range(corners.shape[0]):
        for i in range(4):
            square = 0.0
            for x in range(3):
                r[i, x] = corners[q, i, x] - point[x]
                square += r[i, x] * r[i, x]
            length[i] = np.sqrt(square)
        for half in range(2):
            b, c = 1 + half, 2 + half
            volume = (
                r[0, 0] * (r[b, 1] * r[c, 2] - r[b, 2] * r[c, 1])
                + r[0, 1] * (r[b, 2] * r[c, 0] - r[b, 0] * r[c, 2])
                + r[0, 2] * (r[b, 0] * r[c, 1] - r[b, 1] * r[c, 0])
            )
            ab = r[0, 0] * r[b, 0] + r[0, 1] * r[b, 1] + r[0, 2] * r[b, 2]
            bc = r[b, 0] * r[c, 0] + r[b, 1] * r[c, 1] + r[b, 2] * r[c, 2]
            ca = r[c, 0] * r[0, 0] + r[c, 1] * r[0, 1] + r[c, 2] * r[0, 2]
            below = length[0] * length[b] * length[c] + ab * length[c] + bc * length[0] + ca * length[b]
            total += 2.0 * np.arctan2(volume, below)
    return total / (4.0 * np.pi)
