"""Whether one quad mesh is another one, node for node, when their outlines answer each other.

Place in the flow: ``pipeline`` asks it for cells whose caps are both meshed before the cell is: the source's quads
must land on the target's.
"""

from __future__ import annotations

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
    rows, images = quads.tolist(), other.tolist()  # numpy on four numbers at a time would take ten times as long
    sides, sides_there = (
        {(row[i], row[(i + 1) % 4]): (j, i) for j, row in enumerate(m) for i in range(4)} for m in (rows, images)
    )
    waiting = [edge for edge in sides if edge[0] in found and edge[1] in found]
    done = [False] * len(rows)
    while waiting:
        a, b = waiting.pop()
        place, there = sides.get((a, b)), sides_there.get((found[a], found[b]))
        if place is None:
            continue
        if there is None:
            return None
        (j, i), (k, turn) = place, there
        if done[j]:
            continue
        done[j] = True
        mine, theirs = rows[j][i:] + rows[j][:i], images[k][turn:] + images[k][:turn]
        for node, image in zip(mine, theirs, strict=True):
            if found.setdefault(node, image) != image:
                return None
        waiting += [(mine[c], mine[c - 1]) for c in range(4)]
    return found if all(done) and len(set(found.values())) == len(found) else None
