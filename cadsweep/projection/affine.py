"""Least-squares affine maps between rings: the functionals F, G and H of the paper.

Place in the flow: the heart of projection; :mod:`.layers` fits every layer of a sweep with it.

Method. With ``xbar = x - c^X``, ``ybar = y - c^Y`` (rows below, matrices as in the paper):

- eq. (6)   ``F(A) = sum |ybar - A xbar|^2``
- eq. (9)   ``G(A) = sum |ybar + d - A (xbar + d)|^2``, ``d = c^Y - c^X``
- eq. (10)  ``H(A) = sum |ybar - A xbar|^2 + |u^Y - A u^X|^2``

Because the ``xbar`` and the ``ybar`` each sum to nothing, the mixed terms of (9) vanish, and
``G(A) = F(A) + m |d - A d|^2``: G is H with ``u^X = u^Y = sqrt(m) d``. So all three are the system
of F with at most one more row, the ring is factorised once, ``xbar = Q B`` with an orthonormal Q, and every
layer is left with an (n + 1) x n system, solved by singular value decomposition (solution of smallest norm).

Not handled: rings that span less than n - 1 dimensions (Remark 7), which are refused.

References
----------
Roca, Sarrate, Huerta, "A new least-squares approximation of affine mappings for sweep algorithms".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..errors import InputError
from ..topology import FloatArray, IntArray
from .inputs import FUNCTIONALS, checked_choice, checked_points
from .kernels import gram_matrices, turned_products
from .normals import PLANAR, RingMoments, normal_share, ring_moments, row_loops

RANK_TOLERANCE = 1e-9
"""Singular values below this fraction of the greatest count as zero."""


@dataclass(frozen=True, kw_only=True, eq=False)
class AffineMap:
    """``phi(x) = A (x - c^X) + b``, eq. (4).

    Attributes
    ----------
    matrix : (n, n) float64
        A.
    source_center : (n,) float64
        c^X.
    center : (n,) float64
        b, the image of the source centre (c^Y for F and H).
    rank : int
        Rank of the fitted system's matrix.
    condition : float
        Its condition number in the 2-norm; infinite where the rank is below n.
    functional : str
    """

    matrix: FloatArray
    source_center: FloatArray
    center: FloatArray
    rank: int
    condition: float
    functional: str

    def __call__(self, points: npt.ArrayLike) -> FloatArray:
        """Return the images (..., n) of `points` (..., n)."""
        return (np.asarray(points, dtype=np.float64) - self.source_center) @ self.matrix.T + self.center


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


def fit_affine(
    source_ring: npt.ArrayLike,
    ring: npt.ArrayLike,
    functional: str = "H",
    *,
    loops: Sequence[npt.ArrayLike] | None = None,
    vectors: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
) -> AffineMap:
    """Fit an affine map that takes a source ring to a ring in the least-squares sense.

    Parameters
    ----------
    source_ring, ring : (m, n) arrays
        X and Y, node by node.
    functional : "F", "G" or "H"
        Eqs. (6), (9), (10).
    loops : sequence of int arrays, optional
        Rows of the rings in cyclic order, outer loop first, as :func:`.pseudo_normal` takes them; one loop of all
        rows where not given. Used for the normals of H.
    vectors : (u^X, u^Y), optional
        The vectors of H. By default Remark 8's: the pseudo-normals of both rings where X is planar, zero
        where it is not. They enter with the ring's Frobenius norm as their length, which leaves the
        paper's solution for a planar ring as it is and makes the result the same in every unit of length;
        where X lies between planar and curved their weight goes over smoothly (:mod:`.normals`).
        Vectors given here are used as they are.

    Returns
    -------
    AffineMap

    Raises
    ------
    InputError
        Coordinates that are not finite, rings of unequal length, an unknown functional.
    ProjectionError
        A ring spans less than n - 1 dimensions (Remark 7).

    Notes
    -----
    For F and G a ring with a relative non-planarity below 1e-5 is taken as planar: its offsets are noise, and
    dividing by them would make the map noise too.

    References
    ----------
    Roca, Sarrate, Huerta, eqs. (6), (9), (10), Remarks 7 and 8.
    """
    X, Y = checked_points(source_ring, "source_ring"), checked_points(ring, "ring")
    checked_choice(functional, "functional", FUNCTIONALS)
    if X.shape != Y.shape:
        raise InputError(f"the rings have different shapes, {X.shape} and {Y.shape}; nodes are paired row by row")
    given = None
    if vectors is not None:
        if functional != "H":
            raise InputError(f"`vectors` belong to functional 'H', not to {functional!r}")
        given = np.stack([checked_points(np.atleast_2d(v), "vectors")[0] for v in vectors])
        if given.shape != (2, X.shape[1]):
            raise InputError(f"`vectors` must be two vectors of R^{X.shape[1]}")
    order = row_loops(loops, len(X))
    rows = np.concatenate(order)
    if len(rows) != len(X):
        raise InputError(f"`loops` hold {len(rows)} rows of a ring of {len(X)}; every row belongs to one loop")
    maps = fit_from_cap(X[rows], Y[None, rows], order, functional, vectors=given)
    return AffineMap(
        matrix=maps.matrices[0],
        source_center=maps.source_centers[0],
        center=maps.centers[0],
        rank=int(maps.ranks[0]),
        condition=float(maps.conditions[0]),
        functional=functional,
    )


def fit_from_cap(
    cap_ring: FloatArray,
    rings: FloatArray,
    loops: Sequence[IntArray],
    functional: str,
    *,
    vectors: FloatArray | None = None,
) -> AffineMaps:
    """Fit the maps from one ring (b, n) to many (K, b, n), all in the order of ``np.concatenate(loops)``."""
    sources = ring_moments(cap_ring[None], loops, projector=np.empty((0, len(cap_ring))))
    Q, factors = _factorise(cap_ring)
    moments = ring_moments(rings, loops, projector=Q.T)
    return _maps_of(
        sources, 0, moments, factors=factors, n_ring_nodes=len(cap_ring), functional=functional, vectors=vectors
    )


def fit_from_caps(
    rings: FloatArray, loops: Sequence[IntArray], functional: str, *, caps: Sequence[int]
) -> tuple[AffineMaps, ...]:
    """Fit the maps from some of the `rings` (K, b, n) to all of them, in one pass over the rings."""
    factorised = [_factorise(rings[cap]) for cap in caps]
    moments = ring_moments(rings, loops, projector=np.concatenate([Q.T for Q, _ in factorised]))
    m, n = rings.shape[1:]
    return tuple(
        _maps_of(
            moments,
            cap % len(rings),
            moments,
            factors=factors,
            columns=slice(j * n, (j + 1) * n),
            n_ring_nodes=m,
            functional=functional,
        )
        for j, (cap, (_, factors)) in enumerate(zip(caps, factorised, strict=True))
    )


def _factorise(ring: FloatArray) -> tuple[FloatArray, RingFactors]:
    """``ring - center = Q diag(values) Vt``; Q (m, n)."""
    n = ring.shape[1]
    Q, values, Vt = np.linalg.svd(ring - ring.mean(axis=0), full_matrices=False)
    missing = n - len(values)
    if missing:  # fewer than n nodes span too little, and the moments say so with the layer's name
        Q, values, Vt = (
            np.pad(Q, ((0, 0), (0, missing))),
            np.pad(values, (0, missing)),
            np.pad(Vt, ((0, missing), (0, 0))),
        )
    return Q, RingFactors(values=values[None], Vt=Vt[None])


def _maps_of(
    sources: RingMoments,
    source: int,
    moments: RingMoments,
    *,
    factors: RingFactors,
    columns: slice = slice(None),
    n_ring_nodes: int,
    functional: str,
    vectors: FloatArray | None = None,
) -> AffineMaps:
    """Solve for all rings of `moments` from ring `source` of `sources`; `columns` of its products are of `factors`."""
    ones = np.ones((len(moments.centers), 1))
    return solve_systems(
        factors=RingFactors(values=ones * factors.values, Vt=ones[..., None] * factors.Vt),
        products=moments.products[:, columns],
        n_ring_nodes=n_ring_nodes,
        source_centers=ones * sources.centers[source],
        centers=moments.centers,
        source_normals=ones * sources.normals[source],
        normals=moments.normals,
        functional=functional,
        vectors=vectors,
    )


def fit_steps(rings: FloatArray, loops: Sequence[IntArray], functional: str) -> AffineMaps:
    """Fit the maps from each ring to the next one; the first map is from ring 0 to itself."""
    moments = ring_moments(rings, loops, projector=np.empty((0, rings.shape[1])))
    factors, products = factorise_pairs(rings, moments.centers)
    before = np.concatenate([[0], np.arange(len(rings) - 1)])
    return solve_systems(
        factors=factors,
        products=products,
        n_ring_nodes=rings.shape[1],
        source_centers=moments.centers[before],
        centers=moments.centers,
        source_normals=moments.normals[before],
        normals=moments.normals,
        functional=functional,
    )


def solve_systems(
    *,
    factors: RingFactors,
    products: FloatArray,
    n_ring_nodes: int,
    source_centers: FloatArray,
    centers: FloatArray,
    source_normals: FloatArray,
    normals: FloatArray,
    functional: str,
    vectors: FloatArray | None = None,
) -> AffineMaps:
    """Solve the (n + 1) x n systems that are left of (6), (9), (10).

    ``[diag(values) Vt; u^X] A^T = [Q^T ybar; u^Y]``, by singular value decomposition.
    """
    values, d = factors.values, centers - source_centers
    if functional == "H":
        uX, uY = (source_normals, normals) if vectors is None else (vectors[:1], vectors[1:])
        weight = _normal_weight(factors)[:, None] if vectors is None else 1.0
        uX, uY = weight * uX, weight * uY
    else:
        uX = uY = np.sqrt(n_ring_nodes) * d if functional == "G" else np.zeros_like(d)
        planar = factors.deltas < PLANAR
        values = np.where(planar[:, None] & (np.arange(values.shape[-1]) == values.shape[-1] - 1), 0.0, values)
    system = np.concatenate([values[..., None] * factors.Vt, np.broadcast_to(uX, d.shape)[:, None]], axis=1)
    rhs = np.concatenate([products, np.broadcast_to(uY, d.shape)[:, None]], axis=1)
    U, s, Wt = np.linalg.svd(system, full_matrices=False)
    kept = s > RANK_TOLERANCE * s[:, :1]
    inverse = np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)
    matrices_T = Wt.transpose(0, 2, 1) @ (inverse[..., None] * (U.transpose(0, 2, 1) @ rhs))
    matrices = matrices_T.transpose(0, 2, 1)
    images = centers
    if functional == "G":
        # (9) sends c^X to c^X + A d, which is c^Y where d is a fixed vector of A (X planar, d off its plane).
        images = source_centers + np.einsum("kij,kj->ki", matrices, d)
    full = kept.all(axis=1)
    return AffineMaps(
        matrices=np.ascontiguousarray(matrices),
        source_centers=source_centers,
        centers=images,
        ranks=kept.sum(axis=1),
        conditions=np.where(full, s[:, 0] / np.where(full, s[:, -1], 1.0), np.inf),
    )


def _normal_weight(factors: RingFactors) -> FloatArray:
    """Length of u^X that gives the normal :func:`normal_share` of the action across the plane.

    With ``omega^2 = radius^2 delta^2 s / (1 - s + delta^2)`` the n-th equation of (10) weighs the normal by s
    (to a relative ``delta^2``) and the ring's own offsets by 1 - s. Up to PLANAR it is the radius, from CURVED on zero.
    """
    share, delta2 = normal_share(factors.deltas), factors.deltas**2
    below = 1.0 - share + delta2
    squares = np.where(share < 1.0, delta2 * share / np.where(below > 0.0, below, 1.0), 1.0)
    return np.asarray(factors.radius * np.sqrt(squares))


def factorise_pairs(rings: FloatArray, centers: FloatArray) -> tuple[RingFactors, FloatArray]:
    """Factorise the ring before each ring (K, m, n), and return ``Q^T (ring - center)`` beside the factors.

    Before ring 0 comes ring 0 itself.

    The eigenvectors of the Gram matrix turn a ring's columns nearly orthogonal; the Gram matrix of the turned
    and normalised columns is then close to the unit matrix, and its Cholesky factor removes what is left.
    Unlike the normal equations this keeps the accuracy of an orthogonal factorisation, with two passes over the rings.
    """
    n_rings, _, n = rings.shape
    grams = np.empty((n_rings, n, n))
    gram_matrices(rings, centers, grams)
    V = np.ascontiguousarray(np.linalg.eigh(grams)[1][np.r_[0, : n_rings - 1]])
    turned, crossed = np.empty((n_rings, n, n)), np.empty((n_rings, n, n))
    turned_products(rings, centers, V, turned, crossed)
    D = np.sqrt(np.maximum(np.einsum("kii->ki", turned), 0.0))
    rounding = 1e-13 * D.max(axis=1, keepdims=True)
    kept = rounding < D
    inverse = np.where(kept, 1.0 / np.where(kept, D, 1.0), 0.0)
    C = turned * inverse[:, :, None] * inverse[:, None, :]
    C[:, np.arange(n), np.arange(n)] = 1.0
    L = np.linalg.cholesky(C)
    B = L.transpose(0, 2, 1) @ (D[..., None] * V.transpose(0, 2, 1))
    W, values, Vt = np.linalg.svd(B)
    products = np.linalg.solve(L, inverse[..., None] * crossed)
    return RingFactors(values=values, Vt=Vt), W.transpose(0, 2, 1) @ products
