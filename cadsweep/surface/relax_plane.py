"""Relaxing quads in a plane, as one compiled loop.

Place in the flow: :mod:`.relax` hands quads over that lie on a plane: there a node's move is a shift, and nothing has
to be asked of a surface between two moves. A plate with many outlines has hundreds of such faces of a few dozen quads
each, on which numpy spends its time on calls.

Method: that of :mod:`.relax`, with the same numbers.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

kernel = compiled(cache=True, nogil=True, error_model="numpy")


@kernel
def quad_sine(x, quads, q):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Least sine of the corner angles of one quad in the plane, counter-clockwise."""
    least = np.inf
    a, b = quads[q, 3], quads[q, 0]
    back_x, back_y = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1]
    back = np.sqrt(max(back_x * back_x + back_y * back_y, 1e-300))
    for i in range(4):
        a, b = quads[q, i], quads[q, (i + 1) % 4]
        step_x, step_y = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1]
        step = np.sqrt(max(step_x * step_x + step_y * step_y, 1e-300))
        least = min(least, (back_x * step_y - back_y * step_x) / (back * step))
        back_x, back_y, back = step_x, step_y, step
    return least


@kernel
def _find_uses(quads, starts, around):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Quads of every node: where those of each begin, ``starts`` (n + 1,), and which they are, ``around``."""
    n = len(starts) - 1
    for node in range(n + 1):
        starts[node] = 0
    for q in range(len(quads)):
        for i in range(4):
            starts[quads[q, i] + 1] += 1
    for node in range(n):
        starts[node + 1] += starts[node]
    for q in range(len(quads)):  # `starts` runs ahead while quads are noted, and is put back
        for i in range(4):
            around[starts[quads[q, i]]] = q
            starts[quads[q, i]] += 1
    for node in range(n, 0, -1):
        starts[node] = starts[node - 1]
    starts[0] = 0


@kernel
def _smooth(x, quads, sines, starts, around, n_fixed, n_sweeps, good):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    """Laplacian smoothing, where no quad falls below both a good value and what it was."""
    n = len(x)
    sizes, seen = np.empty(n), np.empty(n, np.int64)
    for node in range(n):
        sizes[node] = np.inf
    for q in range(len(quads)):
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) % 4]
            length = np.sqrt((x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2)
            sizes[a], sizes[b] = min(sizes[a], length), min(sizes[b], length)
    to, trial = np.empty((n, 2)), np.empty((n, 2))
    moving, kept = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    values = np.empty(len(quads))
    for _ in range(n_sweeps):
        n_moving = 0
        for node in range(n):
            seen[node] = -1
        for node in range(n_fixed, n):
            count, sum_x, sum_y = 0, 0.0, 0.0
            for use in range(starts[node], starts[node + 1]):
                q = around[use]
                for i in range(4):
                    if quads[q, i] == node:
                        for other in (quads[q, (i + 1) % 4], quads[q, (i + 3) % 4]):
                            if seen[other] != node:
                                seen[other] = node
                                count += 1
                                sum_x += x[other, 0]
                                sum_y += x[other, 1]
            share = 1.0 / max(count, 1)
            off_x, off_y = 0.7 * (sum_x * share - x[node, 0]), 0.7 * (sum_y * share - x[node, 1])
            moving[node] = np.sqrt(off_x * off_x + off_y * off_y) > 0.01 * sizes[node]
            kept[node] = moving[node]
            n_moving += moving[node]
            to[node, 0], to[node, 1] = x[node, 0] + off_x, x[node, 1] + off_y
        if not n_moving:
            return
        settled = False
        for _ in range(20):
            for node in range(n):
                from_ = to if moving[node] else x
                trial[node, 0], trial[node, 1] = from_[node, 0], from_[node, 1]
            settled = True
            for q in range(len(quads)):
                values[q] = quad_sine(trial, quads, q)
                if values[q] < min(sines[q], good) - 1e-12:
                    for i in range(4):
                        if moving[quads[q, i]]:
                            kept[quads[q, i]] = settled = False
            if settled:
                break
            for node in range(n):
                moving[node] = kept[node]
        if settled:
            for node in range(n):
                x[node, 0], x[node, 1] = trial[node, 0], trial[node, 1]
            for q in range(len(quads)):
                sines[q] = values[q]


@kernel
def _choose(quads, sines, starts, around, tired, n_fixed, good, rank, chosen):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Free nodes of the worst quads, no two of which share a quad: into ``chosen``; how many. `rank` (n,) is room."""
    n = len(tired)
    for node in range(n):
        rank[node] = np.inf
    for q in range(len(quads)):
        if sines[q] < good:
            for i in range(4):
                node = quads[q, i]
                if node >= n_fixed and not tired[node]:
                    rank[node] = min(rank[node], sines[q])
    count = 0
    for node in range(n_fixed, n):
        if rank[node] == np.inf:
            continue
        first = True
        for use in range(starts[node], starts[node + 1]):
            for i in range(4):
                other = quads[around[use], i]
                if rank[other] < rank[node] or (rank[other] == rank[node] and other < node):
                    first = False
        if first:
            chosen[count] = node
            count += 1
    return count


