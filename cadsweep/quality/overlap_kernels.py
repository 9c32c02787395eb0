"""Compiled loops that find quads near each other: a tree of boxes, and a first look at what is in it.

Place in the flow: the inner loops of :mod:`cadsweep.quality.overlap`. The tree is implicit: quads sorted along a
space-filling curve, `LEAF` to a leaf; leaf j of a complete binary tree at ``n_leaves + j``, the children of i at 2 i
and 2 i + 1.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

_compiled = compiled(cache=True, error_model="numpy", nogil=True)

LEAF = 4
"""Quads of a leaf."""


@_compiled
def _overlap(one, i, other, j):  # type: ignore[no-untyped-def]
    return (
        one[i, 0] <= other[j, 3]
        and one[i, 3] >= other[j, 0]
        and one[i, 1] <= other[j, 4]
        and one[i, 4] >= other[j, 1]
        and one[i, 2] <= other[j, 5]
        and one[i, 5] >= other[j, 2]
    )


@_compiled
def add_normals(points, quads, normals):  # type: ignore[no-untyped-def]
    """Add to normals (n, 3), which holds zeros, the area vectors of all quads (q, 4 or more) at a node (twice each)."""
    for q in range(quads.shape[0]):
        a, b, c, d = quads[q, 0], quads[q, 1], quads[q, 2], quads[q, 3]
        x0, x1, x2 = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        y0, y1, y2 = points[d, 0] - points[b, 0], points[d, 1] - points[b, 1], points[d, 2] - points[b, 2]
        n0, n1, n2 = x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0
        for i in range(quads.shape[1]):
            node = quads[q, i]
            normals[node, 0] += n0
            normals[node, 1] += n1
            normals[node, 2] += n2


@_compiled
def move_inward(points, normals, step, jitter):  # type: ignore[no-untyped-def]
    """Move points (n, 3) a step against their normals, of any length, and by their jitter (n, 3)."""
    for i in range(points.shape[0]):
        x, y, z = normals[i, 0], normals[i, 1], normals[i, 2]
        length = np.sqrt(x * x + y * y + z * z)
        share = step / length if length > 0.0 else 0.0
        for c in range(3):
            points[i, c] = points[i, c] - normals[i, c] * share + jitter[i, c]


@_compiled
def fill_places(points, quads, scale, code):  # type: ignore[no-untyped-def]
    """Fill code (q,): the bits of the sums of quads' four corners, times scale (3,), one axis after the other."""
    for q in range(quads.shape[0]):
        place = np.int64(0)
        a, b, c, d = quads[q, 0], quads[q, 1], quads[q, 2], quads[q, 3]
        for axis in range(3):
            middle = points[a, axis] + points[b, axis] + points[c, axis] + points[d, axis]
            x = np.int64(min(max(middle * scale[axis], 0.0), 1048575.0))
            # Two zeros between one bit and the next.
            x = (x | (x << 32)) & 0x1F00000000FFFF
            x = (x | (x << 16)) & 0x1F0000FF0000FF
            x = (x | (x << 8)) & 0x100F00F00F00F00F
            x = (x | (x << 4)) & 0x10C30C30C30C30C3
            x = (x | (x << 2)) & 0x1249249249249249
            place |= x << axis
        code[q] = place


@_compiled
def fill_boxes(corners, own, boxes):  # type: ignore[no-untyped-def]
    """Fill own (q, 6), limits of every quad (q, 4, 3), and boxes (2 n, 6) of the tree's nodes."""
    n = boxes.shape[0] // 2
    for i in range(2 * n):
        for x in range(3):
            boxes[i, x], boxes[i, 3 + x] = np.inf, -np.inf
    for q in range(corners.shape[0]):
        leaf = n + q // LEAF
        for x in range(3):
            a, b, c, d = corners[q, 0, x], corners[q, 1, x], corners[q, 2, x], corners[q, 3, x]
            low, high = min(a, b, c, d), max(a, b, c, d)
            own[q, x], own[q, 3 + x] = low, high
            boxes[leaf, x], boxes[leaf, 3 + x] = min(boxes[leaf, x], low), max(boxes[leaf, 3 + x], high)
    for i in range(n - 1, 0, -1):
        for x in range(3):
            boxes[i, x] = min(boxes[2 * i, x], boxes[2 * i + 1, x])
            boxes[i, 3 + x] = max(boxes[2 * i, 3 + x], boxes[2 * i + 1, 3 + x])


