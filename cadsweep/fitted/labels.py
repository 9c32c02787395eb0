"""Which face of the model every quad of the skin is on: the least cost over all quads together.

Method: a quad is dear to a face by its distance from it and by how its own normal, smoothed over its neighbours, turns
from the face's; a segment between two labels is dear by its distance from the edges between these faces, dearer where
they have none. Labels are changed one by one while that gets cheaper; then pieces that hang apart are given to what is
around them.
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
from .grid import Facets
from .merged import Merged

_TURNED = 1.5
"""Cost of a normal at right angles to the face's, over that of a distance of one cell."""
_BORDER = 0.3
"""Cost of a segment between two labels that lies on their edge."""
_FAR = 3.0
"""Cells from the edge beyond which a segment between two labels costs no more: also what one without an edge costs."""
_SAMPLES = 0.3
"""Distance of samples of a facet over the size."""
_ROUNDS = 60
"""Passes over all quads; a dozen do."""


def label_quads(  # noqa: PLR0917
    solid: Solid, merged: Merged, facets: Facets, points: FloatArray, quads: IntArray, size: float
) -> IntArray:
    """United faces (q,) of the quads (q, 4) of a skin with nodes `points`."""
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
        own = facets.triangles[merged.of_face[facets.faces] == face]
        if not len(own):
            continue
        at, out = _sampled(facets.points[own], _SAMPLES * size)
        away, nearest = cKDTree(at).query(middles)
        turned = 1.0 - np.einsum("qd,qd->q", smooth, out[nearest])
        cost[:, face] = np.minimum(away / size, 5.0) ** 2 + _TURNED * turned
    places = points[segments].mean(axis=1)
    between = np.full((len(solid.faces), len(solid.faces)), -1, dtype=np.int64)
    columns: list[FloatArray] = []
    along = np.linspace(0.0, 1.0, 65)
    for edge in merged.edges:
        away = cKDTree(edge.curve.evaluate(along)).query(places)[0] / size
        f, g = merged.sides(edge)
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
        if not _joined(labels, pairs, len(quads)):
            break
    return labels


def _neighbours(n: int, pairs: IntArray) -> IntArray:
    """For every quad four rows of its neighbour and the segment between."""
    owners = np.concatenate([pairs[:, 0], pairs[:, 1]])
    others = np.concatenate([pairs[:, 1], pairs[:, 0]])
    sides = np.tile(np.arange(len(pairs)), 2)
    order = np.argsort(owners, kind="stable")
    return np.stack([others[order], sides[order]], axis=1).reshape(n, 4, 2)


@compiled()
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
        labels[own] = np.bincount(around).argmax()
    return bool(lost)


def _sampled(corners: FloatArray, apart: float) -> tuple[FloatArray, FloatArray]:
    """Points on triangles (t, 3, 3), about `apart` from each other, and the triangles' normals there."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    good = lengths[:, 0] > 0
    corners, normals = corners[good], (normals / np.maximum(lengths, 1e-300))[good]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    counts = np.clip(np.ceil(longest / apart), 1, 60).astype(np.int64)
    points, outward = [np.empty((0, 3))], [np.empty((0, 3))]
    for n in np.unique(counts).tolist():
        own = counts == n
        i, j = np.nonzero(np.add.outer(np.arange(n + 1), np.arange(n + 1)) <= n)
        weights = np.stack([n - i - j, i, j], axis=1) / n
        at = np.einsum("wc,tcd->twd", weights, corners[own])
        points.append(at.reshape(-1, 3))
        outward.append(np.repeat(normals[own], len(weights), axis=0))
    return np.concatenate(points), np.concatenate(outward)


def name_pieces(merged: Merged, facets: Facets, points: FloatArray, quads: IntArray, labels: IntArray) -> IntArray:
    """For quads labelled with united faces, the piece of these that each is nearest to."""
    found = labels.copy()
    for united in np.unique(labels).tolist():
        own = np.flatnonzero(merged.of_face[facets.faces] == united)
        if len(np.unique(facets.faces[own])) > 1:
            at = labels == united
            apart = float(np.linalg.norm(np.ptp(facets.points[facets.triangles[own]], axis=(0, 1)))) / 60
            samples = [_sampled(facets.points[facets.triangles[own[[j]]]], apart)[0] for j in range(len(own))]
            of_sample = np.repeat(facets.faces[own], [len(one) for one in samples])
            nearest = cKDTree(np.concatenate(samples)).query(points[quads[at]].mean(axis=1))[1]
            found[at] = of_sample[nearest]
    return found