@kernel
def _look_around(x, quads, sines, starts, around, node, offsets, place):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """The ``place`` where the worst corner of a node's quads is best; what it gains there. The node stays."""
    least, before = np.inf, np.inf
    for use in range(starts[node], starts[node + 1]):
        q = around[use]
        before = min(before, sines[q])
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) % 4]
            least = min(least, (x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2)
    size = np.sqrt(least)
    from_x, from_y = x[node, 0], x[node, 1]
    place[0], place[1], best = from_x, from_y, -np.inf
    for k in range(len(offsets)):
        x[node, 0], x[node, 1] = from_x + size * offsets[k, 0], from_y + size * offsets[k, 1]
        worst = np.inf
        for use in range(starts[node], starts[node + 1]):
            worst = min(worst, quad_sine(x, quads, around[use]))
            if not worst > best:
                break
        if worst > best:
            best, place[0], place[1] = worst, x[node, 0], x[node, 1]
    x[node, 0], x[node, 1] = from_x, from_y
    return best - before


@kernel
def relax_in_plane(x, quads, n_fixed, offsets, n_sweeps, n_searches, good, least_gain):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Move nodes ``x`` (n, 2) but the first `n_fixed`, in place, as :func:`.relax.relax_quads` does; the worst sine.

    `quads` (q, 4) run counter-clockwise. `offsets` (k, 2): where a node looks, in lengths of its shortest edge.
    """
    n = len(x)
    starts, around = np.empty(n + 1, np.int64), np.empty(4 * len(quads), np.int64)
    _find_uses(quads, starts, around)
    sines = np.empty(len(quads))
    for q in range(len(quads)):
        sines[q] = quad_sine(x, quads, q)
    _smooth(x, quads, sines, starts, around, n_fixed, n_sweeps, good)
    tired = np.zeros(n, np.bool_)  # found nothing, and nothing near has changed since
    rank, chosen, places, gains = np.empty(n), np.empty(n, np.int64), np.empty((n, 2)), np.empty(n)
    for _ in range(n_searches):
        count = _choose(quads, sines, starts, around, tired, n_fixed, good, rank, chosen)
        if not count:
            break
        for m in range(count):
            gains[m] = _look_around(x, quads, sines, starts, around, chosen[m], offsets, places[m])
            if gains[m] <= least_gain:
                tired[chosen[m]] = True
        for m in range(count):
            if gains[m] > least_gain:
                node = chosen[m]
                x[node, 0], x[node, 1] = places[m, 0], places[m, 1]
                for use in range(starts[node], starts[node + 1]):
                    q = around[use]
                    sines[q] = quad_sine(x, quads, q)
                    for i in range(4):
                        tired[quads[q, i]] = False
    worst = np.inf
    for q in range(len(quads)):
        worst = min(worst, sines[q])
    return worst
