"""A meshed face carried to another face: the same quads, its boundary given, its inside by the map of the boundary.

Place in the flow: called by ``pipeline`` where a mesh is made like another one; caps and linking sides go alike.

Method: the nodes are seen in the parameters of their face. The least-squares affine map (functional H, n = 2) between
the parameters of the boundary there and here, plus its residual carried inwards, takes them to the parameters of the
new face, whose surface lifts them; where the quads are one grid, the residual is carried along its lines. Where the
parameters wind round the surface, the same is done in space, and the image is projected to the surface. Which of the
two is a question of topology, so that all variants of a part go the same way, and nodes move smoothly with its
parameters. A face that comes out much worse than it was is relaxed, by degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Surface
from ..errors import ProjectionError
from .affine import fit_affine
from .caps import boundary_loops
from .face_grids import carry_inside, find_grid
from .layers import project_layers
from .target import GOOD_ENOUGH, SHEARED, mean_stretch, relaxed_cap, sweep_normals, unwrapped, worst_corner


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshedFace:
    """Quads on a CAD face.

    Attributes
    ----------
    nodes : (n,) int64
        Ids of the nodes, rising.
    quads : (q, 4) int64
        As places in `nodes`.
    points : (n, 3) float64
    uv : (n, 2) float64 or None
        Parameters, in one branch and stretched to lengths in the mean; None where they wind round the surface.
    """

    nodes: IntArray
    quads: IntArray
    points: FloatArray
    uv: FloatArray | None

    def loops(self) -> tuple[IntArray, ...]:
        """Boundary cycles, as places in `nodes`, the longest first."""
        return boundary_loops(self.quads, self.points)


def meshed_face(quads: IntArray, points: FloatArray, surface: Surface) -> MeshedFace:
    """See what a face's quads (q, 4), of nodes of `points`, are in its parameters."""
    nodes, local = np.unique(quads, return_inverse=True)
    own, own_quads = points[nodes], local.reshape(-1, 4).astype(np.int64)
    loops = boundary_loops(own_quads, own)
    known = np.concatenate(loops)
    uv = surface.project(own)
    uv[known], winds = unwrapped(uv[known], loops, surface.periods)
    uv = _spread_branch(uv, own_quads, known, surface.periods)
    return MeshedFace(
        nodes=nodes.astype(np.int64),
        quads=own_quads,
        points=own,
        uv=None if winds else uv * mean_stretch(uv, surface),
    )


def _spread_branch(
    uv: FloatArray, quads: IntArray, known: IntArray, periods: tuple[float | None, float | None]
) -> FloatArray:
    """Bring the nodes inside into the branch of their neighbours, from the boundary inwards."""
    if not any(periods):
        return uv
    done = np.zeros(len(uv), dtype=bool)
    done[known] = True
    pairs = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    while not done.all():
        at_rim = pairs[done[pairs[:, 0]] & ~done[pairs[:, 1]]]
        for axis, period in enumerate(periods):
            if period:
                steps = uv[at_rim[:, 1], axis] - uv[at_rim[:, 0], axis]
                uv[at_rim[:, 1], axis] -= period * np.round(steps / period)
        done[at_rim[:, 1]] = True
    return uv


def carry_face(
    face: MeshedFace,
    boundary: FloatArray,
    loops: Sequence[IntArray],
    surface: Surface,
    *,
    shift: FloatArray | None = None,
    good: float = 1.0,
    relax: bool = True,
) -> FloatArray:
    """Place a face's nodes on another surface.

    Parameters
    ----------
    face : MeshedFace
    boundary : (b, 3) float64
        Where its boundary nodes go, on `surface`, in the order of ``np.concatenate(loops)``.
    loops : sequence of int64 arrays
        ``face.loops()``.
    shift : (n, 3) float64, optional
        How far the nodes inside move besides, along the surface.
    good : float
        Worst sine of a corner that is as good as can be had: of what answers this face.
    relax : bool
        Relax a face that comes out poor.

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    ProjectionError
        The surface gives no finite points.
    """
    known = np.concatenate(loops)
    points = np.empty_like(face.points)
    if len(known) == len(points):
        points[known] = boundary
        return points
    uv, winds = unwrapped(surface.project(boundary), loops, surface.periods)
    if winds or face.uv is None:
        image = _image(face, face.points, loops, boundary)
        points = surface.evaluate(surface.project(image))
    else:
        stretch = mean_stretch(uv, surface)
        points = surface.evaluate(_image(face, face.uv, loops, uv * stretch) / stretch)
    points[known] = boundary
    if not np.isfinite(points).all():
        raise ProjectionError("a face of the mesh cannot be carried: its surface gives no finite points")
    if shift is not None:
        points = surface.evaluate(surface.project(points + shift))
        points[known] = boundary
    if not relax:
        return points
    limit = min(SHEARED, GOOD_ENOUGH * good, GOOD_ENOUGH * worst_corner(face.points, face.quads, None))
    worst = worst_corner(points, face.quads, sweep_normals(points, face.quads, surface))
    if worst < limit:
        relaxed = relaxed_cap(points, face.points, face.quads, loops, surface)
        if relaxed is not None:
            # By degrees: of two variants on either side of the limit the nodes must not jump.
            share = min(1.0, 2.0 * (limit - worst) / abs(limit))
            points = surface.evaluate(surface.project((1.0 - share) * points + share * relaxed))
            points[known] = boundary
    return points


def _image(face: MeshedFace, there: FloatArray, loops: Sequence[IntArray], boundary: FloatArray) -> FloatArray:
    """The affine image of a face's nodes, at `there`, under the map of their boundary, the residual carried inwards."""
    known = np.concatenate(loops)
    grid = find_grid(face.quads, loops)
    if grid is None:
        sweep = project_layers(
            there, face.quads, np.stack([there[known], boundary]), loops=loops, functional="H", strategy="source"
        )
        return sweep.layer(1)
    map_ = fit_affine(there[known], boundary, "H")
    image = map_(there)
    residual = np.zeros_like(image)
    residual[known] = boundary - image[known]
    return image + carry_inside(grid, face.points, residual)
