"""From a ray through the picture to the solid, face or edge that it meets.

Place in the flow: the browser says where a click went, as two points of its line of sight.

Method: every facet is asked (Moeller and Trumbore, 1997), all at once; a few ten thousand take milliseconds. An edge
is the one whose points come nearest to the line, seen from where one looks, among those that no facet hides.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .entities import PartData

REACH = 0.012
"""How far from an edge a click may be, over the width of what is seen at its depth: about ten pixels."""


def first_hit(
    points: FloatArray, triangles: np.ndarray, start: FloatArray, end: FloatArray
) -> tuple[int, float] | None:
    """The triangle that the line from `start` to `end` meets first, and where as a fraction of it; None where none
    is."""
    direction = end - start
    a, b, c = (points[triangles[:, j]] for j in range(3))
    one, two = b - a, c - a
    normal = np.cross(direction, two)
    area = np.einsum("ij,ij->i", one, normal)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / area
        away = start - a
        u = np.einsum("ij,ij->i", away, normal) * inverse
        across = np.cross(away, one)
        v = across @ direction * inverse
        at = np.einsum("ij,ij->i", two, across) * inverse
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (at > 0)
    if not hit.any():
        return None
    found = int(np.where(hit, at, np.inf).argmin())
    return found, float(at[found])


def pick(part: PartData, start: FloatArray, end: FloatArray, *, kind: str, width: float) -> str | None:
    """The key of what a line of sight meets.

    Parameters
    ----------
    part : PartData
    start, end : (3,) float64
        Two points of the line, the nearer one first, model units.
    kind : {"face", "edge", "solid"}
    width : float
        Width of what is seen where the part is, model units.
    """
    hit = first_hit(part.points, part.triangles, start, end)
    if kind == "edge":
        return _nearest_edge(part, start, end, reach=REACH * width, deepest=1.0 if hit is None else hit[1])
    if hit is None:
        return None
    face = part.face_keys[int(part.owners[hit[0]])]
    return face if kind == "face" else f"solid:{part.entities[face].solid}"


def _nearest_edge(part: PartData, start: FloatArray, end: FloatArray, *, reach: float, deepest: float) -> str | None:
    direction = end - start
    length = float(np.linalg.norm(direction))
    unit = direction / length
    best, found = reach, None
    for key, chain in part.chains.items():
        dense = _dense(chain, reach)
        away = dense - start
        along = away @ unit
        off = np.linalg.norm(away - along[:, None] * unit, axis=1)
        off[along > deepest * length + 2 * reach] = np.inf  # behind what is seen
        nearest = float(off.min())
        if nearest < best:
            best, found = nearest, key
    return found


def _dense(chain: FloatArray, step: float) -> FloatArray:
    """The chain with points so near to each other that none in between matters; two hundred a piece at most."""
    pieces = np.linalg.norm(np.diff(chain, axis=0), axis=1)
    n = np.clip(np.ceil(pieces / max(step / 2, 1e-300)), 1, 200).astype(int)
    parts = [np.linspace(a, b, k, endpoint=False) for a, b, k in zip(chain[:-1], chain[1:], n, strict=True)]
    return np.concatenate([*parts, chain[-1:]])
