"""Hexahedra of order p that the bend of the CAD made invalid: their nodes are moved, on the CAD, until they are valid.

Place in the flow: :func:`cadsweep.orders.elevate.elevate` comes here with what its proof found.

Method. Around the hexahedra that are not valid, a patch: them, and rings of neighbours, one more each time that the
ones before did not do. Its nodes move but for corners and those that hexahedra outside the patch use, too: freely
inside, along a CAD face or edge where they are on one, and are brought back onto it. Minimised is the regularised shape
energy of smoothing (:mod:`cadsweep.smoothing.energy`), here of the Jacobian relative to that of the hexahedron of order
1 at the same place, at points that crowd towards the corners: what is bent is worth what it is bent by, so that
neighbours take their share. A patch counts once its hexahedra are proven valid.

Not handled: moving corners. Where the CAD's own edges bend a corner flat, nothing here helps.

References
----------
Garanzha et al., "Foldover-free maps in 50 lines of code", ACM Trans. Graph. 40 (2021). Toulorge, Geuzaine, Remacle,
Lambrechts, "Robust untangling of curvilinear meshes", J. Comput. Phys. 254 (2013).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, distinct
from ..lattice import Lattice, lexicographic, quad_lexicographic
from ..projection.descent import minimise
from ..quality import positive_inside
from ..quality.bernstein import with_inner_nodes
from .placing import OnCad, Projection, skin_without

RINGS = 3
"""Rings of neighbours at most: the bend of a chord is carried no farther than a few rows."""

_ROUNDS = 24
_STEPS = 12
_VOLUME_WEIGHT = 0.05
_CHUNK = 64


def mended(
    points: FloatArray, hexes: IntArray, lattice: Lattice, bad: IntArray, *, curves: OnCad, surfaces: OnCad
) -> tuple[FloatArray, IntArray]:
    """Points with which more of the hexahedra are valid, and those that still are not.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 20) or (m, (p + 1)^3) int64
        Of `lattice`, their first nodes.
    bad : (b,) int64
        Hexahedra that are not valid.
    curves, surfaces
        As of :func:`cadsweep.orders.elevate.elevate`.
    """
    tracks = _tracks(points, lattice, curves, surfaces)
    for rings in range(1, RINGS + 1):
        patch = _grown(hexes, len(points), bad, rings)
        moved = _relaxed(points, hexes, lattice, patch, tracks)
        # Outside the patch no hexahedron has a node that moved.
        after = patch[~positive_inside(moved, hexes[patch])[0]]
        if len(after) < len(bad):
            points, bad = moved, after
        if not len(bad):
            break
    return points, bad


class _Tracks(NamedTuple):
    """What every node (n,) may do: the number of its curve or surface, -1 inside, -2 where it stays."""

    of: IntArray
    projections: list[Projection | None]
    n_curves: int
    segments: list[IntArray]
    quads: list[IntArray]


def _tracks(points: FloatArray, lattice: Lattice, curves: OnCad, surfaces: OnCad) -> _Tracks:
    of = np.full(len(points), -1, dtype=np.int64)
    segments = [np.hstack([s[:, :1], lattice.edge_nodes(s), s[:, 1:]]) for s, _ in curves]
    quads = [lattice.quads(q) for q, _ in surfaces]
    for number, own in enumerate([*segments, *quads]):
        nodes = distinct(own.ravel())
        known = of[nodes]
        # Between two faces and on no curve that is known a node has no way to go.
        of[nodes] = np.where(
            known == -1, number, known if number < len(segments) else np.where(known < len(segments), known, -2)
        )
    of[distinct(lattice.quads(skin_without(lattice.hexes[:, :8], [q for q, _ in surfaces])).ravel())] = -2
    of[: lattice.first] = -2
    return _Tracks(of, [project for _, project in [*curves, *surfaces]], len(segments), segments, quads)


def _grown(hexes: IntArray, n_nodes: int, bad: IntArray, rings: int) -> IntArray:
    """The hexahedra with `rings` rings of neighbours at their corners."""
    corners = hexes[:, :8]
    inside = np.zeros(len(hexes), dtype=bool)
    inside[bad] = True
    for _ in range(rings):
        touched = np.zeros(n_nodes, dtype=bool)
        touched[corners[inside]] = True
        np.any(touched[corners], axis=1, out=inside)
    return np.flatnonzero(inside)


def _relaxed(points: FloatArray, hexes: IntArray, lattice: Lattice, patch: IntArray, tracks: _Tracks) -> FloatArray:
    """Points with the nodes of the patch where its energy is least."""
    outside = np.ones(len(hexes), dtype=bool)
    outside[patch] = False
    is_free = np.zeros(len(points), dtype=bool)
    is_free[hexes[patch]] = True
    is_free[hexes[outside]] = False
    is_free &= tracks.of != -2
    free = np.flatnonzero(is_free)
    if not len(free):
        return points
    points = points.copy()
    energy = _Energy(points, hexes[patch], is_free, lattice.order)
    for _ in range(_ROUNDS):
        energy.allowed = _allowed(points, free, tracks, lattice.order)
        energy.eps = 1e-3
        energy(points[free])
        energy.eps = float(np.sqrt(1e-6 + 0.04 * min(energy.least, 0.0) ** 2))
        found, _ = minimise(energy, points[free], energy.softened, n_steps=_STEPS)
        points[free] = found
        for number in np.unique(tracks.of[free]).tolist():
            project = tracks.projections[number] if number >= 0 else None
            if project is not None:
                own = free[tracks.of[free] == number]
                points[own] = project(points[own])
        if positive_inside(points, hexes[patch])[0].all():
            break
    return points


def _allowed(points: FloatArray, free: IntArray, tracks: _Tracks, order: int) -> Callable[[FloatArray], FloatArray]:
    """What is left of movements (f, 3) of the free nodes: along their curve, in the tangent plane of their face."""
    along, across = np.zeros_like(points), np.zeros_like(points)
    present = set(np.unique(tracks.of[free]).tolist())
    for number, own in enumerate(tracks.segments):
        if number in present:
            np.add.at(along, own, np.gradient(points[own], axis=1))
    table = quad_lexicographic(order)
    n = order + 1
    for number, own in enumerate(tracks.quads, start=tracks.n_curves):
        if number in present:
            nodes = own[:, table]
            grid = points[nodes].reshape(-1, n, n, 3)
            normals = np.cross(np.gradient(grid, axis=2), np.gradient(grid, axis=1))
            np.add.at(across, nodes, normals.reshape(-1, n * n, 3))
    of = tracks.of[free]
    on_curve, on_face = (of >= 0) & (of < tracks.n_curves), of >= tracks.n_curves
    directions = np.where(on_curve[:, None], along[free], across[free])
    lengths = np.linalg.norm(directions, axis=1)
    directions /= np.where(lengths > 0.0, lengths, 1.0)[:, None]

    def allowed(moves: FloatArray) -> FloatArray:
        own = (moves * directions).sum(axis=1)[:, None] * directions
        return np.where(on_curve[:, None], own, np.where(on_face[:, None], moves - own, moves))

    return allowed


class _Energy:
    """Energy of hexahedra and its gradient, as a function of the free nodes' places."""

    def __init__(self, points: FloatArray, hexes: IntArray, is_free: BoolArray, order: int) -> None:
        self.x, self.hexes, self.free = points.copy(), hexes, is_free
        at = 0.5 - 0.5 * np.cos(np.pi * np.arange(order + 3) / (order + 2))
        slopes = _slopes(order, at)
        if hexes.shape[1] == 20:
            slopes = slopes @ with_inner_nodes(np.eye(20)[None])[0]
        self.slopes = slopes.reshape(-1, slopes.shape[2])
        corners = points[hexes[:, :8]]
        straight = np.einsum("dqa,mac->mqcd", _slopes(1, at), corners, optimize=True)
        self.inverse = np.linalg.inv(straight)
        self.eps, self.least = 1e-3, -np.inf
        self.allowed: Callable[[FloatArray], FloatArray] = lambda moves: moves
        # How softly a node is held: one over the diagonal of the energy's curvature where nothing is bent, about.
        stiff = np.einsum("mqde,dqa->ma", self.inverse**2, slopes**2, optimize=True)
        held = np.bincount(hexes.ravel(), weights=stiff.ravel(), minlength=len(points))
        self.softness = 1.0 / np.maximum(held, 1e-300)

    def softened(self, moves: FloatArray) -> FloatArray:
        """Movements of the free nodes as far as they are soft, where they may go."""
        return self.allowed(moves * self.softness[self.free, None])

    def __call__(self, free: FloatArray) -> tuple[float, FloatArray]:
        self.x[self.free] = free
        gradient = np.zeros_like(self.x)
        total, self.least = 0.0, np.inf
        for first in range(0, len(self.hexes), _CHUNK):
            hexes = self.hexes[first : first + _CHUNK]
            inverse = self.inverse[first : first + _CHUNK]
            # One large product instead of one a hexahedron.
            along = self.slopes @ self.x[hexes].transpose(1, 0, 2).reshape(hexes.shape[1], -1)
            jacobian = along.reshape(3, -1, len(hexes), 3).transpose(2, 1, 3, 0) @ inverse
            energy, turned, least = _distortion(jacobian, self.eps)
            total += energy
            self.least = min(self.least, least)
            turned = (turned @ inverse.swapaxes(2, 3)).transpose(3, 1, 0, 2)
            moved = self.slopes.T @ turned.reshape(len(self.slopes), -1)
            np.add.at(gradient, hexes, moved.reshape(-1, len(hexes), 3).transpose(1, 0, 2))
        if not np.isfinite(total):
            return np.inf, np.zeros_like(free)
        return total, self.allowed(gradient[self.free])


