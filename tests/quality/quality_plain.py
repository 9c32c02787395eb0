"""What the compiled kernels compute, said in plain numpy, one formula a metric."""

from __future__ import annotations

import numpy as np

CORNERS = np.array(
    [[0, 1, 3, 4], [1, 2, 0, 5], [2, 3, 1, 6], [3, 0, 2, 7], [4, 7, 5, 0], [5, 4, 6, 1], [6, 5, 7, 2], [7, 6, 4, 3]]
)
SIGNS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
QUAD_FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])


def principal_axes(p):
    """Sums (m, 3, 3) of the four edges along xi, eta and zeta of hexes p (m, 8, 3)."""
    return np.einsum("na,mnc->mac", SIGNS, p)


def cross_axes(p):
    """Cross derivatives (m, 3, 3): xi eta, xi zeta, eta zeta."""
    pairs = np.stack([SIGNS[:, 0] * SIGNS[:, 1], SIGNS[:, 0] * SIGNS[:, 2], SIGNS[:, 1] * SIGNS[:, 2]], axis=1)
    return np.einsum("na,mnc->mac", pairs, p)


def corner_edges(p):
    """Edges (m, 8, 3, 3) out of every corner."""
    return p[:, CORNERS[:, 1:]] - p[:, CORNERS[:, :1]]


def scaled_jacobian(p):
    frames = np.concatenate([corner_edges(p), principal_axes(p)[:, None]], axis=1)
    lengths = np.linalg.norm(frames, axis=3).prod(axis=2)
    return np.min(np.linalg.det(frames) / lengths, axis=1)


def aspect(p):
    lengths = np.linalg.norm(principal_axes(p), axis=2)
    return lengths.max(axis=1) / lengths.min(axis=1)


def skew(p):
    axes = principal_axes(p)
    unit = axes / np.linalg.norm(axes, axis=2, keepdims=True)
    cosines = np.abs(np.einsum("mac,mbc->mab", unit, unit))
    return np.max(cosines[:, [0, 0, 1], [1, 2, 2]], axis=1)


def taper(p):
    lengths = np.linalg.norm(principal_axes(p), axis=2)
    cross = np.linalg.norm(cross_axes(p), axis=2)
    return np.max(cross / np.minimum(lengths[:, [0, 0, 1]], lengths[:, [1, 2, 2]]), axis=1)


def condition(p):
    """Frobenius norm of the corner Jacobian times that of its inverse, over 3; infinite if not positive."""
    frames = corner_edges(p)
    det = np.linalg.det(frames)
    adjugate = np.stack([np.cross(frames[..., (i + 1) % 3, :], frames[..., (i + 2) % 3, :]) for i in range(3)], axis=-2)
    number = np.linalg.norm(frames, axis=(2, 3)) * np.linalg.norm(adjugate, axis=(2, 3)) / (3 * det)
    return np.where(np.all(det > 0, axis=1), np.max(number, axis=1), np.inf)


def warpage(p):
    q = p[:, QUAD_FACES]
    edges = np.roll(q, -1, axis=2) - q
    normals = np.cross(np.roll(edges, 1, axis=2), edges)
    normals /= np.linalg.norm(normals, axis=3, keepdims=True)
    cosines = np.einsum("mfic,mfic->mfi", normals[:, :, :2], normals[:, :, 2:])
    return np.min(cosines**3, axis=(1, 2))


def jacobian_at(p, places):
    """Jacobian determinant (m, s) of trilinear hexes at places (s, 3) of the unit cube."""
    half = (SIGNS + 1) / 2
    factors = np.where(half[None], places[:, None], 1 - places[:, None])  # (s, 8, 3)
    rows = []
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        slopes = SIGNS[:, axis] * factors[:, :, others].prod(axis=2)
        rows.append(np.einsum("sn,mnc->msc", slopes, p))
    return np.linalg.det(np.stack(rows, axis=2))


def volume(p):
    """Two Gauss points a direction: exact for degree 3."""
    line = 0.5 + np.array([-1, 1]) / np.sqrt(12)
    places = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)
    return jacobian_at(p, places).mean(axis=1)
