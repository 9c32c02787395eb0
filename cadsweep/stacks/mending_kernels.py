"""What mending spends its time on, as compiled loops: the corners of quads on every level, and looking around a node.

Place in the flow: called by :mod:`.mending`. A node has four quads or five on a dozen levels, and numpy spends its time
on calls.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

kernel = compiled(cache=True, nogil=True, error_model="numpy")


@kernel
def _worst_sine(places, quads, there, q):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Least corner sine of a quad on the levels where it is; infinite where on none."""
    least = np.inf
    for k in range(places.shape[0]):
        if not there[k, q]:
            continue
        a, b = quads[q, 3], quads[q, 0]
        back_x, back_y = places[k, b, 0] - places[k, a, 0], places[k, b, 1] - places[k, a, 1]
        back = back_x * back_x + back_y * back_y
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) % 4]
            step_x, step_y = places[k, b, 0] - places[k, a, 0], places[k, b, 1] - places[k, a, 1]
            step = step_x * step_x + step_y * step_y
            least = min(least, (back_x * step_y - back_y * step_x) / max(np.sqrt(back * step), 1e-300))
            back_x, back_y, back = step_x, step_y, step
    return least


@kernel
def worst_sines(places, quads, there, ids, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Least corner sines ``out`` (m,) of quads `ids` over the levels where they are; infinite where on none.

    `places` (n_levels, n, 2) are those of the nodes, `there` (n_levels, q) tells which quad is on which level.
    """
    for j in range(len(ids)):
        out[j] = _worst_sine(places, quads, there, ids[j])


@kernel
def _lacks(places, quads, there, ids, wanted, most):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Squares of what the worst corners of quads `ids` lack of what is wanted, in sum; given up above `most`."""
    found = 0.0
    for q in ids:
        lack = wanted - _worst_sine(places, quads, there, q)
        if lack > 0.0:
            found += lack * lack
        if not found < most:
            break
    return found


@kernel
def look_around(places, quads, there, ids, node, offsets, wanted, move):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """The ``move`` (2,) of a node after which its quads `ids` lack least of what is wanted; returns what that gains.

    `offsets` (k, 2) count in lengths of the shortest edge at the node on any level. All places are left as they are.
    """
    n_levels = places.shape[0]
    least = np.inf
    for q in ids:
        for i in range(4):
            if quads[q, i] == node:
                for other in (quads[q, (i + 1) % 4], quads[q, (i + 3) % 4]):
                    for k in range(n_levels):
                        x, y = places[k, other, 0] - places[k, node, 0], places[k, other, 1] - places[k, node, 1]
                        least = min(least, x * x + y * y)
    reach = np.sqrt(least)
    own = np.empty((n_levels, 2))
    for k in range(n_levels):
        own[k, 0], own[k, 1] = places[k, node, 0], places[k, node, 1]
    before = _lacks(places, quads, there, ids, wanted, np.inf)
    best = before
    move[0], move[1] = 0.0, 0.0
    for j in range(len(offsets)):
        x, y = reach * offsets[j, 0], reach * offsets[j, 1]
        for k in range(n_levels):
            places[k, node, 0], places[k, node, 1] = own[k, 0] + x, own[k, 1] + y
        lacks = _lacks(places, quads, there, ids, wanted, best)
        if lacks < best:
            best = lacks
            move[0], move[1] = x, y
    for k in range(n_levels):
        places[k, node, 0], places[k, node, 1] = own[k, 0], own[k, 1]
    return before - best
