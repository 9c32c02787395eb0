"""Transfinite filling of a logical rectangle, in a surface's parameters.

Place in the flow: ``sides`` (linking faces) and ``quads`` (four-sided caps) call :func:`fill`.

Method: Gordon and Hall's transfinite interpolation between the four chains, in the (u, v) plane of
the face, its blending variables being the arc-length fractions of the chains (the crossing of the
two lines that join opposite nodes), so that graded chains stay straight where they should. Where
that folds or comes out badly shaped, Winslow's equations are solved in the parameter plane (their
solution does not fold on a square), or the interpolation is done in space and brought onto the
surface; the best of them by its worst corner is taken, and relaxed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt
import scipy

from ..arrays import FloatArray, IntArray
from ..brep import Surface
from ..polygons import interior_angles
from .relax import relax_quads
from .relax_kernels import run_along, worst_grid_corner

_Number = TypeVar("_Number", bound=np.generic)

_CORNER = np.radians(140)
"""Angle below which a node of a polygon is a corner of its grid."""
GOOD_ENOUGH = 0.3
"""Worst corner sine of a filling above which no other one is tried."""
_TURNED = 0.5
"""Cosine between the normals of a corner and its neighbours below which the normal cannot tell how a quad turns."""
_MOST_UNKNOWNS = 200_000
"""Inner nodes up to which Winslow's equations are solved: beyond, their factors fill memory."""


