"""Sides whose ring nodes are the images of those of other sides.

Place in the flow: after the rings are built, before the cap's quads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..errors import SurfaceMeshError
from .sweep_grid import SweepGrid


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """A rigid motion: ``points @ matrix.T + shift``."""

    matrix: FloatArray
    shift: FloatArray

    def __call__(self, points: FloatArray) -> FloatArray:
        """Carry points (..., 3)."""
        return np.asarray(points @ self.matrix.T + self.shift)

    def inverse(self) -> Motion:
        """The motion back."""
        return Motion(matrix=self.matrix.T, shift=-self.matrix.T @ self.shift)

    def in_units(self, scale: float, offset: FloatArray) -> Motion:
        """The same in units of which one is `scale`, with another origin."""
        return Motion(matrix=self.matrix, shift=scale * self.shift + offset - self.matrix @ offset)


def match_sides(
    grid: SweepGrid,
    rings: FloatArray,
    node_vertices: IntArray,
    faces: tuple[frozenset[int], frozenset[int]],
    motion: Motion,
) -> None:
    """Put the ring nodes of some sides where the motion carries those of others; vertices stay.

    Raises
    ------
    SurfaceMeshError
        They do not answer each other, node by node and layer by layer.
    """
    one, other = (_nodes(grid, own) for own in faces)
    image = motion(rings[one[:, 0], one[:, 1]])
    _, index = scipy.spatial.cKDTree(rings[other[:, 0], other[:, 1]]).query(image)
    if len(one) != len(other) or len(np.unique(index)) != len(one) or (one[:, 0] != other[index, 0]).any():
        raise SurfaceMeshError(
            f"periodic faces have {len(one)} and {len(other)} nodes that do not answer each other layer by layer"
        )
    place = other[index]
    free = (node_vertices[place[:, 0], place[:, 1]] < 0) & (place != one).any(axis=1)
    rings[place[free, 0], place[free, 1]] = image[free]


def _nodes(grid: SweepGrid, faces: frozenset[int]) -> IntArray:
    """Layers and columns (m, 2) of the nodes of sides."""
    found = []
    for side in grid.sides:
        if side.side.face in faces:
            layers, columns = np.broadcast_arrays(*grid.block(side))
            found.append(np.stack([layers.ravel(), columns.ravel()], axis=1))
    return np.unique(np.concatenate(found), axis=0)
