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
def _uses(quads, n):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Quads of every node: where those of each begin (n + 1,), and which they are."""
    starts = np.zeros(n + 1, np.int64)
    for q in range(len(quads)):
        for i in range(4):
            starts[quads[q, i] + 1] += 1
    for node in range(n):
        starts[node + 1] += starts[node]
    at, around = starts[:-1].copy(), np.empty(quads.size, np.int64)
    for q in range(len(quads)):
        for i in range(4):
            around[at[quads[q, i]]] = q
            at[quads[q, i]] += 1
    return starts, around


@kernel
def _smooth(x, quads, sines, starts, around, n_fixed, n_sweeps, good):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    """Laplacian smoothing, where no quad falls below both a good value and what it was."""
    n = len(x)
    sizes = np.full(n, np.inf)
    for q in range(len(quads)):
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) % 4]
            length = np.sqrt((x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2)
            sizes[a], sizes[b] = min(sizes[a], length), min(sizes[b], length)
    seen = np.full(n, -1)
    to, trial = np.empty_like(x), np.empty_like(x)
    moving, kept = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    values = np.empty(len(quads))
    for _ in range(n_sweeps):
        seen[:] = -1
        n_moving = 0
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
                trial[node] = to[node] if moving[node] else x[node]
            settled = True
            for q in range(len(quads)):
                values[q] = quad_sine(trial, quads, q)
                if values[q] < min(sines[q], good) - 1e-12:
                    for i in range(4):
                        if moving[quads[q, i]]:
                            kept[quads[q, i]] = settled = False
            if settled:
                break
            moving[:] = kept
        if settled:
            x[:] = trial
            sines[:] = values


@kernel
def _choose(quads, sines, starts, around, tired, n_fixed, good):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Free nodes of the worst quads, no two of which share a quad."""
    n = len(tired)
    rank = np.full(n, np.inf)
    for q in range(len(quads)):
        if sines[q] < good:
            for i in range(4):
                node = quads[q, i]
                if node >= n_fixed and not tired[node]:
                    rank[node] = min(rank[node], sines[q])
    candidates = np.flatnonzero(np.isfinite(rank))
    candidates = candidates[np.argsort(rank[candidates], kind="mergesort")]
    order = np.full(n, n)
    for place in range(len(candidates)):
        order[candidates[place]] = place
    chosen = np.zeros(n, np.bool_)
    for node in candidates:
        chosen[node] = True
        for use in range(starts[node], starts[node + 1]):
            for i in range(4):
                if order[quads[around[use], i]] < order[node]:
                    chosen[node] = False
    return np.flatnonzero(chosen)


@kernel
def _look_around(x, quads, sines, starts, around, node, offsets):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Where the worst corner of a node's quads is best, and what it gains there; the node stays where it is."""
    least, before = np.inf, np.inf
    for use in range(starts[node], starts[node + 1]):
        q = around[use]
        before = min(before, sines[q])
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) % 4]
            least = min(least, (x[b, 0] - x[a, 0]) ** 2 + (x[b, 1] - x[a, 1]) ** 2)
    size = np.sqrt(least)
    from_x, from_y = x[node, 0], x[node, 1]
    to_x, to_y, best = from_x, from_y, -np.inf
    for k in range(len(offsets)):
        x[node, 0], x[node, 1] = from_x + size * offsets[k, 0], from_y + size * offsets[k, 1]
        worst = np.inf
        for use in range(starts[node], starts[node + 1]):
            worst = min(worst, quad_sine(x, quads, around[use]))
            if not worst > best:
                break
        if worst > best:
            best, to_x, to_y = worst, x[node, 0], x[node, 1]
    x[node, 0], x[node, 1] = from_x, from_y
    return to_x, to_y, best - before


@kernel
def relax_in_plane(x, quads, n_fixed, offsets, n_sweeps, n_searches, good, least_gain):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Move nodes ``x`` (n, 2) but the first `n_fixed`, in place, as :func:`.relax.relax_quads` does; the worst sine.

    `quads` (q, 4) run counter-clockwise. `offsets` (k, 2): where a node looks, in lengths of its shortest edge.
    """
    starts, around = _uses(quads, len(x))
    sines = np.empty(len(quads))
    for q in range(len(quads)):
        sines[q] = quad_sine(x, quads, q)
    _smooth(x, quads, sines, starts, around, n_fixed, n_sweeps, good)
    tired = np.zeros(len(x), np.bool_)  # found nothing, and nothing near has changed since
    for _ in range(n_searches):
        nodes = _choose(quads, sines, starts, around, tired, n_fixed, good)
        if not len(nodes):
            break
        places, gains = np.empty((len(nodes), 2)), np.empty(len(nodes))
        for m in range(len(nodes)):
            places[m, 0], places[m, 1], gains[m] = _look_around(x, quads, sines, starts, around, nodes[m], offsets)
            if gains[m] <= least_gain:
                tired[nodes[m]] = True
        for m in range(len(nodes)):
            if gains[m] > least_gain:
                node = nodes[m]
                x[node] = places[m]
                for use in range(starts[node], starts[node + 1]):
                    q = around[use]
                    sines[q] = quad_sine(x, quads, q)
                    for i in range(4):
                        tired[quads[q, i]] = False
    return sines.min()
