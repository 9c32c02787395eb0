"""Solids a small clearance apart, whose facets cross though the model keeps apart: they come nearer to their faces.

Place in the flow: the last step of :mod:`.assemblies`, when the meshes of all groups are put together.

Of a shaft in a bore the facets of the bore reach inward. Whose boundary crosses another's is meshed again to a
tolerance, which divides arcs and leaves the rest as it is.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import cKDTree

from ...arrays import FloatArray
from ...blocks.block_mesh import BlockMesh
from ...errors import CadSweepError, InvertedHexError
from ..origin import AnyMesh
from ..run import Run

log = logging.getLogger(__name__)

_NEARER = (0.25, 0.06, 0.015)
"""Tolerances that are tried, over how far a mesh is off its faces: halved, quartered chords and less."""
_SAME = 1e-9
"""Distance of two nodes that are one, over the extent of the mesh."""

Groups = Sequence[tuple[list[int], AnyMesh]]
"""Cells that hang together, and their mesh."""


def put_clear(
    made: Groups, put: Callable[[Groups], AnyMesh], make: Callable[[list[int], float], AnyMesh], run: Run
) -> AnyMesh:
    """One mesh of those of all groups; those that cross others are made again, as near to the CAD as that takes.

    Parameters
    ----------
    made : sequence of (list of int, mesh)
    put : callable
        Makes one mesh of several.
    make : callable
        Meshes a group of cells to a tolerance, model units.
    run : Run

    Raises
    ------
    InvertedHexError
        They cross still.
    """
    off = [float(mesh.info.get("distance") or 0.0) for _, mesh in made]
    for share in _NEARER:
        try:
            return put(made)
        except InvertedHexError as error:
            corners = np.array(error.crossing)
            nearer = [own if _is_among(mesh, corners) else 0.0 for own, (_, mesh) in zip(off, made, strict=True)]
            if not any(nearer) or run.is_over():
                raise
            log.info("solids are meshed nearer to the CAD: %s", error.what)
            try:
                made = [
                    (cells, make(cells, share * own) if own else mesh)
                    for own, (cells, mesh) in zip(nearer, made, strict=True)
                ]
            except CadSweepError as finer:
                raise error from finer
    return put(made)


def _is_among(mesh: AnyMesh, corners: FloatArray) -> bool:
    """Whether some of corners (n, 3) of quads that cross are nodes of a mesh's boundary."""
    skin = mesh.skin() if isinstance(mesh, BlockMesh) else mesh
    if not len(corners) or not skin.boundaries:
        return False
    nodes = skin.points[np.unique(np.concatenate([quads[:, :4].ravel() for quads in skin.boundaries.values()]))]
    return bool((cKDTree(nodes).query(corners)[0] <= _SAME * np.ptp(nodes, axis=0).max()).any())


__all__ = ["put_clear"]
