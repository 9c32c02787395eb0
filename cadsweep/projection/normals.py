"""Rings as planes: their moments, their pseudo-normal, and how far from planar they are.

Place in the flow: :mod:`.fitting` takes from here what the functional H needs beside the ring itself.

Method: one compiled pass over the rings (:func:`.loop_sums`).

Planarity is a scale, not a switch. The relative non-planarity ``delta`` of a ring is the r.m.s. offset from
its best plane over its r.m.s. radius. Two bounds divide the scale:

- below ``PLANAR`` = 1e-5 a ring counts as planar. CAD kernels keep curves together to about 1e-7 of a part,
  and rings pass through files and fits that lose a digit or two: an offset below 1e-5 says nothing;
- above ``CURVED`` = 1e-2 it counts as curved. There its own offsets fix the affine map's action across
  the plane, with errors amplified at most a hundredfold.

Between them :func:`normal_share` falls from 1 to 0 as a quintic smooth step of ``log(delta)``, so that the
result has no jump wherever on the scale a ring lies.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..errors import InputError, ProjectionError
from .inputs import checked_loops, checked_points, loop_slices
from .kernels import loop_sums, share_layers

PLANAR = 1e-5
"""Relative thickness up to which a ring counts as plane: far above the rounding of CAD, far below a bend."""
CURVED = 1e-2
"""Relative thickness from which a ring alone determines the map across its plane; between, the two are mixed."""
COLLAPSED = 1e-7
"""A loop thinner than this, relative to its r.m.s. radius, spans less than n - 1 dimensions (Remark 7)."""
VANISHING = 1e-4
"""A vector area below this fraction of what its loops sweep about their centre counts as none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RingMoments:
    """What the fits need to know of every ring.

    Attributes
    ----------
    centers : (K, n) float64
        Mean of the ring's nodes, c in eq. (3).
    products : (K, p, n) float64
        ``projector @ (ring - center)``.
    normals : (K, n) float64
        Pseudo-normals.
    """

    centers: FloatArray
    products: FloatArray
    normals: FloatArray


def normal_share(delta: npt.ArrayLike) -> FloatArray:
    """Share of the normal in the map's action across the plane: 1 up to PLANAR, 0 from CURVED on, smooth between."""
    log_delta = np.log(np.maximum(delta, 1e-300))
    x = np.clip((log_delta - np.log(PLANAR)) / np.log(CURVED / PLANAR), 0.0, 1.0)
    return np.asarray(1.0 - x**3 * (10.0 - 15.0 * x + 6.0 * x**2))


def pseudo_normal(ring: npt.ArrayLike, loops: Sequence[npt.ArrayLike] | None = None) -> FloatArray:
    """Unit vector area of a ring: its normal where it is planar, a measure of one where it is not.

    Parameters
    ----------
    ring : (m, n) array, n = 2 or 3
        Boundary nodes.
    loops : sequence of int arrays, optional
        Rows of `ring` in cyclic order, outer loop first; one loop of all rows where not given. Node ids of a
        mesh, whose concatenation the ring follows, are understood too where they cannot be rows. Holes may
        turn either way: they are taken against the outer loop.

    Returns
    -------
    (n,) float64
        Unit vector. Reversing the outer loop reverses it.

    Raises
    ------
    ProjectionError
        A loop spans less than n - 1 dimensions.

    Notes
    -----
    Where the vector area of all loops vanishes (a tubular band), it is the outer loop's own vector area;
    where that vanishes too (a figure of eight), the normal of the best plane, on the side from which the part
    of the loop near its closing segment turns counter-clockwise. In R^2, where a hyperplane is a line, it is the
    left-hand normal of the direction in which the outer loop's nodes progress: ``sum (i - mean(i)) x_i``.

    Examples
    --------
    >>> from cadsweep.projection import pseudo_normal
    >>> pseudo_normal([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]).tolist()
    [0.0, 0.0, 1.0]
    """
    points = checked_points(ring, "ring")
    order = row_loops(loops, len(points))
    rows = np.concatenate(order)
    moments = ring_moments(points[None, rows], order, projector=np.empty((0, len(rows))))
    return moments.normals[0]


def row_loops(loops: Sequence[npt.ArrayLike] | None, n_rows: int) -> tuple[IntArray, ...]:
    """The loops of a ring as rows of it; without `loops` one loop of all rows.

    Loops of as many ids as there are rows, some of them no row, are a mesh's: the ring follows their concatenation.
    """
    if loops is None:
        return (np.arange(n_rows, dtype=np.int64),)
    ids = [np.asarray(loop) for loop in loops]
    n_ids = sum(loop.size for loop in ids)
    greatest = max((int(np.max(loop)) for loop in ids if loop.size), default=0)
    if n_ids == n_rows and greatest >= n_rows:
        slices = loop_slices(checked_loops(loops, greatest + 1))
        return tuple(np.arange(s.start, s.stop, dtype=np.int64) for s in slices)
    return checked_loops(loops, n_rows)


