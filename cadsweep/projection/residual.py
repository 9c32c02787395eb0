"""What the affine maps miss on the rings, carried into the interior of every layer.

Place in the flow: :mod:`.layers` hands over the residuals ``ring_k - phi_k(ring_0)`` of all layers and gets back a
few columns of the basis and their coefficients.

Method. The residuals are one matrix (ring nodes x layers and components) of low rank. Its leading singular vectors are
found by a randomised range finder, and each is extended into the interior by a harmonic solve on the caps' quads. The
weights are cotangents, averaged over both diagonals of each quad (on right-angled quads the five-point stencil), and
over both caps where both are known: the extension is then exact for residuals that are linear in the cap's plane, and
the same whichever cap is called the source.

Not handled here: residuals so large that the carry folds a layer; ``smoothing`` mends those.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, others
from ..errors import InputError
from .inputs import loop_slices

log = logging.getLogger(__name__)

TOLERANCE = 1e-4
"""A residual below this fraction of the shortest ring segment is not carried: no quad feels it."""
NOISE = 1e-6
"""Nor is one below this fraction of the source ring's r.m.s. radius, however short the shortest segment is: CAD kernels
keep seams and rebuilt curves no better than that, and their noise must not become modes."""
MAX_MODES = 64
"""Modes of the residual at most: more would cost as much as the residuals that they stand for."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RingModes:
    """Residuals as ``residuals[k, i] ~ sum_j shapes[i, j] * amplitudes[k, j]``.

    Attributes
    ----------
    shapes : (b, q) float64
        Greatest entry of every column is 1.
    amplitudes : (n_layers + 1, q, n) float64
        Lengths.
    remainder : float
        Greatest distance that is left at a ring node.
    """

    shapes: FloatArray
    amplitudes: FloatArray
    remainder: float


def shortest_segment(rings: FloatArray, loops: Sequence[IntArray]) -> float:
    """Length of the shortest ring segment of all layers, coinciding nodes left out."""
    shortest = np.inf
    for s in loop_slices(loops):
        loop = rings[:, s]
        lengths = np.linalg.norm(np.roll(loop, -1, axis=1) - loop, axis=-1)
        apart = lengths[lengths > 1e-9 * np.max(lengths)]
        shortest = min(shortest, float(np.min(apart, initial=np.inf)))
    return shortest


def carry_tolerance(rings: FloatArray, loops: Sequence[IntArray], fraction: float) -> float:
    """Residuals up to this length are left to the rings alone."""
    local = rings[0] - rings[0].mean(axis=0)
    radius = float(np.sqrt(np.mean(np.sum(local**2, axis=1))))
    return max(fraction * shortest_segment(rings, loops), NOISE * radius)


def compress(residuals: FloatArray, tolerance: float, *, max_modes: int = MAX_MODES) -> RingModes:
    """Find the fewest modes that leave every residual (K, b, n) within `tolerance`, a length."""
    n_layers, b, n = residuals.shape
    worst = float(np.sqrt(np.max(np.einsum("kic,kic->ki", residuals, residuals))))
    if worst <= tolerance:
        return RingModes(shapes=np.empty((b, 0)), amplitudes=np.empty((n_layers, 0, n)), remainder=worst)
    # Columns are scaled by the worst residual, so that squares neither overflow nor vanish in any unit of length.
    M = np.ascontiguousarray(residuals.transpose(1, 0, 2)).reshape(b, n_layers * n) / worst
    U, s, Vt = _leading_modes(M, tolerance / worst, max_modes)
    left = M
    n_modes, remainder = 0, 1.0
    while remainder * worst > tolerance and n_modes < len(s):
        left = left - np.outer(U[:, n_modes] * s[n_modes], Vt[n_modes])
        remainder = _greatest(left, n)
        n_modes += 1
    if remainder * worst > max(tolerance, 1e-2 * tolerance / TOLERANCE):
        log.warning("%d residual modes leave %.3g at the rings", n_modes, remainder * worst)
    U, s, Vt = U[:, :n_modes], s[:n_modes], Vt[:n_modes]
    peaks = np.abs(U).max(axis=0)
    signs = np.sign(U[np.abs(U).argmax(axis=0), np.arange(n_modes)])
    amplitudes = (s * peaks * signs * worst)[:, None] * Vt
    return RingModes(
        shapes=U * (signs / peaks),
        amplitudes=np.ascontiguousarray(amplitudes.reshape(n_modes, n_layers, n).transpose(1, 0, 2)),
        remainder=remainder * worst,
    )


