r"""Quads between the two loops of a face with one hole, without a mesher.

Place in the flow: ``quads`` tries them beside gmsh's settings; what is better by its worst corner is
taken. gmsh meets a wall that is one quad thick only by luck.

Method: a thin wall gets one strip of quads, that with the best corners, found by dynamic programming round the wall;
where the strip goes round without a corner it is halved along its middle, since one quad does not bend as it should. A
quad of the strip takes a segment of each loop, or two segments of one loop, around
a corner, and a node of the other::

        h0--h1       h0          h0--h1--h2
        |    |      /  \          \     /
        o0--o1     o0-o1-o2          o0

A thicker wall between loops of as many nodes each gets several rings of quads.

Not handled: thick walls between loops of different numbers.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray

THIN = 3.0
"""Thickness of a wall, in segments, below which these quads are tried before a mesher's."""
_STRIP = 1.6
"""Thickness of a wall, in segments, below which it is one quad thick."""
_MOST_NODES = 400
_GREATEST_DIFFERENCE = 32
"""Nodes that one loop may have more than the other: each pair is a strip to place, and more do worse than gmsh."""
_MOST_STARTS = 24
"""Nodes of the hole where the first strip may begin, the nearest first; each is tried."""
_SHARPNESS = 8
"""Power of what a quad's worst corner lacks: a high one makes the worst quad of a strip weigh most."""
_MOVES = ((1, 1), (2, 0), (0, 2))
"""Segments that a quad takes of the outer loop and of the hole."""


def wall_thickness(loops: Sequence[FloatArray]) -> float:
    """Mean thickness of the wall between two loops, in mean segments."""
    steps = [np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1) for loop in loops]
    x, y = zip(*(loop.T for loop in loops), strict=True)
    area = sum(0.5 * float((a * np.roll(b, -1) - b * np.roll(a, -1)).sum()) for a, b in zip(x, y, strict=True))
    lengths = [float(step.sum()) for step in steps]
    return area / (sum(lengths) / 2) / (sum(lengths) / sum(len(step) for step in steps))


def fill_wall(loops: Sequence[FloatArray], opposite: FloatArray | None = None) -> tuple[FloatArray, IntArray] | None:
    """Fill the wall between two loops with quads.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, hole clockwise.
    opposite : (b,) float64, optional
        Angles of the loops' nodes on the cap that the quads are swept to, NaN where they are as here.

    Returns
    -------
    inner : (n, 2) float64
        Nodes between the loops.
    quads : (q, 4) int64
        Counter-clockwise; ids run through the outer loop, the hole, then `inner`.
    None
        Where there is no hole or several, the loops are too large, or a thick wall has loops of different numbers.
    """
    if len(loops) != 2 or max(len(loop) for loop in loops) > _MOST_NODES:
        return None
    outer, hole = loops[0], loops[1][::-1]
    ids = np.arange(len(outer) + len(hole), dtype=np.int64)
    hole_ids = ids[len(outer) :][::-1]
    thickness = wall_thickness(loops)
    if thickness < _STRIP:
        flat = np.zeros(len(ids)) if opposite is None else np.where(np.isnan(opposite), 0.0, 1.0 - np.sin(opposite))
        quads = _best_strip(outer, hole, flat[: len(outer)], flat[hole_ids])
        if quads is None:
            return None
        strip = np.concatenate([ids[: len(outer)], hole_ids])[quads]
        return _halved(strip, loops) if _is_ring(strip, len(outer)) else (np.empty((0, 2)), strip)
    if len(outer) != len(hole):
        return None
    hole_ids = np.roll(hole_ids, -_best_turn(outer, hole))
    n_steps = round(thickness)
    s = (np.arange(1, n_steps) / n_steps)[:, None, None]
    inner = ((1 - s) * outer + s * np.concatenate(loops)[hole_ids]).reshape(-1, 2)
    rows = np.concatenate([ids[: len(outer)], len(ids) + np.arange(len(inner)), hole_ids]).reshape(-1, len(outer))
    after = np.roll(rows, -1, axis=1)
    return inner, np.stack([rows[:-1], after[:-1], after[1:], rows[1:]], axis=-1).reshape(-1, 4)


def _is_ring(strip: IntArray, n_outer: int) -> bool:
    """Whether every quad of a strip has two nodes on either loop."""
    return bool(((strip < n_outer).sum(axis=1) == 2).all())


def _halved(strip: IntArray, loops: Sequence[FloatArray]) -> tuple[FloatArray, IntArray]:
    """Two rings for one: a wall that is one quad thick does not bend as it should."""
    n, n_outer = sum(len(loop) for loop in loops), len(loops[0])
    a, b, c, d = strip.T  # a and b on the outer loop
    other = np.empty(n_outer, dtype=np.int64)
    other[a], other[b] = d, c
    points = np.concatenate(loops)
    middles = (points[:n_outer] + points[other]) / 2
    return middles, np.concatenate([np.stack([a, b, n + b, n + a], axis=1), np.stack([n + a, n + b, c, d], axis=1)])


