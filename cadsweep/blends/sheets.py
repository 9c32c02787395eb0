"""A sheet of hexahedra under the smooth patches of a design's mesh that are to be bent over its edges.

Place in the flow: between the mesh of a design and its carrying (:mod:`.carrying`).

Method: where the design has a convex edge with one hexahedron, two quads of that lie on one patch of the model, and
meet at 180 degrees there, the flatter the finer the mesh. Under a sheet every quad of the patch has a hexahedron of
its own. What was there keeps to copies of the patch's nodes: they lie inside, at its border on the faces beside it,
and at their corners on the edges between these. A patch may end at an edge that stays sharp; where it meets its
neighbour at a wide angle, the sheet goes on under that.

Not handled: patches that touch themselves at a node, and ends of a patch with several edges beside: no sheet is laid.
"""

from __future__ import annotations

from collections.abc import Collection
from math import radians
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..harmonic import find_hexes, mean_around, sides_of
from .finding import Blend

SHEET = "design: sheet under patches"
"""The name among the rows of tables that may be switched off."""
_THICK = 0.5
"""Thickness of a sheet at first, as a share of the hexahedra that it is taken from."""
_SHARP = radians(150.0)
"""Angle between two patches, through the material, up to which a sheet may end at the edge between them."""


class DesignMesh(NamedTuple):
    """A mesh on a design: points (n, 3), hexahedra (m, 8), the skin's quads (q, 4), outward, and their faces (q,)."""

    points: FloatArray
    hexes: IntArray
    quads: IntArray
    faces: IntArray


def with_sheet(mesh: DesignMesh, patch_of: IntArray, blends: Collection[Blend]) -> DesignMesh | None:
    """The mesh with a sheet under the patches that need one; None where none does, or none can be laid.

    Parameters
    ----------
    mesh : DesignMesh
        Faces are the model's.
    patch_of : (n_faces,) int64
        Patch of every face of the model.
    blends : collection of Blend
        What the design is without; edges are to be bent on where these are convex, and wider than the hexahedra.
    """
    segments, pairs = sides_of(mesh.quads)
    needing = _needing(mesh, segments, pairs, patch_of, blends)
    if not len(needing):
        return None
    return _laid(mesh, segments, pairs, _spread(mesh, segments, pairs, patch_of, needing))


def _needing(
    mesh: DesignMesh, segments: IntArray, pairs: IntArray, patch_of: IntArray, blends: Collection[Blend]
) -> IntArray:
    """Patches with a segment of a bent convex edge that one hexahedron has both quads of, and is narrow across."""
    hex_of = find_hexes(mesh.hexes, mesh.quads)
    radii = {
        tuple(sorted((one, other))): blend.radii[0]
        for blend in blends if blend.convex and blend.kind == "edge"
        for one in blend.supports[0] for other in blend.supports[-1]
    }  # fmt: skip
    beside = np.sort(mesh.faces[pairs], axis=1)
    near = np.flatnonzero((beside[:, 0] != beside[:, 1]) & (hex_of[pairs[:, 0]] == hex_of[pairs[:, 1]]))
    found = set()
    for s in near.tolist():
        radius = radii.get(tuple(beside[s].tolist()))
        if radius is None or patch_of[beside[s, 0]] != patch_of[beside[s, 1]]:
            continue
        middle = mesh.points[segments[s]].mean(axis=0)
        across = 2.0 * np.linalg.norm(mesh.points[mesh.quads[pairs[s]]].mean(axis=1) - middle, axis=1)
        if across.min() < radius:
            found.add(int(patch_of[beside[s, 0]]))
    return np.array(sorted(found), dtype=np.int64)


def _spread(mesh: DesignMesh, segments: IntArray, pairs: IntArray, patch_of: IntArray, covered: IntArray) -> BoolArray:
    """Quads (q,) of the patches, and of those that they meet at a wide angle."""
    patches = patch_of[mesh.faces[pairs]]
    wide = (patches[:, 0] != patches[:, 1]) & (_angles(mesh, segments, pairs) > _SHARP)
    meeting = np.unique(np.sort(patches[wide], axis=1), axis=0)
    while True:
        more = np.union1d(covered, meeting[np.isin(meeting, covered).any(axis=1)])
        if len(more) == len(covered):
            return np.isin(patch_of[mesh.faces], covered)
        covered = more


def _angles(mesh: DesignMesh, segments: IntArray, pairs: IntArray) -> FloatArray:
    """Angles (s,) through the material between the quads beside every segment."""
    corners = mesh.points[mesh.quads]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    one, other = normals[pairs[:, 0]], normals[pairs[:, 1]]
    inward = corners.mean(axis=1)[pairs[:, 1]] - mesh.points[segments].mean(axis=1)
    turn = np.arccos(np.clip((one * other).sum(axis=1), -1.0, 1.0))
    return np.where((one * inward).sum(axis=1) > 0.0, np.pi + turn, np.pi - turn)


def _laid(mesh: DesignMesh, segments: IntArray, pairs: IntArray, on: BoolArray) -> DesignMesh | None:
    """The mesh with a sheet under the quads (q,) that are `on` it."""
    n = len(mesh.points)
    own = mesh.quads[on]
    nodes = np.unique(own)
    rim = segments[on[pairs].sum(axis=1) == 1]
    at_rim, n_ways = np.unique(rim, return_counts=True)
    if (n_ways != 2).any():
        return None  # it touches itself there
    inner = np.arange(n)
    inner[nodes] = n + np.arange(len(nodes))
    towards = mean_around(mesh.points, mesh.hexes)
    towards[at_rim] = mean_around(mesh.points, mesh.quads[~on])[at_rim]
    # Edges of the design that end at the rim have its copies on them.
    leaving = segments[(~on[pairs]).all(axis=1) & (mesh.faces[pairs[:, 0]] != mesh.faces[pairs[:, 1]])]
    leaving = np.concatenate([leaving, leaving[:, ::-1]])
    leaving = leaving[np.isin(leaving[:, 0], at_rim)]
    if len(np.unique(leaving[:, 0])) < len(leaving) or np.isin(leaving[:, 1], at_rim).any():
        return None
    towards[leaving[:, 0]] = mesh.points[leaving[:, 1]]
    copies = (1.0 - _THICK) * mesh.points[nodes] + _THICK * towards[nodes]
    first, second = pairs[:, 0], pairs[:, 1]
    at = on[first] != on[second]
    outer = np.where(on[first], second, first)[at]  # the quad beside, which has the segment the other way round
    a, b = _as_in(mesh.quads[outer], segments[at]).T
    return DesignMesh(
        points=np.concatenate([mesh.points, copies]),
        hexes=np.concatenate([inner[mesh.hexes], np.concatenate([inner[own], own], axis=1)]),
        quads=np.concatenate([own, inner[mesh.quads[~on]], np.stack([a, b, inner[b], inner[a]], axis=1)]),
        faces=np.concatenate([mesh.faces[on], mesh.faces[~on], mesh.faces[outer]]),
    )


def _as_in(quads: IntArray, segments: IntArray) -> IntArray:
    """Segments (s, 2) in the direction in which quads (s, 4) have them."""
    at = (quads == segments[:, :1]).argmax(axis=1)
    ahead = quads[np.arange(len(quads)), (at + 1) % 4] == segments[:, 1]
    return np.where(ahead[:, None], segments, segments[:, ::-1])


__all__ = ["SHEET", "DesignMesh", "with_sheet"]
