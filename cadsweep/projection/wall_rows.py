"""Rows of nodes along walls kept at their heights in every layer.

Place in the flow: a section's rows are carried like all its nodes, so that their heights grow and shrink with the
section. Before and after :func:`project_layers` the pipeline asks here where they should be; the layers are then
placed once more with these nodes known.

Method: a column of row nodes stays on its line, which the affine map has made of that on the source, but at a corner,
where it takes the line that gains height from both walls alike. Along it the nodes go to where their distance from the
wall, seen along the wall's own normal, is what was asked for.

Not handled: walls so curved that their normals turn over the height of the layers.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..asked import layer_heights
from ..mesh import WallRows
from .residual import cotangent_weights, extend

_CORNER = np.radians(8)
"""Angle between the normals of two walls from which on they meet in a corner."""
_LEAST_RATE = 0.15
"""Height gained per length of a column below which it is left as it is: it runs along the wall."""


def rows_at_heights(
    rows: FloatArray, wall: tuple[FloatArray, FloatArray, FloatArray], asked: WallRows, own: FloatArray
) -> FloatArray:
    """Put the nodes of columns where their heights are those asked for.

    Parameters
    ----------
    rows : (k, c, n, 3) float64
        Nodes of the columns in k layers.
    wall : (k, c, 3), (k, c, 2, 3), (k, c, 2, 3) float64
        Where the columns begin on the wall; the nodes of the rings before and behind these; unit normals of the wall
        into the solid, of the faces before and behind, NaN where there is no wall.
    asked : WallRows
    own : (c,) float64
        Lengths of the columns on the source.

    Returns
    -------
    (k, c, n, 3) float64
    """
    base, beside, normals = wall
    step = rows[:, :, -1] - base
    length = np.linalg.norm(step, axis=-1)
    along = step / np.maximum(length, 1e-300)[..., None]
    corner = np.einsum("kcd,kcd->kc", normals[:, :, 0], normals[:, :, 1]) < np.cos(_CORNER)
    along[corner] = _into_corner(beside[corner] - base[corner][:, None], normals[corner])
    rates = np.einsum("kcd,kcsd->kcs", along, normals)
    known = np.isfinite(rates)
    rate = np.where(known, rates, 0.0).sum(axis=2) / np.maximum(known.sum(axis=2), 1)
    good = known.any(axis=2) & (np.where(known, rates, 1.0).min(axis=2) > _LEAST_RATE)
    rate = np.where(good, rate, 1.0)
    room = asked.room * length / np.maximum(own, 1e-300) * rate
    shape = rate.shape
    first, growth = (np.broadcast_to(values, shape).ravel() for values in (asked.first, asked.growth))
    heights = layer_heights(first, growth, rows.shape[2], room.ravel()).reshape(*shape, -1)
    placed = base[:, :, None] + (heights / rate[..., None])[..., None] * along[:, :, None]
    return np.where(good[..., None, None], placed, rows)


def _into_corner(edges: FloatArray, normals: FloatArray) -> FloatArray:
    """Unit directions (m, 3) in the plane of two edges (m, 2, 3) that gain as much height from both walls there."""
    gains = np.einsum("med,mfd->mfe", edges, normals)
    flat = np.abs(np.linalg.det(gains)) < 1e-12 * np.square(edges).sum(axis=(1, 2))
    weights = np.linalg.solve(np.where(flat[:, None, None], np.eye(2), gains), np.ones((len(edges), 2, 1)))[..., 0]
    direction = np.einsum("me,med->md", weights, edges)
    return np.asarray(direction / np.maximum(np.linalg.norm(direction, axis=1), 1e-300)[:, None])


def carry_inwards(
    points: FloatArray, quads: IntArray, fixed: IntArray, moved: IntArray, places: FloatArray
) -> FloatArray:
    """Move some nodes (m,) of a cap to their places (m, 3), and those between them and the fixed ones along."""
    known = np.concatenate([fixed, moved])
    shifts = np.concatenate([np.zeros((len(fixed), 3)), places - points[moved]])
    out = points + extend(cotangent_weights(points, quads), known, shifts)
    out[fixed], out[moved] = points[fixed], places
    return np.asarray(out)