def _worst_sines(corners: FloatArray) -> FloatArray:
    """Worst corner sine (...) of quads (..., 4, 2)."""
    step = np.roll(corners, -1, axis=-2) - corners
    step /= np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-300)
    back = np.roll(step, 1, axis=-2)
    worst: FloatArray = (back[..., 0] * step[..., 1] - back[..., 1] * step[..., 0]).min(axis=-1)
    return worst


def _best_turn(outer: FloatArray, hole: FloatArray) -> int:
    """Turn of the hole's nodes, both counter-clockwise, that gives a single ring the best corners."""
    costs = []
    for turn in range(len(outer)):
        other = np.roll(hole, -turn, axis=0)
        worst = _worst_sines(np.stack([outer, np.roll(outer, -1, 0), np.roll(other, -1, 0), other], axis=1))
        costs.append(float(((1 - worst) ** _SHARPNESS).sum()))
    return _least(np.array(costs))


def _least(costs: FloatArray) -> int:
    """The first of the least costs, but for rounding in what their quads lack, so that symmetry does not decide."""
    return int(np.argmin(np.round(_lack(costs), 9)))


def _lack(cost: FloatArray) -> FloatArray:
    """About what the worst corner sine of a cost lacks: the cost itself, a high power, is nothing for good quads."""
    return np.asarray(cost ** (1.0 / _SHARPNESS))


def _quad_of(move: tuple[int, int], i: IntArray, j: IntArray, m: int, n: int) -> IntArray:
    """Quads (..., 4) that begin at the join of outer node i and hole node j; the hole's ids begin at m."""
    o = [(i + step) % m for step in range(3)]
    h = [m + (j + step) % n for step in range(3)]
    corners = {(1, 1): (o[0], o[1], h[1], h[0]), (2, 0): (o[0], o[1], o[2], h[0]), (0, 2): (o[0], h[2], h[1], h[0])}
    return np.stack(np.broadcast_arrays(*corners[move]), axis=-1)


def _best_strip(outer: FloatArray, hole: FloatArray, outer_flat: FloatArray, hole_flat: FloatArray) -> IntArray | None:
    """One strip of quads between loops that both run counter-clockwise; None where their numbers forbid it.

    ``outer_flat`` and ``hole_flat`` are what the corner of a quad that has a node alone lacks on the other cap.
    """
    m, n = len(outer), len(hole)
    if (m - n) % 2 or abs(m - n) > _GREATEST_DIFFERENCE:
        return None
    points = np.concatenate([outer, hole])
    i, j = np.meshgrid(np.arange(m), np.arange(n), indexing="ij")
    lacks = [1 - _worst_sines(points[_quad_of(move, i, j, m, n)]) for move in _MOVES]
    lacks[1] = np.maximum(lacks[1], np.roll(outer_flat, -1)[:, None])
    lacks[2] = np.maximum(lacks[2], np.roll(hole_flat, -1)[None, :])
    costs = [lack**_SHARPNESS for lack in lacks]
    best: tuple[float, IntArray] | None = None
    for first in (0, 1):  # of two nodes in a row, one is joined to the hole
        near = np.argsort(np.linalg.norm(hole - outer[first], axis=1), kind="stable")[:_MOST_STARTS]
        cost, quads = _walk_round(costs, first, near, m, n)
        if np.isfinite(cost) and (best is None or _lack(np.array(cost)) < _lack(np.array(best[0])) - 1e-9):
            best = cost, quads
    return None if best is None else best[1]


def _walk_round(costs: Sequence[FloatArray], first: int, starts: IntArray, m: int, n: int) -> tuple[float, IntArray]:
    """Cheapest strip that begins at the join of outer node `first` and one of the hole's nodes."""
    reach = 6 + abs(m - n) // 2
    total = np.full((m + 1, n + 1, len(starts)), np.inf)
    total[0, 0] = 0.0
    taken = np.zeros(total.shape, dtype=np.int8)
    for a in range(m + 1):
        middle = a * n // m
        for b in range(max(0, middle - reach), min(n, middle + reach) + 1):
            for k, (by_outer, by_hole) in enumerate(_MOVES):
                c, d = a - by_outer, b - by_hole
                if c < 0 or d < 0:
                    continue
                trial = total[c, d] + costs[k][(first + c) % m, (starts + d) % n]
                better = trial < total[a, b]
                total[a, b, better] = trial[better]
                taken[a, b, better] = k
    start = _least(total[m, n])
    cost = float(total[m, n, start])
    quads: list[IntArray] = []
    a, b = (m, n) if np.isfinite(cost) else (0, 0)
    while a or b:
        move = _MOVES[taken[a, b, start]]
        a, b = a - move[0], b - move[1]
        quads.append(_quad_of(move, np.array(first + a), starts[start] + np.array(b), m, n))
    return cost, np.array(quads[::-1], dtype=np.int64).reshape(-1, 4)