def ring_moments(rings: FloatArray, loops: Sequence[IntArray], *, projector: FloatArray) -> RingMoments:
    """Pass once over rings (K, b, n), in the order of ``np.concatenate(loops)``, and gather their moments.

    Parameters
    ----------
    rings : (K, b, n) float64
    loops : sequence of int64 arrays
        Only their lengths count here.
    projector : (p, b) float64
        Rows by which every centred ring is multiplied.

    Raises
    ------
    ProjectionError
        A loop spans less than n - 1 dimensions; names layer and loop.
    """
    n_rings, n_ring_nodes, n = rings.shape
    slices = loop_slices(loops)
    shares = np.array([s.stop - s.start for s in slices]) / n_ring_nodes
    loop_centers = np.empty((n_rings, len(slices), n))
    products = np.zeros((n_rings, len(projector), n))
    grams = np.empty((n_rings, len(slices), n, n))
    turns = np.empty((n_rings, len(slices), n, n))
    bounds = np.array([s.start for s in slices] + [n_ring_nodes])
    rows = np.ascontiguousarray(projector)

    def gather(run: slice) -> None:
        loop_sums(rings[run], bounds, rows, loop_centers[run], grams[run], turns[run], products[run])

    share_layers(gather, n_rings, n_ring_nodes)
    centers = np.einsum("j,kjc->kc", shares, loop_centers)
    if len(projector) and len(slices) > 1:
        # Each loop was centred on itself, which keeps small holes exact; this brings them to the ring's centre.
        sums = np.stack([projector[:, s].sum(axis=1) for s in slices])
        products += np.einsum("jp,kjc->kpc", sums, loop_centers - centers[:, None])
    _refuse_collapsed(grams)
    normals = _line_normals(rings, slices[0]) if n == 2 else _area_normals(rings, slices, turns, grams)
    return RingMoments(centers=centers, products=products, normals=normals)


def _refuse_collapsed(grams: FloatArray) -> None:
    """Raise where a loop spans less than n - 1 dimensions, by its Gram matrices (K, n_loops, n, n)."""
    n = grams.shape[-1]
    values = np.linalg.eigvalsh(grams)
    radius2 = np.trace(grams, axis1=-2, axis2=-1)
    thickness2 = values[..., 1] if n > 2 else values[..., -1]
    bound = COLLAPSED**2 * radius2 + (1e-13 * np.sqrt(radius2.max())) ** 2
    if n == 2:
        bound = np.full_like(bound, (COLLAPSED**2) * radius2.max())
    bad = thickness2 <= bound
    if bad.any():
        layer, loop = (int(i) for i in np.argwhere(bad)[0])
        what = "on a line" if n == 3 else "in fewer than n - 1 dimensions"
        raise ProjectionError(
            f"layer {layer}: the nodes of loop {loop} lie {what}, so they determine no affine map; "
            "check the section there, or end the sweep before it collapses",
            layer=layer,
            loop=loop,
        )


def _area_normals(rings: FloatArray, slices: Sequence[slice], turns: FloatArray, grams: FloatArray) -> FloatArray:
    if rings.shape[-1] != 3:
        raise InputError(f"a pseudo-normal is defined in R^2 and R^3, not in R^{rings.shape[-1]}")
    # sum x_i x x_(i+1) is the skew part of sum x_i (x) x_(i+1).
    skew = 0.5 * (turns - turns.transpose(0, 1, 3, 2))
    areas = np.stack([skew[..., 1, 2], skew[..., 2, 0], skew[..., 0, 1]], axis=-1)
    outer = areas[:, 0]
    against = np.where(np.einsum("kjc,kc->kj", areas, outer) > 0.0, -1.0, 1.0)
    against[:, 0] = 1.0
    total = np.einsum("kj,kjc->kc", against, areas)
    # A circle sweeps pi r^2 = pi * (sum |x|^2) / m about its centre: a cheap bound that clears nearly every ring.
    sizes = np.array([s.stop - s.start for s in slices])
    scale = np.pi * np.trace(grams, axis1=-2, axis2=-1) / sizes
    length = np.linalg.norm(total, axis=-1)
    doubtful = np.flatnonzero(length < 10.0 * VANISHING * scale.sum(axis=1))
    for k in doubtful:
        total[k] = _fallback_normal([rings[k, s] for s in slices], total[k], outer[k])
    return total / np.linalg.norm(total, axis=-1, keepdims=True)


def _fallback_normal(loops: Sequence[FloatArray], total: FloatArray, outer: FloatArray) -> FloatArray:
    """The first of: vector area, outer loop's vector area, best plane's normal, that does not vanish."""
    swept = []
    for loop in loops:
        local = loop - loop.mean(axis=0)
        swept.append(np.cross(local, np.roll(local, -1, axis=0)))
    scales = [0.5 * float(np.linalg.norm(s, axis=1).sum()) for s in swept]
    if np.linalg.norm(total) > VANISHING * sum(scales):
        return total
    if np.linalg.norm(outer) > VANISHING * scales[0]:
        return outer
    points = np.concatenate(list(loops))
    normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][-1]
    first = loops[0] - loops[0].mean(axis=0)
    middles = 0.5 * (first + np.roll(first, -1, axis=0))
    near = np.exp(-np.sum((middles - middles[-1]) ** 2, axis=1) / np.mean(np.sum(first**2, axis=1)))
    side = float((near @ swept[0]) @ normal)
    return normal if side >= 0.0 else -normal


def _line_normals(rings: FloatArray, outer: slice) -> FloatArray:
    loop = rings[:, outer]
    m = outer.stop - outer.start
    local = loop - loop.mean(axis=1, keepdims=True)
    progress = np.einsum("i,kic->kc", np.arange(m) - 0.5 * (m - 1), local)
    still = np.linalg.norm(progress, axis=-1) <= VANISHING * m * np.sqrt(np.sum(local**2, axis=(1, 2)))
    for k in np.flatnonzero(still):
        progress[k] = np.linalg.svd(local[k])[2][0]
    normals = np.stack([-progress[:, 1], progress[:, 0]], axis=-1)
    return normals / np.linalg.norm(normals, axis=-1, keepdims=True)
