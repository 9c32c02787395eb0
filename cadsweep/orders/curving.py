"""Where a mesh of order 2 must bend: its boundary segments on CAD edges, its boundary quads on CAD faces.

Place in the flow: ``pipeline`` hands what is found here to :func:`cadsweep.elevate.elevate`, which meets the CAD
model as callables alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.block import FactoredMesh
from ..blocks.finish import by_face
from ..blocks.joined import JoinedMesh
from ..blocks.naming import NamedFaces, name_sweep
from ..brep import Curve, Part, Surface
from ..mesh import SurfaceMesh
from ..segments import segments_by_edge
from ..sweep import Sweep

Projection = Callable[[FloatArray], FloatArray]


def project_to_edges(part: Part, sweep: Sweep, surfaces: SurfaceMesh) -> list[tuple[IntArray, Projection]]:
    """Mesh segments (s, 2) on each CAD edge, with the projection to its curve, model units."""
    last = (len(surfaces.rings) - 1) * len(surfaces.source.points)
    # The last layer of a closed ring is its first.
    n_nodes = last if sweep.closed else last + len(surfaces.source.points)
    return [
        (np.unique(np.sort(segments % n_nodes, axis=1), axis=0), _on_curve(part, sweep, edge))
        for edge, segments in segments_by_edge(sweep, surfaces).items()
    ]


def project_to_faces(part: Part, sweep: Sweep, factored: FactoredMesh) -> list[tuple[IntArray, Projection]]:
    """Quads (q, 4) of each owner on the boundary, with the projection to the nearest of its faces, model units."""
    faces: dict[tuple[str, ...], list[int]] = {}
    for (_, face, _), names in name_sweep(sweep).pieces().items():
        faces.setdefault(names, []).append(face)
    return [(quads, _on_faces(part, sweep, sorted(set(faces[names])))) for names, quads in factored.owned_quads()]


def curves_of(part: Part, mesh: JoinedMesh) -> list[tuple[IntArray, Projection]]:
    """Mesh segments (s, 2) on each CAD edge of a mesh of several cells, with the projection to its curve."""
    curves = {
        int(key): edge.curve
        for solid in part.solids
        for key, edge in zip(solid.edge_keys, solid.edges, strict=True)
        if edge.kind != "line"
    }
    return [
        (np.column_stack([nodes[:-1], nodes[1:]]), _onto_curve(part, curves[key]))
        for key, nodes in mesh.edge_nodes.items()
        if key in curves
    ]


def surfaces_of(part: Part, mesh: JoinedMesh, names: NamedFaces) -> list[tuple[IntArray, Projection]]:
    """Quads (q, 4) on each curved face of the model and on each contact, with the projection to its surface."""
    found = []
    for (cell, face), quads in by_face(mesh):
        own = part.solids[cell].faces[face]
        # Of an interface one side is enough; a cut is inside, and its middles are free. Outside a plane face holds its
        # middles by itself; between two solids it has to be told, or they follow the bow of what is around them.
        is_free = own.kind == "plane" and (cell, face) not in names.between
        if not is_free and names.of((cell, face)) and names.first.get((cell, face), True):
            found.append((quads, _onto_surfaces(part, [own.surface])))
    return found


def _on_curve(part: Part, sweep: Sweep, edge: int) -> Projection:
    return _onto_curve(part, sweep.solid.edges[edge].curve)


def _onto_curve(part: Part, curve: Curve) -> Projection:
    def project(points: FloatArray) -> FloatArray:
        return part.to_model(curve.evaluate(curve.project((points - part.offset) / part.scale)))

    return project


def _on_faces(part: Part, sweep: Sweep, faces: list[int]) -> Projection:
    return _onto_surfaces(part, [sweep.solid.faces[face].surface for face in faces])


def _onto_surfaces(part: Part, surfaces: Sequence[Surface]) -> Projection:
    def project(points: FloatArray) -> FloatArray:
        places = (points - part.offset) / part.scale
        nearest, best = np.full(len(places), np.inf), places.copy()
        for surface in surfaces:
            feet = surface.evaluate(surface.project(places))
            away = np.linalg.norm(feet - places, axis=1)
            closer = away < nearest
            nearest[closer], best[closer] = away[closer], feet[closer]
        return part.to_model(best)

    return project
