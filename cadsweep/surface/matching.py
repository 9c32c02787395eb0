"""Whether one quad mesh is another one, node for node, when their outlines answer each other.

Place in the flow: ``pipeline`` asks it for cells whose caps are both meshed before the cell is: the source's quads
must land on the target's.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray


def match_quads(quads: IntArray, other: IntArray, known: dict[int, int]) -> dict[int, int] | None:
    """Find the node of the other mesh for every node of the first, going from quad to quad.

    Parameters
    ----------
    quads, other : (q, 4) int64
        Both turned the same way round.
    known : dict of int to int
        Nodes that answer each other already: at least an edge in every connected piece.

    Returns
    -------
    dict of int to int, or None
        None where the meshes are not the same.
    """
    if len(quads) != len(other):
        return None
    found = dict(known)
    sides = [
        {
            (int(a), int(b)): (j, i)
            for j, q in enumerate(m)
            for i, (a, b) in enumerate(zip(q, np.roll(q, -1), strict=True))
        }
        for m in (quads, other)
    ]
    waiting = [edge for edge in sides[0] if edge[0] in found and edge[1] in found]
    done = np.zeros(len(quads), dtype=bool)
    while waiting:
        a, b = waiting.pop()
        place, there = sides[0].get((a, b)), sides[1].get((found[a], found[b]))
        if place is None:
            continue
        if there is None:
            return None
        if done[place[0]]:
            continue
        done[place[0]] = True
        mine, theirs = np.roll(quads[place[0]], -place[1]), np.roll(other[there[0]], -there[1])
        for node, image in zip(mine.tolist(), theirs.tolist(), strict=True):
            if found.setdefault(node, image) != image:
                return None
        waiting += [(int(q), int(p)) for p, q in zip(mine, np.roll(mine, -1), strict=True)]
    return found if done.all() and len(set(found.values())) == len(found) else None
