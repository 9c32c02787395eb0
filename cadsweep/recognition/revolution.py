"""Whether a solid is one of revolution, found from its normals.

Place in the flow: asked only where no sweep was found, to give a better reason. A surface may
slip along itself by a rigid motion where its normals are square to the motion's velocity
everywhere; the motions are the null space of one 6 by 6 matrix.

References
----------
Gelfand, Guibas, "Shape segmentation using local slippage analysis", SGP 2004.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid

TOLERANCE = 1e-6
"""Share of the normals that does not turn about the axis; beyond rounding, the face is no revolution."""


def find_axis(solid: Solid) -> tuple[FloatArray, FloatArray] | None:
    """Return a point and the direction of the axis of revolution, or None.

    Returns
    -------
    (3,) float64, (3,) float64
        A point on the axis nearest to the centroid of the faces, and a unit direction; None where
        the solid is not one of revolution, or is one about many axes (a sphere).
    """
    points, normals = [], []
    for face in solid.faces:
        edges = [solid.edges[e] for e in face.edges]
        on_face = np.array([face.center, *[e.midpoint for e in edges], *[solid.vertices[e.start] for e in edges]])
        uv = face.surface.project(on_face)
        points.append(face.surface.evaluate(uv))
        normals.append(face.surface.normals(uv))
    p, n = np.concatenate(points), np.concatenate(normals)
    good = np.isfinite(n).all(axis=1)
    p, n = p[good], n[good]
    center = p.mean(axis=0)
    p = (p - center) / solid.size
    rows = np.hstack([np.cross(p, n), n])
    values, vectors = np.linalg.eigh(rows.T @ rows / len(rows))
    if values[0] > TOLERANCE or values[1] < 1e3 * max(values[0], 1e-12):
        return None
    omega, shift = vectors[:3, 0], vectors[3:, 0]
    speed = np.linalg.norm(omega)
    if speed < 1e-3 or abs(omega @ shift) > 1e-3 * speed:
        return None
    return center + np.cross(omega, shift) / speed**2 * solid.size, omega / speed