def _greatest(M: FloatArray, n: int) -> float:
    """Greatest node distance in a matrix whose rows hold n components per layer."""
    rows = M.reshape(len(M), -1, n)
    return float(np.sqrt(np.max(np.einsum("ikc,ikc->ik", rows, rows))))


def _leading_modes(M: FloatArray, tolerance: float, max_modes: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Singular triplets of M (b, p): by a randomised range finder where few are enough, all of them otherwise."""
    size = min(M.shape)
    random = np.random.default_rng(0)
    for guess in (12, max_modes + 8):
        if 4 * guess > size:
            break
        Q = np.linalg.qr(M @ (M.T @ np.linalg.qr(M @ random.standard_normal((M.shape[1], guess)))[0]))[0]
        small = Q.T @ M
        if guess > max_modes or np.abs(M - Q @ small).max() <= 0.1 * tolerance:
            U, s, Vt = np.linalg.svd(small, full_matrices=False)
            return (Q @ U)[:, :max_modes], s[:max_modes], Vt[:max_modes]
    U, s, Vt = np.linalg.svd(M, full_matrices=False)
    return U[:, :max_modes], s[:max_modes], Vt[:max_modes]


def cotangent_weights(points: FloatArray, quads: IntArray) -> scipy.sparse.csr_matrix:
    """Symmetric weights (n, n) of the mesh's node pairs: cotangents averaged over both diagonals of every quad.

    The area of a triangle flatter than 1e-6 is raised to that, which keeps the weights finite and the system definite:
    coinciding nodes are tied to each other.
    """
    n_nodes = len(points)
    rows, cols, values = [], [], []
    for triangle in ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)):
        nodes = quads[:, triangle]
        edges = points[np.roll(nodes, -1, axis=1)] - points[nodes]
        squares = np.einsum("tei,tei->te", edges, edges)
        dots = -np.einsum("tei,tei->te", edges, np.roll(edges, 1, axis=1))
        # Lagrange: |p x q|^2 = |p|^2 |q|^2 - (p q)^2, the same at every corner but for rounding.
        doubled = np.sqrt(np.maximum(squares * np.roll(squares, 1, axis=1) - dots**2, 0.0)).max(axis=1)
        flat = 1e-6 * squares.max(axis=1) + 1e-300
        values.append(0.25 * dots / np.maximum(doubled, flat)[:, None])
        rows.append(np.roll(nodes, -1, axis=1))
        cols.append(np.roll(nodes, 1, axis=1))
    row, col = np.concatenate(rows).ravel(), np.concatenate(cols).ravel()
    half = scipy.sparse.coo_matrix((np.concatenate(values).ravel(), (row, col)), shape=(n_nodes, n_nodes)).tocsr()
    return (half + half.T).tocsr()


def extend(weights: scipy.sparse.csr_matrix, boundary: IntArray, values: FloatArray) -> FloatArray:
    """Extend boundary values (b, q) to all nodes (n, q) as discrete harmonic functions.

    Raises
    ------
    InputError
        A node hangs on no boundary node through the mesh.
    """
    n_nodes = weights.shape[0]
    result = np.empty((n_nodes, values.shape[1]))
    result[boundary] = values
    inside = others(n_nodes, boundary)
    if not len(inside):
        return result
    _refuse_loose(weights, boundary, inside)
    off = weights - scipy.sparse.diags(weights.diagonal())
    laplacian = (scipy.sparse.diags(np.asarray(off.sum(axis=1)).ravel()) - off).tocsr()
    system = laplacian[inside][:, inside].tocsc()
    rhs = -laplacian[inside][:, boundary] @ values
    solver = scipy.sparse.linalg.splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    result[inside] = solver.solve(np.asfortranarray(rhs))
    return result


def _refuse_loose(weights: scipy.sparse.csr_matrix, boundary: IntArray, inside: IntArray) -> None:
    _, labels = scipy.sparse.csgraph.connected_components(weights, directed=False)
    loose = inside[~np.isin(labels[inside], labels[boundary])]
    if len(loose):
        raise InputError(
            f"node {loose[0]} ({len(loose)} in all) is joined to no boundary node by the quads, so nothing says "
            "where it goes; leave it out of `source_points`"
        )