def blend_variables(
    bottom: FloatArray, right: FloatArray, top: FloatArray, left: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Blending variables xi, eta (h + 1, w + 1) from the chains' fractions (w + 1,) and (h + 1,).

    Node (k, i) stands where the line from bottom i to top i crosses the line from left k to right k
    in the unit square.
    """
    across = (top - bottom)[None, :]
    along = (right - left)[:, None]
    xi = (bottom[None, :] + left[:, None] * across) / (1.0 - across * along)
    eta = left[:, None] + xi * along
    return xi, eta


def interpolate(chains: tuple[FloatArray, ...], xi: FloatArray, eta: FloatArray) -> FloatArray:
    """Transfinite interpolation (h + 1, w + 1, d) of chains bottom, right, top, left, each (., d)."""
    bottom, right, top, left = chains
    x, e = xi[..., None], eta[..., None]
    edges = (1 - e) * bottom[None] + e * top[None] + (1 - x) * left[:, None] + x * right[:, None]
    corners = (1 - e) * ((1 - x) * bottom[0] + x * bottom[-1]) + e * ((1 - x) * top[0] + x * top[-1])
    return edges - corners


def join_chains(parts: Sequence[npt.NDArray[_Number]]) -> npt.NDArray[_Number]:
    """One row of nodes from edges that meet end to end; the meeting nodes once."""
    return np.concatenate([parts[0], *(part[1:] for part in parts[1:])])


def chain_fractions(points: FloatArray) -> FloatArray:
    """Fractions (n,) of chord length along points (n, d)."""
    fractions = np.empty(len(points))
    run_along(np.ascontiguousarray(points), fractions)
    return fractions


def worst_corner(points: FloatArray, normals: FloatArray, uv: FloatArray) -> float:
    """Least sine of the corner angles of a grid of quads, seen along the surface's normals.

    Where the surface turns by more than a quad can follow, as at the tip of a thin blade, its normal at a corner says
    nothing of the quad: there it is the parameters that say whether it is folded.

    Parameters
    ----------
    points, normals : (h + 1, w + 1, 3) float64
        ``d points / d i  x  d points / d k`` should point along the normals.
    uv : (h + 1, w + 1, 2) float64
    """
    worst = float(worst_grid_corner(np.ascontiguousarray(points), np.ascontiguousarray(normals)))
    if not -np.inf < worst < GOOD_ENOUGH:
        return worst
    along, across = np.diff(points, axis=1), np.diff(points, axis=0)
    u_along, u_across = np.diff(uv, axis=1), np.diff(uv, axis=0)
    even = (
        np.einsum("kid,kid->ki", normals[:, :-1], normals[:, 1:]),
        np.einsum("kid,kid->ki", normals[:-1], normals[1:]),
    )
    seen, by_uv, turned = [], [], []
    for k, i in ((0, 0), (0, 1), (1, 0), (1, 1)):
        rows, columns = slice(k, k + len(across)), slice(i, i + along.shape[1])
        cross = np.cross(along[rows], across[:, columns])
        lengths = np.linalg.norm(along[rows], axis=2) * np.linalg.norm(across[:, columns], axis=2)
        lengths = np.where(lengths > 0, lengths, 1.0)
        seen.append(np.einsum("kid,kid->ki", cross, normals[rows, columns]) / lengths)
        own, other = u_along[rows], u_across[:, columns]
        by_uv.append(
            np.sign(own[..., 0] * other[..., 1] - own[..., 1] * other[..., 0]) * np.linalg.norm(cross, axis=2) / lengths
        )
        turned.append(np.minimum(even[0][rows], even[1][:, columns]) < _TURNED)
    seen_, by_uv_, turned_ = np.stack(seen), np.stack(by_uv), np.stack(turned)
    if not turned_.any():
        return worst
    # Which way round the parameters run: as they do where the normals tell.
    plain = ~turned_ & (np.abs(seen_) > GOOD_ENOUGH)
    way = np.sign((by_uv_[plain] * seen_[plain]).sum())
    return float(np.where(turned_, np.maximum(seen_, way * by_uv_), seen_).min())


def fill(
    surface: Surface,
    chains_uv: tuple[FloatArray, ...],
    chains: tuple[FloatArray, ...],
    *,
    side: float = 1.0,
) -> tuple[FloatArray, FloatArray, float]:
    """Fill the inside of a logical rectangle on a surface.

    Parameters
    ----------
    surface : Surface
    chains_uv, chains : bottom, right, top, left
        Parameters (., 2) and points (., 3) of the chains' nodes; bottom and top run the same way,
        left and right from bottom to top.
    side : {1, -1}
        1 where bottom x left points along the surface's outward normals.

    Returns
    -------
    points : (h + 1, w + 1, 3) float64
        The chains' rows and columns are the given points.
    uv : (h + 1, w + 1, 2) float64
    worst : float
        Least corner sine; negative where quads are inverted.
    """
    bottom, right, top, left = (chain_fractions(chain) for chain in chains)
    xi, eta = blend_variables(bottom, right, top, left)
    uv = interpolate(chains_uv, xi, eta)
    points, worst = _on_surface(surface, uv, chains, side)
    if worst >= GOOD_ENOUGH or min(uv.shape[:2]) < 3:
        return points, uv, worst
    fillings = [(points, uv, worst)]
    for make in (_from_space, _from_winslow):
        other_uv = make(surface, uv, chains, xi, eta)
        if other_uv is None:
            continue
        points, worst = _on_surface(surface, other_uv, chains, side)
        fillings.append((points, other_uv, worst))
        if worst >= GOOD_ENOUGH:
            return fillings[-1]
    fillings += [_relaxed(surface, points, uv, side) for points, uv, _ in fillings]
    return max(fillings, key=lambda filling: filling[2])


def grid_of_polygon(loop: FloatArray) -> tuple[FloatArray, IntArray] | None:
    """A grid in a polygon (m, 2) of four sides, as inner nodes and quads; None where it has not, or they differ."""
    angle = interior_angles(loop)
    corners = np.flatnonzero(angle < _CORNER)
    if len(corners) != 4 or (angle > 2 * np.pi - _CORNER).any():
        return None
    turned = np.roll(np.arange(len(loop)), -corners[0])
    a, b, c, d = corners - corners[0]
    if b - a != d - c or c - b != len(loop) - d:
        return None
    ids = np.concatenate([turned, turned[:1]])
    bottom, right, top, left = ids[a : b + 1], ids[b : c + 1], ids[c : d + 1][::-1], ids[d:][::-1]
    chains = tuple(loop[chain] for chain in (bottom, right, top, left))
    xi, eta = blend_variables(*(chain_fractions(chain) for chain in chains))
    inner = interpolate(chains, xi, eta)[1:-1, 1:-1]
    h, w = len(left) - 1, len(bottom) - 1
    grid = np.empty((h + 1, w + 1), dtype=np.int64)
    grid[1:-1, 1:-1] = len(loop) + np.arange((h - 1) * (w - 1)).reshape(h - 1, w - 1)
    grid[0], grid[:, -1], grid[-1], grid[:, 0] = bottom, right, top, left
    quads = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=-1).reshape(-1, 4)
    return inner.reshape(-1, 2), quads


def _on_surface(
    surface: Surface, uv: FloatArray, chains: tuple[FloatArray, ...], side: float
) -> tuple[FloatArray, float]:
    shape = uv.shape[:2]
    points = np.empty((*shape, 3))
    if min(shape) > 2:
        inside = uv[1:-1, 1:-1]
        points[1:-1, 1:-1] = surface.evaluate(inside.reshape(-1, 2)).reshape(*inside.shape[:2], 3)
    points[0], points[:, -1], points[-1], points[:, 0] = chains
    normals = side * surface.normals(uv.reshape(-1, 2)).reshape(*shape, 3)
    return points, worst_corner(points, normals, uv)


def _from_space(
    surface: Surface, uv: FloatArray, chains: tuple[FloatArray, ...], xi: FloatArray, eta: FloatArray
) -> FloatArray | None:
    """The interpolation in space, brought onto the surface."""
    points = interpolate(chains, xi, eta)[1:-1, 1:-1]
    out = uv.copy()
    out[1:-1, 1:-1] = surface.project(points.reshape(-1, 3)).reshape(*points.shape[:2], 2)
    return _in_branch_of(surface, out, uv)


def _relaxed(surface: Surface, points: FloatArray, uv: FloatArray, side: float) -> tuple[FloatArray, FloatArray, float]:
    """A filling whose worst corners have been looked after one by one."""
    shape = uv.shape[:2]
    inside = np.zeros(shape, dtype=bool)
    inside[1:-1, 1:-1] = True
    order = np.argsort(inside.ravel(), kind="stable")  # the border first
    number = np.empty(len(order), dtype=np.int64)
    number[order] = np.arange(len(order))
    ids = number.reshape(shape)
    quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1).reshape(-1, 4)
    if side < 0:
        quads = quads[:, ::-1]
    flat, flat_uv = points.reshape(-1, 3)[order], uv.reshape(-1, 2)[order]
    flat, flat_uv, worst = relax_quads(surface, flat, flat_uv, quads, n_fixed=int((~inside).sum()))
    return flat[number].reshape(points.shape), flat_uv[number].reshape(uv.shape), worst


def _in_branch_of(surface: Surface, uv: FloatArray, reference: FloatArray) -> FloatArray:
    """Shift periodic parameters next to a reference."""
    for axis, period in enumerate(surface.periods):
        if period is not None:
            uv[..., axis] -= period * np.round((uv[..., axis] - reference[..., axis]) / period)
    return uv


def _from_winslow(
    surface: Surface, uv: FloatArray, chains: tuple[FloatArray, ...], xi: FloatArray, eta: FloatArray
) -> FloatArray | None:
    """Winslow's equations in the parameter plane, scaled so that both parameters measure lengths."""
    if (uv.shape[0] - 2) * (uv.shape[1] - 2) > _MOST_UNKNOWNS:
        return None
    by_u, by_v = surface.derivatives(uv[1:-1, 1:-1].reshape(-1, 2))
    scale = np.array([np.linalg.norm(by_u, axis=1).mean(), np.linalg.norm(by_v, axis=1).mean()])
    if not (np.isfinite(scale).all() and (scale > 0).all()):
        return None
    return solve_winslow(uv * scale) / scale


def solve_winslow(grid: FloatArray, *, n_steps: int = 30, tolerance: float = 1e-4) -> FloatArray:
    """Solve Winslow's elliptic equations on a grid (h + 1, w + 1, 2) with fixed borders.

    ``alpha x_ii - 2 beta x_ik + gamma x_kk = 0`` with ``alpha = |x_k|^2``, ``beta = x_i . x_k``,
    ``gamma = |x_i|^2``, frozen in each of at most `n_steps` sparse solves.
    """
    x = grid.copy()
    h, w = x.shape[0] - 2, x.shape[1] - 2
    number = -np.ones(x.shape[:2], dtype=np.int64)
    number[1:-1, 1:-1] = np.arange(h * w).reshape(h, w)
    size = float(np.max(np.ptp(grid.reshape(-1, 2), axis=0)))
    rows = np.arange(h * w)
    for _ in range(n_steps):
        x_i = 0.5 * (x[1:-1, 2:] - x[1:-1, :-2])
        x_k = 0.5 * (x[2:, 1:-1] - x[:-2, 1:-1])
        alpha, beta, gamma = ((x_k**2).sum(-1), (x_i * x_k).sum(-1), (x_i**2).sum(-1))
        floor = 1e-6 * float(np.max(alpha + gamma))
        alpha, gamma = alpha + floor, gamma + floor
        stencil = {
            (0, 0): -2 * (alpha + gamma),
            (0, 1): alpha,
            (0, -1): alpha,
            (1, 0): gamma,
            (-1, 0): gamma,
            (1, 1): -0.5 * beta,
            (-1, -1): -0.5 * beta,
            (1, -1): 0.5 * beta,
            (-1, 1): 0.5 * beta,
        }
        right = np.zeros((h * w, 2))
        entries = []
        for (dk, di), weight in stencil.items():
            column = number[1 + dk : 1 + dk + h, 1 + di : 1 + di + w].ravel()
            values = weight.ravel()
            border = column < 0
            fixed = x[1 + dk : 1 + dk + h, 1 + di : 1 + di + w].reshape(-1, 2)
            right[border] -= values[border, None] * fixed[border]
            entries.append((values[~border], rows[~border], column[~border]))
        values, i, j = (np.concatenate(part) for part in zip(*entries, strict=True))
        matrix = scipy.sparse.csc_matrix((values, (i, j)), shape=(h * w, h * w))
        new = scipy.sparse.linalg.spsolve(matrix, right).reshape(h, w, 2)
        if not np.isfinite(new).all():
            break
        moved = float(np.max(np.abs(new - x[1:-1, 1:-1])))
        x[1:-1, 1:-1] = new
        if moved <= tolerance * size:
            break
    return x
