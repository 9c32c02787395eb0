"""Edges and faces of several cells whose meshes are the images of others under a rigid motion.

Place in the flow: ``pipeline`` finds which answer which; :class:`~.skeleton.Skeleton` lays the one as the image of the
other, whichever comes first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray, distinct


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Partners:
    """What answers what, by keys of the whole part.

    Attributes
    ----------
    motion : Motion
        From the first of each pair to the second.
    edges : mapping of int to (int, bool)
        Edge to its image, and whether they run alike.
    faces : mapping of int to int
    """

    motion: Motion
    edges: Mapping[int, tuple[int, bool]]
    faces: Mapping[int, int]

    def inverse(self) -> Partners:
        """The same, from the second of each pair."""
        return Partners(
            motion=self.motion.inverse(),
            edges={b: (a, same) for a, (b, same) in self.edges.items()},
            faces={g: f for f, g in self.faces.items()},
        )


def image_nodes(  # noqa: PLR0917
    quads: IntArray,
    points: FloatArray,
    partners: Partners,
    edge_nodes: Mapping[int, IntArray],
    edges: list[int],
    add: Callable[[FloatArray], IntArray],
) -> IntArray:
    """The node of the image for every node of a face; -1 for all others.

    Parameters
    ----------
    quads : (q, 4) int64
        Of the face.
    points : (n, 3) float64
    partners : Partners
    edge_nodes : mapping of int to (k,) int64
        Nodes of all edges, by key.
    edges : list of int
        Keys of the face's edges, all of which have images.
    add : callable
        Numbers new nodes.
    """
    image = np.full(len(points), -1, dtype=np.int64)
    for key in edges:
        other, same = partners.edges[key]
        image[edge_nodes[key]] = edge_nodes[other][:: 1 if same else -1]
    inside = distinct(quads)
    inside = inside[image[inside] < 0]
    image[inside] = add(partners.motion(points[inside]))
    return image
