"""The functionals F, G and H of the paper, as one small least-squares system.

Place in the flow: the heart of projection; :mod:`.fitting` solves it for all layers of a sweep at once.

Method. With ``xbar = x - c^X``, ``ybar = y - c^Y``:

- eq. (6)   ``F(A) = sum |ybar - A xbar|^2``
- eq. (9)   ``G(A) = sum |ybar + d - A (xbar + d)|^2``, ``d = c^Y - c^X``
- eq. (10)  ``H(A) = sum |ybar - A xbar|^2 + |u^Y - A u^X|^2``

Because the ``xbar`` and the ``ybar`` each sum to nothing, the mixed terms of (9) vanish, and
``G(A) = F(A) + m |d - A d|^2``: G is H with ``u^X = u^Y = sqrt(m) d``. So all three are the system of F with at
most one more row. With the ring factorised once, ``xbar = Q diag(values) Vt``, every layer is left with the (n + 1) x n
system ``[diag(values) Vt; u^X] A^T = [Q^T ybar; u^Y]``, solved by singular value decomposition (smallest norm).

References
----------
Roca, Sarrate, Huerta, "A new least-squares approximation of affine mappings for sweep algorithms".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from .normals import PLANAR, normal_share

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the greatest count as zero."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RingFactors:
    """``ring - center = Q diag(values) Vt``, Q never formed where many rings are factorised.

    Leading axes: none for one ring, (K,) for many.
    """

    values: FloatArray
    Vt: FloatArray

    @property
    def radius(self) -> FloatArray:
        """Frobenius norm of the centred ring, sqrt(m) times the r.m.s. radius."""
        return np.asarray(np.linalg.norm(self.values, axis=-1))

    @property
    def deltas(self) -> FloatArray:
        """Relative non-planarity."""
        return np.asarray(self.values[..., -1] / self.radius)


@dataclass(frozen=True, kw_only=True, eq=False)
class AffineMaps:
    """The maps of K layers.

    Attributes
    ----------
    matrices : (K, n, n) float64
    source_centers : (K, n) float64
    centers : (K, n) float64
    ranks : (K,) int64
    conditions : (K,) float64
    """

    matrices: FloatArray
    source_centers: FloatArray
    centers: FloatArray
    ranks: IntArray
    conditions: FloatArray


def rows_of_g(n_ring_nodes: int, d: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eq. (9) as rows u^X = u^Y (K, n); d (K, n) goes from the source centres to the centres."""
    row = np.sqrt(n_ring_nodes) * d
    return row, row


def rows_of_h(factors: RingFactors, normals: FloatArray, image_normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eq. (10) with Remark 8's vectors as rows u^X, u^Y (K, n): the pseudo-normals, as far as X is planar.

    Their length omega sets how much of the action across the plane is the normal's: with
    ``omega^2 = radius^2 delta^2 s / (1 - s + delta^2)`` the n-th equation weighs the normal by
    s = :func:`.normal_share` (to a relative ``delta^2``) and the ring's own offsets by 1 - s. Up to
    PLANAR omega is the radius, from CURVED on zero. On a planar ring the length does not matter; being a
    multiple of the radius it makes the result the same in every unit of length.
    """
    share, delta2 = normal_share(factors.deltas), factors.deltas**2
    below = 1.0 - share + delta2
    squares = np.where(share < 1.0, delta2 * share / np.where(below > 0.0, below, 1.0), 1.0)
    omega = (factors.radius * np.sqrt(squares))[:, None]
    return omega * normals, omega * image_normals


def without_noise(factors: RingFactors) -> RingFactors:
    """The factors with the offsets of planar rings taken out: F and G have nothing that outweighs their noise."""
    values = factors.values.copy()
    values[..., -1] = np.where(factors.deltas < PLANAR, 0.0, values[..., -1])
    return RingFactors(values=values, Vt=factors.Vt)


def solve(
    factors: RingFactors, products: FloatArray, rows: tuple[FloatArray, FloatArray] | None
) -> tuple[FloatArray, IntArray, FloatArray]:
    """Solve ``[diag(values) Vt; u^X] A^T = [Q^T ybar; u^Y]`` for K layers.

    Parameters
    ----------
    factors : RingFactors
        Of K rings.
    products : (K, n, n) float64
        ``Q^T ybar``.
    rows : (u^X, u^Y), each (K, n), or None
        None is F.

    Returns
    -------
    matrices (K, n, n), ranks (K,), conditions (K,)
        A; the rank of the system; its condition number, infinite below full rank.
    """
    uX, uY = (np.zeros((len(products), products.shape[2])),) * 2 if rows is None else rows
    system = np.concatenate([factors.values[..., None] * factors.Vt, uX[:, None]], axis=1)
    rhs = np.concatenate([products, uY[:, None]], axis=1)
    U, s, Wt = np.linalg.svd(system, full_matrices=False)
    kept = s > RANK_TOLERANCE * s[:, :1]
    inverse = np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)
    matrices = (Wt.transpose(0, 2, 1) @ (inverse[..., None] * (U.transpose(0, 2, 1) @ rhs))).transpose(0, 2, 1)
    full = kept.all(axis=1)
    conditions = np.where(full, s[:, 0] / np.where(full, s[:, -1], 1.0), np.inf)
    return np.ascontiguousarray(matrices), kept.sum(axis=1), conditions
