"""Metrics of single hexahedra and quads, as the Verdict library and VTK define them.

Place in the flow: foundation; every stage may use it. Hexes are measured by compiled loops
(:mod:`cadsweep.quality.kernels`), quads by numpy.

A hexahedron whose shape is not valid never looks good: a zero edge makes its scaled Jacobian 0 (or
less), a coordinate that is not finite makes it -1, and its condition is infinite. (VTK returns 1e30.)

Not handled here: the order-2 geometry of hex20 and hex27; their corner nodes are measured, and
:mod:`cadsweep.quality.bernstein` decides about their inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..threads import map_chunks
from . import kernels, surface_kernels


@dataclass(frozen=True, kw_only=True, eq=False)
class HexMetrics:
    """Metrics of m hexahedra; every attribute is (m,) float64.

    Attributes
    ----------
    scaled_jacobian :
        Least over the eight corners and the centre of the Jacobian over the product of the three
        edge lengths, in [-1, 1]; 1 for a box.
    aspect :
        Longest over shortest principal axis (Verdict's maximum edge ratio), 1 for a cube.
    skew :
        Largest cosine between two principal axes, 0 for a box.
    taper :
        Largest cross derivative over the shorter of its two principal axes, 0 for a parallelepiped.
    condition :
        Largest condition number of the corner Jacobians over 3, 1 for a cube; infinite where a
        corner is not positive.
    warpage :
        Least over the six faces of the cube of the cosine between opposite corner normals, as VTK
        gives it for quads: 1 for a flat face.
    volume :
        Integral of the Jacobian: exact for the trilinear hexahedron.
    bound :
        Lower bound of the Jacobian inside, over the product of the longest edges of each direction.
    """

    scaled_jacobian: FloatArray
    aspect: FloatArray
    skew: FloatArray
    taper: FloatArray
    condition: FloatArray
    warpage: FloatArray
    volume: FloatArray
    bound: FloatArray


def measure_hexes(points: FloatArray, hexes: IntArray) -> HexMetrics:
    """Measure every hexahedron.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8), (m, 20) or (m, 27) int64
        VTK node order; indices must lie in [0, n). Only the corner nodes are looked at.
    """
    out = np.empty((len(kernels.METRICS), len(hexes)))
    points, hexes = _points(points), _indices(hexes, len(points))

    def measure(chunk: slice) -> None:
        # The kernel is compiled for contiguous rows alone.
        rows = np.empty((len(out), chunk.stop - chunk.start))
        kernels.measure_hexes(points, hexes[chunk], rows)
        out[:, chunk] = rows

    for _ in map_chunks(measure, len(hexes)):
        pass
    return HexMetrics(**dict(zip(kernels.METRICS, out, strict=True)))


def scaled_jacobians(points: FloatArray, hexes: IntArray) -> FloatArray:
    """Least scaled Jacobian of every hexahedron over its corners and its centre.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8), (m, 20) or (m, 27) int64
        VTK node order; indices must lie in [0, n). Only the corner nodes are looked at.

    Returns
    -------
    (m,) float64
        In [-1, 1]; 0 or less where an edge has no length, -1 where a coordinate is not finite.
    """
    out = np.empty(len(hexes))
    points, hexes = _points(points), _indices(hexes, len(points))
    for _ in map_chunks(lambda c: kernels.scaled_jacobians_of_hexes(points, hexes[c], out[c]), len(hexes)):
        pass
    return out


def quad_scaled_jacobians(points: FloatArray, quads: IntArray) -> FloatArray:
    """Least scaled Jacobian of every quad in space.

    Each corner's sine of the angle, signed by the quad's mean normal: 1 for a rectangle, negative
    where the quad is not convex, 0 or less where an edge has no length.

    Parameters
    ----------
    points : (n, 3) or (n, 2) float64
        In the plane the sign is that of the orientation: a clockwise quad is negative.
    quads : (q, 4), (q, 8) or (q, 9) int64
        Only the corner nodes are looked at.

    Returns
    -------
    (q,) float64
        In [-1, 1], -1 where a coordinate is not finite.
    """
    points = np.asarray(points, dtype=np.float64)
    corners = points[np.asarray(quads)[:, :4]]
    edges = np.roll(corners, -1, axis=1) - corners
    before = np.roll(edges, 1, axis=1)
    lengths = np.sqrt(np.einsum("qij,qij->qi", edges, edges))
    if points.shape[1] == 2:
        areas = before[..., 0] * edges[..., 1] - before[..., 1] * edges[..., 0]
    else:
        normals = np.cross(before, edges)
        mean = np.cross(edges[:, 0] - edges[:, 2], edges[:, 1] - edges[:, 3])
        size = np.sqrt(np.einsum("qj,qj->q", mean, mean))
        mean /= np.where(size > 0, size, 1.0)[:, None]
        areas = np.einsum("qij,qj->qi", normals, mean)
    products = lengths * np.roll(lengths, 1, axis=1)
    with np.errstate(invalid="ignore"):
        values = np.min(np.where(products > 0, areas / np.where(products > 0, products, 1.0), 0.0), axis=1)
    values[~np.isfinite(corners).all(axis=(1, 2))] = -1.0
    return values


def quad_areas(points: FloatArray, quads: IntArray) -> FloatArray:
    """Area of every bilinear quad (q,) in space."""
    areas = np.empty(len(quads))
    surface_kernels.measure_areas(_points(points), np.ascontiguousarray(np.asarray(quads)[:, :4]), areas)
    return areas


def _points(points: FloatArray) -> FloatArray:
    return np.ascontiguousarray(points, dtype=np.float64)


def _indices(hexes: IntArray, n_points: int) -> IntArray:
    hexes = np.ascontiguousarray(hexes, dtype=np.int64)
    if len(hexes) and (np.min(hexes) < 0 or np.max(hexes) >= n_points):
        raise IndexError(f"hexes refer to nodes outside 0 .. {n_points - 1}")
    return hexes


def volume_and_area(points: FloatArray, quads: IntArray) -> tuple[float, float]:
    """Volume inside outward quads (q, 4), exact for bilinear ones, and their area by their diagonals."""
    if not len(quads):
        return 0.0, 0.0
    quads = np.ascontiguousarray(quads)
    # From a node of theirs: far from the origin the volumes of cones from there cancel each other.
    return surface_kernels.volume_and_area(points, quads, points[quads[0, 0]])  # type: ignore[no-any-return]
