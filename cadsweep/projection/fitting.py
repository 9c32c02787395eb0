"""Affine maps of many rings at once: from a cap to all layers, or from layer to layer.

Place in the flow: :mod:`.layers` fits every layer of a sweep with it; :func:`.fit_affine` is its case of one ring.

Method: the ring of a cap is factorised once for all layers; from layer to layer every ring is. One pass over the
rings gathers what the small systems of :mod:`.functionals` need. No loop runs over nodes or layers here.

Not handled: rings that span less than n - 1 dimensions (Remark 7), which are refused.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from .functionals import AffineMaps, RingFactors, rows_of_g, rows_of_h, solve, without_noise
from .kernels import gram_matrices, share_layers, turned_products
from .normals import RingMoments, ring_moments


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
    return _solved(
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
    return _solved(
        factors=factors,
        products=products,
        n_ring_nodes=rings.shape[1],
        source_centers=moments.centers[before],
        centers=moments.centers,
        source_normals=moments.normals[before],
        normals=moments.normals,
        functional=functional,
    )


def _solved(
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
    """Solve the systems of one functional."""
    d, images = centers - source_centers, centers
    if functional == "F":
        matrices, ranks, conditions = solve(without_noise(factors), products, None)
    elif functional == "G":
        matrices, ranks, conditions = solve(without_noise(factors), products, rows_of_g(n_ring_nodes, d))
        # (9) sends c^X to c^X + A d, which is c^Y where d is a fixed vector of A (X planar, d off its plane).
        images = source_centers + np.einsum("kij,kj->ki", matrices, d)
    else:
        rows = rows_of_h(factors, source_normals, normals) if vectors is None else (vectors[:1], vectors[1:])
        matrices, ranks, conditions = solve(factors, products, rows)
    return AffineMaps(
        matrices=matrices, source_centers=source_centers, centers=images, ranks=ranks, conditions=conditions
    )


def factorise_pairs(rings: FloatArray, centers: FloatArray) -> tuple[RingFactors, FloatArray]:
    """Factorise the ring before each ring (K, m, n), and return ``Q^T (ring - center)`` beside the factors.

    Before ring 0 comes ring 0 itself.

    The eigenvectors of the Gram matrix turn a ring's columns nearly orthogonal; the Gram matrix of the turned
    and normalised columns is then close to the unit matrix, and its Cholesky factor removes what is left.
    Unlike the normal equations this keeps the accuracy of an orthogonal factorisation, with two passes over the rings.
    """
    n_rings, _, n = rings.shape
    grams = np.empty((n_rings, n, n))
    share_layers(lambda run: gram_matrices(rings[run], centers[run], grams[run]), n_rings, rings.shape[1])
    V = np.ascontiguousarray(np.linalg.eigh(grams)[1][np.r_[0, : n_rings - 1]])
    turned, crossed = np.empty((n_rings, n, n)), np.empty((n_rings, n, n))

    def turn(run: slice) -> None:
        turned_products(rings, centers, run.start, run.stop, V, turned, crossed)

    share_layers(turn, n_rings, rings.shape[1])
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
