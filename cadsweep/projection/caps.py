"""The target cap, face by face: where the source mesh meets the CAD surfaces at the other end.

Place in the flow: between ``surface`` and ``projection.project_layers``; called by ``pipeline``. It says
which target face answers each source face, and where the nodes on the edges between target faces
are; :func:`cadsweep.projection.target.project_target` places the rest of each face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import ProjectionError
from ..mesh import SurfaceMesh
from ..sweep import Sweep
from .target import project_target


@dataclass(frozen=True, kw_only=True, eq=False)
class PlacedCap:
    """The target cap's nodes.

    Attributes
    ----------
    points : (n, 3) float64
        In the order of the source's nodes.
    faces : (q,) int64
        Face id of the solid that each quad lies on.
    notes : tuple of str
        How each face was placed.
    """

    points: FloatArray
    faces: IntArray
    notes: tuple[str, ...]


def place_target(sweep: Sweep, surfaces: SurfaceMesh) -> PlacedCap:
    """Carry the source mesh to the target cap.

    Raises
    ------
    ProjectionError
        A target of several faces that the faces of the source do not answer.
    """
    source = surfaces.source
    ring = np.concatenate(source.loops)
    if len(sweep.target) == 1:
        face = sweep.target[0]
        cap = project_target(
            source.points, source.quads, source.loops, surfaces.rings[-1], surface=sweep.solid.faces[face].surface
        )
        note = f"target {sweep.solid.faces[face].label()} placed the {cap.method} way, worst quad {cap.min_quality:.2f}"
        return PlacedCap(points=cap.points, faces=np.full(len(source.quads), face, dtype=np.int64), notes=(note,))
    if not sweep.target_faces:
        raise ProjectionError(
            f"the target has {len(sweep.target)} faces and the source {len(sweep.source)}, and they do not correspond"
        )
    points = np.full(source.points.shape, np.nan)
    points[ring] = surfaces.rings[-1]
    for edge, (target_edge, forward) in sweep.target_edges.items():
        places = surfaces.target_edge_points.get(target_edge)
        if places is not None:
            points[source.edge_nodes[edge]] = places if forward else places[::-1]
    points[ring] = surfaces.rings[-1]
    faces = np.empty(len(source.quads), dtype=np.int64)
    notes = []
    for source_face, target_face in sweep.target_faces.items():
        mine = source.faces == source_face
        faces[mine] = target_face
        nodes, local = np.unique(source.quads[mine], return_inverse=True)
        quads = local.reshape(-1, 4).astype(np.int64)
        loops = boundary_loops(quads, source.points[nodes])
        known = np.concatenate(loops)
        cap = project_target(
            source.points[nodes],
            quads,
            loops,
            points[nodes[known]],
            surface=sweep.solid.faces[target_face].surface,
        )
        points[nodes] = cap.points
        label = sweep.solid.faces[target_face].label()
        notes.append(f"target {label} placed the {cap.method} way, worst quad {cap.min_quality:.2f}")
    return PlacedCap(points=points, faces=faces, notes=tuple(notes))


def boundary_loops(quads: IntArray, points: FloatArray) -> tuple[IntArray, ...]:
    """Boundary cycles of a quad mesh, the longest first, each with the mesh on its left."""
    n = int(np.max(quads)) + 1
    edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    key = edges[:, 0] * n + edges[:, 1]
    twin = edges[:, 1] * n + edges[:, 0]
    following = dict(edges[~np.isin(key, twin)].tolist())
    loops = []
    while following:
        start, node = next(iter(following.items()))
        del following[start]
        loop = [start]
        while node != start:
            loop.append(node)
            node = following.pop(node)
        loops.append(np.array(loop, dtype=np.int64))
    lengths = [np.linalg.norm(points[loop] - points[np.roll(loop, -1)], axis=1).sum() for loop in loops]
    return tuple(loops[i] for i in np.argsort(lengths)[::-1])
