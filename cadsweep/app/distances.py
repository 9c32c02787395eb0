"""How far each quad of a boundary is from the CAD faces: for looking at, not for checking.

Place in the flow: called in the child that has made the mesh.

Method: a quad is of those faces on which all of its corners lie; its distance is that of its middle and of the middles
of its sides. Where a part has so many faces that to ask them all takes long, those of the boundary's name are asked.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Part
from ..mesh import HexMesh

ON_IT = 1e-6
"""Distance of a corner from its face over the part's size: nodes are placed far better, files round to this."""
MOST_ASKED = 3_000_000
"""Faces times quads."""


def find_distances(mesh: HexMesh, part: Part) -> dict[str, FloatArray]:
    """Distances (q,), model units, of the quads of every boundary by name; nan where no face is found."""
    faces = [face for solid in part.solids for face in solid.faces]
    size = max(solid.size for solid in part.solids)
    return {
        name: _of_boundary(name, mesh.points, quads[:, :4], faces, part, size)
        for name, quads in mesh.boundaries.items()
    }


def _of_boundary(  # noqa: PLR0917
    name: str, points: FloatArray, quads: np.ndarray, faces: list[Face], part: Part, size: float
) -> FloatArray:
    named = [face for face in faces if name in face.names]
    if not named and len(faces) * len(quads) > MOST_ASKED:
        return np.full(len(quads), np.nan)
    used, inverse = np.unique(quads, return_inverse=True)
    corners = inverse.reshape(quads.shape)
    places = (points[used] - part.offset) / part.scale
    found = np.full(len(quads), np.inf)
    for face in named or faces:
        on_it = face.surface.distance(places, close=ON_IT * size) <= ON_IT * size
        own = np.flatnonzero(on_it[corners].all(axis=1) & ~(found == 0.0))
        if not len(own):
            continue
        if face.kind == "plane":
            found[own] = 0.0
            continue
        at = places[corners[own]]
        between = np.concatenate([at.mean(axis=1)[None], *((at[:, j] + at[:, j - 1])[None] / 2 for j in range(4))])
        off = face.surface.distance(between.reshape(-1, 3)).reshape(5, -1).max(axis=0)
        found[own] = np.minimum(found[own], off)
    return np.where(np.isfinite(found), found * part.scale, np.nan)
