"""Compiled loops over quads in space: neighbours across edges, sheets at nodes, areas, turning angles.

Place in the flow: the inner loops of :mod:`cadsweep.quality.conformity` and
:mod:`cadsweep.quality.cadcheck`. A half-edge ``4 q + i`` runs from corner i of quad q to the next.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..compiled import compiled

_compiled = compiled(cache=True, error_model="numpy", nogil=True)

HARDLY_TURNS = 0.999
"""Flat over true area of a quad from which three Gauss points a direction give nine digits of it."""


def _gauss(n: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Points and weights on the unit interval."""
    places, weights = np.polynomial.legendre.leggauss(n)
    return (places + 1) / 2, weights / 2


_FEW, _FEW_WEIGHTS = _gauss(3)
_MANY, _MANY_WEIGHTS = _gauss(20)


@_compiled
def pair_edges(quads, n_nodes, mates):  # type: ignore[no-untyped-def]
    """Fill mates (4 q,): the opposite half-edge; -1 where there is none, -2 where the edge is used wrongly.

    Wrongly: by more than two quads, or by two that run through it in one direction. Returns the
    number of edges.
    """
    head = np.full(n_nodes, -1, dtype=np.int64)
    follower = np.empty(4 * quads.shape[0], dtype=np.int64)
    n_edges = 0
    for q in range(quads.shape[0]):
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) & 3]
            least, other = min(a, b), max(a, b)
            half = 4 * q + i
            mates[half] = -1
            at = head[least]
            while at >= 0:
                c, d = quads[at >> 2, at & 3], quads[at >> 2, (at + 1) & 3]
                if min(c, d) == least and max(c, d) == other:
                    break
                at = follower[at]
            if at < 0:
                follower[half] = head[least]
                head[least] = half
                n_edges += 1
            elif mates[at] == -1 and quads[at >> 2, at & 3] == b and a != b:
                mates[at] = half
                mates[half] = at
            else:
                if mates[at] >= 0:
                    mates[mates[at]] = -2
                mates[at] = -2
                mates[half] = -2
    return n_edges


@_compiled
def count_sheets(quads, n_nodes, mates, sheets):  # type: ignore[no-untyped-def]
    """Fill sheets (n_nodes,): into how many fans of neighbouring quads the quads at each node fall."""
    sheets[:] = 0
    seen = np.zeros(4 * quads.shape[0], dtype=np.bool_)
    for corner in range(4 * quads.shape[0]):
        if seen[corner]:
            continue
        node = quads[corner >> 2, corner & 3]
        sheets[node] += 1
        for backward in range(2):
            at = corner
            while True:
                seen[at] = True
                # The edge out of the corner leads to the next quad one way round, the edge into it the other way.
                base = at & ~3
                half = at if backward == 0 else base + ((at + 3) & 3)
                mate = mates[half]
                if mate < 0:
                    break
                at = (mate & ~3) + ((mate + 1) & 3) if backward == 0 else mate
                if seen[at]:
                    break


@_compiled
def volume_and_area(points, quads, origin):  # type: ignore[no-untyped-def]
    """Volume inside quads (q, 4) of points and their area, by their diagonals.

    The volume is the mean of both ways to cut each in two, which is the bilinear one's.
    """
    volume, area = 0.0, 0.0
    p = np.empty((4, 3))
    for q in range(quads.shape[0]):
        for i in range(4):
            for x in range(3):
                p[i, x] = points[quads[q, i], x] - origin[x]
        six = _triple(p, 0, 1, 2) + _triple(p, 0, 2, 3) + _triple(p, 0, 1, 3) + _triple(p, 1, 2, 3)
        volume += six / 12.0
        u0, u1, u2 = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
        v0, v1, v2 = p[3, 0] - p[1, 0], p[3, 1] - p[1, 1], p[3, 2] - p[1, 2]
        x0, x1, x2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
        area += 0.5 * np.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    return volume, area


@_compiled
def _triple(p, i, j, k):  # type: ignore[no-untyped-def]
    return (
        p[i, 0] * (p[j, 1] * p[k, 2] - p[j, 2] * p[k, 1])
        + p[i, 1] * (p[j, 2] * p[k, 0] - p[j, 0] * p[k, 2])
        + p[i, 2] * (p[j, 0] * p[k, 1] - p[j, 1] * p[k, 0])
    )