@_compiled
def find_pairs(corners, boxes, leaf_boxes, first, last, tolerance, found):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Find the quads in leaves `first` to `last`, and quads after them, that are near and not plainly side by side.

    Fills found (most, 2) and returns how many there are; where there are more, it stops there and returns most + 1.
    """
    n, n_leaves = corners.shape[0], boxes.shape[0] // 2
    stack = np.empty(128, dtype=np.int64)
    count = 0
    for leaf in range(first, last):
        own = n_leaves + leaf
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
                if not _overlap(leaf_boxes, a, boxes, node):
                    continue
                for b in range(max(a + 1, begin), min(n, begin + LEAF)):
                    if _overlap(leaf_boxes, a, leaf_boxes, b) and not _side_by_side(corners, a, b, tolerance):
                        if count == found.shape[0]:
                            return count + 1
                        found[count, 0] = a
                        found[count, 1] = b
                        count += 1
    return count


@_compiled
def _side_by_side(corners, a, b, tolerance):  # type: ignore[no-untyped-def]
    """Whether a plane across the way between their centres parts two quads: true of nearly all neighbours."""
    m0, m1, m2 = 0.0, 0.0, 0.0
    for i in range(4):
        m0 += corners[b, i, 0] - corners[a, i, 0]
        m1 += corners[b, i, 1] - corners[a, i, 1]
        m2 += corners[b, i, 2] - corners[a, i, 2]
    # An edge in common: the plane goes through it.
    first = -1
    for i in range(4):
        p0, p1, p2 = corners[a, i, 0], corners[a, i, 1], corners[a, i, 2]
        for j in range(4):
            if p0 == corners[b, j, 0] and p1 == corners[b, j, 1] and p2 == corners[b, j, 2]:
                if first < 0:
                    first = i
                    continue
                e0, e1, e2 = p0 - corners[a, first, 0], p1 - corners[a, first, 1], p2 - corners[a, first, 2]
                share = (m0 * e0 + m1 * e1 + m2 * e2) / (1e-300 + e0 * e0 + e1 * e1 + e2 * e2)
                m0 -= share * e0
                m1 -= share * e1
                m2 -= share * e2
    o0, o1, o2 = corners[a, 0, 0], corners[a, 0, 1], corners[a, 0, 2]
    largest, low = 0.0, np.inf
    for i in range(4):
        s = (corners[a, i, 0] - o0) * m0 + (corners[a, i, 1] - o1) * m1 + (corners[a, i, 2] - o2) * m2
        t = (corners[b, i, 0] - o0) * m0 + (corners[b, i, 1] - o1) * m1 + (corners[b, i, 2] - o2) * m2
        largest, low = max(largest, s), min(low, t)
    square = m0 * m0 + m1 * m1 + m2 * m2
    return largest - low <= tolerance * np.sqrt(square) and square > 0.0


@_compiled
def label_pieces(quads, parent):  # type: ignore[no-untyped-def]
    """Fill parent (n_nodes,): a node that stands for all that hang together with each, over quads that share nodes."""
    for i in range(parent.shape[0]):
        parent[i] = i
    for q in range(quads.shape[0]):
        for i in range(4):
            a, b = quads[q, 0], quads[q, i]
            while parent[a] != a:
                parent[a] = parent[parent[a]]
                a = parent[a]
            while parent[b] != b:
                parent[b] = parent[parent[b]]
                b = parent[b]
            parent[max(a, b)] = min(a, b)
    # A parent has a lesser number: in rising order, it has found its own root already.
    for i in range(parent.shape[0]):
        parent[i] = parent[parent[i]]
