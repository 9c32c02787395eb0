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
def find_pairs(corners, boxes, leaf_boxes, first, last, tolerance, found):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Find the quads in leaves `first` to `last`, and quads after them, that are near and not plainly side by side.

    Fills found (most, 2) and returns how many there are; where there are more, it stops there and returns most + 1.
    """
    n, n_leaves = corners.shape[0], boxes.shape[0] // 2
    stack = np.empty(128, dtype=np.int64)
    axis = np.empty(3)
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
                for b in range(max(a + 1, begin), min(n, begin + LEAF)):
                    if _overlap(leaf_boxes, a, leaf_boxes, b) and not _side_by_side(corners, a, b, tolerance, axis):
                        if count == found.shape[0]:
                            return count + 1
                        found[count, 0] = a
                        found[count, 1] = b
                        count += 1
    return count


@_compiled
def _side_by_side(corners, a, b, tolerance, m):  # type: ignore[no-untyped-def]
    """Whether a plane across the way `m` between their centres parts two quads: true of nearly all neighbours."""
    for x in range(3):
        m[x] = 0.0
        for i in range(4):
            m[x] += corners[b, i, x] - corners[a, i, x]
    # An edge in common: the plane goes through it.
    first = -1
    for k in range(16):
        i, j = k >> 2, k & 3
        apart = 0.0
        for x in range(3):
            apart += abs(corners[a, i, x] - corners[b, j, x])
        if apart == 0.0:
            if first < 0:
                first = i
            else:
                square, along = 1e-300, 0.0
                for x in range(3):
                    e = corners[a, i, x] - corners[a, first, x]
                    square += e * e
                    along += m[x] * e
                for x in range(3):
                    m[x] -= along / square * (corners[a, i, x] - corners[a, first, x])
    square, largest, low = 0.0, 0.0, np.inf
    for x in range(3):
        square += m[x] * m[x]
    for i in range(4):
        s, t = 0.0, 0.0
        for x in range(3):
            s += (corners[a, i, x] - corners[a, 0, x]) * m[x]
            t += (corners[b, i, x] - corners[a, 0, x]) * m[x]
        largest, low = max(largest, s), min(low, t)
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
