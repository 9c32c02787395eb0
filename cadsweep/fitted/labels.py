"""Which face of the model every quad of the skin is on: the least cost over all quads together.

Method: a quad is dear to a face by its distance from it and by how its own normal, smoothed over its neighbours, turns
from the face's; a segment between two labels is dear by its distance from the edges between these faces, dearer where
they have none. Labels are changed one by one while that gets cheaper; then pieces that hang apart are given to what is
around them, and faces that have none the quad nearest to them.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..compiled import compiled
from ..harmonic import sides_of
from .facets import Facets, Nearest

_TURNED = 1.5
"""Cost of a normal at right angles to the face's, over that of a distance of one cell."""
_BORDER = 0.3
"""Cost of a segment between two labels that lies on their edge."""
_FAR = 3.0
"""Cells from the edge beyond which a segment between two labels costs no more: also what one without an edge costs."""
_NEAR = 3.0
"""Cells from a face beyond which no quad is on it."""
_SEED = 2.5
"""Cost up to which a quad is given to a face that has none."""
_ROUNDS = 60
"""Passes over all quads; a dozen do."""


def label_quads(solid: Solid, facets: Facets, points: FloatArray, quads: IntArray, size: float) -> IntArray:
    """Faces (q,) of the solid of the quads (q, 4) of a skin with nodes `points`."""
    middles = points[quads].mean(axis=1)
    normals = np.cross(points[quads[:, 2]] - points[quads[:, 0]], points[quads[:, 3]] - points[quads[:, 1]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    segments, pairs = sides_of(quads)
    beside = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(quads), len(quads))).tocsr()
    beside = beside + beside.T
    smooth = normals + beside @ normals
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-12)
    cost = np.full((len(quads), len(solid.faces)), 1e3)
    for face in range(len(solid.faces)):
        own = facets.of(np.array([face]))
        corners = facets.points[own.triangles.ravel()]
        if not len(corners):
            continue
        low, high = corners.min(axis=0) - _NEAR * size, corners.max(axis=0) + _NEAR * size
        near = np.flatnonzero(((middles > low) & (middles < high)).all(axis=1))
        if not len(near):
            continue
        nearest = Nearest(own)
        away, at = nearest(middles[near])
        turned = 1.0 - np.einsum("qd,qd->q", smooth[near], nearest.normals[at])
        cost[near, face] = (away / size) ** 2 + _TURNED * turned
    places = points[segments].mean(axis=1)
    between = np.full((len(solid.faces), len(solid.faces)), -1, dtype=np.int64)
    columns: list[FloatArray] = []
    along = np.linspace(0.0, 1.0, 65)
    for edge in solid.edges:
        away = cKDTree(edge.curve.evaluate(along)).query(places, distance_upper_bound=_FAR * size)[0] / size
        f, g = edge.faces
        if between[f, g] < 0:
            between[f, g] = between[g, f] = len(columns)
            columns.append(away)
        else:
            columns[between[f, g]] = np.minimum(columns[between[f, g]], away)
    borders = _BORDER + np.minimum(np.stack(columns, axis=1), _FAR) if columns else np.empty((len(places), 0))
    labels = np.argmin(cost, axis=1).astype(np.int64)
    near = _neighbours(len(quads), pairs)
    for _ in range(4):
        labels = _improved(labels, cost, borders, between, near, _ROUNDS)
        were_apart = _joined(labels, pairs, len(quads))
        if not (_planted(labels, cost) or were_apart):
            break
    return labels


def _planted(labels: IntArray, cost: FloatArray) -> bool:
    """Give, in place and for good, every face without a quad the one that is the least dear to it; whether any was."""
    lost = np.setdiff1d(np.arange(cost.shape[1]), labels)
    nearest = np.argmin(cost[:, lost], axis=0)
    near = cost[nearest, lost] < _SEED
    for face, quad in zip(lost[near].tolist(), nearest[near].tolist(), strict=True):
        labels[quad] = face
        cost[quad] += np.where(np.arange(cost.shape[1]) == face, 0.0, 1e3)
    return bool(near.any())


def _neighbours(n: int, pairs: IntArray) -> IntArray:
    """For every quad four rows of its neighbour and the segment between."""
    owners = np.concatenate([pairs[:, 0], pairs[:, 1]])
    others = np.concatenate([pairs[:, 1], pairs[:, 0]])
    sides = np.tile(np.arange(len(pairs)), 2)
    order = np.argsort(owners, kind="stable")
    return np.stack([others[order], sides[order]], axis=1).reshape(n, 4, 2)


@compiled(cache=True)
def _improved(labels, cost, borders, between, near, rounds):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Change labels while that is cheaper: to a neighbour's, or to one of the faces that are dear at most by two."""
    labels = labels.copy()
    n_faces = cost.shape[1]
    for _ in range(rounds):
        changed = 0
        for q in range(len(labels)):
            best, kept = np.inf, labels[q]
            least = cost[q].min()
            for f in range(n_faces):
                if cost[q, f] > least + 2.0 and f != labels[q]:
                    continue
                value = cost[q, f]
                for k in range(4):
                    g = labels[near[q, k, 0]]
                    if g != f:
                        b = between[f, g]
                        value += borders[near[q, k, 1], b] if b >= 0 else 3.3
                if value < best - 1e-12:
                    best, kept = value, f
            if kept != labels[q]:
                labels[q] = kept
                changed += 1
        if changed == 0:
            break
    return labels


def _joined(labels: IntArray, pairs: IntArray, n: int) -> bool:
    """Give, in place, all but the largest piece of every label to what most of its neighbours are; whether any was."""
    same = labels[pairs[:, 0]] == labels[pairs[:, 1]]
    graph = coo_array((np.ones(same.sum()), (pairs[same, 0], pairs[same, 1])), shape=(n, n))
    n_pieces, pieces = connected_components(graph, directed=False)
    sizes = np.bincount(pieces, minlength=n_pieces)
    largest: dict[int, int] = {}
    of_piece = np.zeros(n_pieces, dtype=np.int64)
    of_piece[pieces] = labels
    for piece in range(n_pieces):
        label = int(of_piece[piece])
        if label not in largest or sizes[piece] > sizes[largest[label]]:
            largest[label] = piece
    lost = [piece for piece in range(n_pieces) if largest[int(of_piece[piece])] != piece]
    for piece in lost:
        own = pieces == piece
        around = np.concatenate(
            [
                labels[pairs[own[pairs[:, 0]] & ~own[pairs[:, 1]], 1]],
                labels[pairs[own[pairs[:, 1]] & ~own[pairs[:, 0]], 0]],
            ]
        )
        if len(around):
            labels[own] = np.bincount(around).argmax()
    return bool(lost)