def _distortion(jacobian: FloatArray, eps: float) -> tuple[float, FloatArray, float]:
    """Sum of the shape energy of Jacobians (m, q, 3, 3), its derivative by them, and their least determinant."""
    a, b, c = (jacobian[..., i] for i in range(3))
    cofactor = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    det = (a * cofactor[..., 0]).sum(axis=-1)
    root = np.sqrt(eps * eps + det * det)
    # For negative determinants the sum cancels; the product form does not.
    chi = np.where(det > 0.0, 0.5 * (det + root), 0.5 * eps * eps / (root + np.abs(det)))
    slope = chi / root
    norm = (jacobian**2).sum(axis=(-1, -2))
    scale = chi ** (-2.0 / 3.0)
    energy = norm * scale / 3.0 + _VOLUME_WEIGHT * (1.0 + det * det) / (2.0 * chi)
    across = -(2.0 / 9.0) * norm * scale / chi * slope
    across += _VOLUME_WEIGHT * (det / chi - (1.0 + det * det) * slope / (2.0 * chi * chi))
    turned = (2.0 / 3.0 * scale)[..., None, None] * jacobian + across[..., None, None] * cofactor
    return float(energy.sum()), turned, float(det.min())


def _slopes(order: int, at: FloatArray) -> FloatArray:
    """Derivatives (3, q, nodes) of the shape functions, nodes in VTK's order, at the tensor product of `at`."""
    degree, nodes = np.arange(order + 1), np.arange(order + 1) / order
    to_powers = np.linalg.inv(nodes[:, None] ** degree)
    values = at[:, None] ** degree @ to_powers
    lower = np.maximum(degree - 1, 0)
    slopes = (degree * at[:, None] ** lower) @ to_powers
    result = np.empty((3, len(at) ** 3, (order + 1) ** 3))
    for axis in range(3):
        i, j, k = (slopes if axis == own else values for own in range(3))
        result[axis][:, lexicographic(order)] = np.einsum("zk,yj,xi->zyxkji", k, j, i).reshape(result[axis].shape)
    return result