@_compiled
def measure_areas(points, quads, areas):  # type: ignore[no-untyped-def]
    """Fill areas (q,) of bilinear quads by Gauss points: few where a quad hardly turns, many where it is wrung."""
    u = np.empty((2, 3))
    v = np.empty((2, 3))
    for q in range(quads.shape[0]):
        a, b, c, d = quads[q, 0], quads[q, 1], quads[q, 2], quads[q, 3]
        for x in range(3):
            u[0, x] = points[b, x] - points[a, x]
            u[1, x] = points[c, x] - points[d, x]
            v[0, x] = points[d, x] - points[a, x]
            v[1, x] = points[c, x] - points[b, x]
        few = _area(u, v, _FEW, _FEW_WEIGHTS)
        # The sum of the areas as vectors, over the area: 1 where the quad is flat.
        flat = np.sqrt(_flat_area_squared(u, v))
        areas[q] = few if flat > HARDLY_TURNS * few else _area(u, v, _MANY, _MANY_WEIGHTS)


@_compiled
def _area(u, v, places, weights):  # type: ignore[no-untyped-def]
    total = 0.0
    for i in range(len(places)):
        s = places[i]
        for j in range(len(places)):
            t = places[j]
            u0 = (1 - t) * u[0, 0] + t * u[1, 0]
            u1 = (1 - t) * u[0, 1] + t * u[1, 1]
            u2 = (1 - t) * u[0, 2] + t * u[1, 2]
            v0 = (1 - s) * v[0, 0] + s * v[1, 0]
            v1 = (1 - s) * v[0, 1] + s * v[1, 1]
            v2 = (1 - s) * v[0, 2] + s * v[1, 2]
            x0, x1, x2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
            total += weights[i] * weights[j] * np.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    return total


@_compiled
def _flat_area_squared(u, v):  # type: ignore[no-untyped-def]
    u0, u1, u2 = u[0, 0] + u[1, 0], u[0, 1] + u[1, 1], u[0, 2] + u[1, 2]
    v0, v1, v2 = v[0, 0] + v[1, 0], v[0, 1] + v[1, 1], v[0, 2] + v[1, 2]
    x0, x1, x2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
    return (x0 * x0 + x1 * x1 + x2 * x2) / 16.0


@_compiled
def facet_slack(points, quads, mates, largest_turn):  # type: ignore[no-untyped-def]
    """How much volume and area the curvature of quads can hide, from the angles between neighbours."""
    volume, area = 0.0, 0.0
    n_quads = quads.shape[0]
    normals = np.empty((n_quads, 3))
    areas = np.empty(n_quads)
    for q in range(n_quads):
        a, b, c, d = quads[q, 0], quads[q, 1], quads[q, 2], quads[q, 3]
        x0, x1, x2 = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1], points[c, 2] - points[a, 2]
        y0, y1, y2 = points[d, 0] - points[b, 0], points[d, 1] - points[b, 1], points[d, 2] - points[b, 2]
        z0, z1, z2 = x1 * y2 - x2 * y1, x2 * y0 - x0 * y2, x0 * y1 - x1 * y0
        size = np.sqrt(z0 * z0 + z1 * z1 + z2 * z2)
        areas[q] = size / 2
        scale = 1.0 / size if size > 0.0 else 0.0
        normals[q, 0], normals[q, 1], normals[q, 2] = z0 * scale, z1 * scale, z2 * scale
    turns = np.empty(4)
    lengths = np.empty(4)
    for q in range(n_quads):
        for i in range(4):
            a, b = quads[q, i], quads[q, (i + 1) & 3]
            square = 0.0
            for x in range(3):
                square += (points[b, x] - points[a, x]) ** 2
            lengths[i] = np.sqrt(square)
            turns[i] = 0.0
            mate = mates[4 * q + i]
            if mate >= 0:
                other = mate >> 2
                cosine = 0.0
                for x in range(3):
                    cosine += normals[q, x] * normals[other, x]
                turn = np.arccos(min(1.0, max(-1.0, cosine)))
                if turn < largest_turn:
                    turns[i] = turn
        for i in range(2):
            # Across edges i and i + 2 the strip turns; its width is the other two edges.
            turn = max(turns[i], turns[i + 2])
            width = max(lengths[1 - i], lengths[3 - i])
            volume += areas[q] * width * turn / 8
            area += areas[q] * turn * turn / 8
    return volume, area
