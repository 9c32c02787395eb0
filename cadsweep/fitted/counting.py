"""What a labelled skin and a model must have alike: the holes of faces, the runs of edges between two, the vertices.

Both are closed surfaces in faces that are parted by segments. Counts do not say that two surfaces are alike, but where
they differ the surfaces do; and they are cheap enough to be asked of every label that might be changed.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

_compiled = compiled(cache=True, nogil=True)


@_compiled
def _root(parent, item):  # type: ignore[no-untyped-def]
    while parent[item] != item:
        parent[item] = parent[parent[item]]
        item = parent[item]
    return item


@_compiled
def count_runs(ends, faces, n_nodes, runs):  # type: ignore[no-untyped-def]
    """Count runs of segments (s, 2) between faces (s, 2), those inside one face aside, into `runs` (n, n), low first.

    A run goes on through nodes where two segments meet; returns the number of others that have any.
    """
    degree, at = np.zeros(n_nodes, dtype=np.int64), np.full(n_nodes, -1, dtype=np.int64)
    parent = np.arange(len(ends))
    for s in range(len(ends)):
        if faces[s, 0] != faces[s, 1]:
            degree[ends[s, 0]] += 1
            degree[ends[s, 1]] += 1
    runs[:] = 0
    for s in range(len(ends)):
        f, g = min(faces[s, 0], faces[s, 1]), max(faces[s, 0], faces[s, 1])
        if f == g:
            continue
        runs[f, g] += 1
        for node in ends[s]:
            if degree[node] != 2:
                continue
            if at[node] < 0:
                at[node] = s
                continue
            one, other = _root(parent, s), _root(parent, at[node])
            if one != other:
                parent[one] = other
                runs[f, g] -= 1
    n = 0
    for node in range(n_nodes):
        n += degree[node] != 0 and degree[node] != 2
    return n


@_compiled
def count_skin(own, segments, beside, first, around, labels, euler, runs):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Count, of quads `own` of those with labels (q,), Euler numbers of faces into `euler` (n,), and runs into `runs`.

    Their ``segments`` (s, 2) lie between quads ``beside`` (s, 2); at node i are ``around[first[i] : first[i + 1]]``.
    Returns the number of vertices.
    """
    faces = np.empty_like(beside)
    euler[:] = 0
    for q in own:
        euler[labels[q]] += 1
    for s in range(len(segments)):
        f, g = labels[beside[s, 0]], labels[beside[s, 1]]
        faces[s, 0], faces[s, 1] = f, g
        euler[f] -= 1
        if g != f:
            euler[g] -= 1
    for node in range(len(first) - 1):
        for i in range(first[node], first[node + 1]):
            label = labels[around[i]]
            is_new = True
            for j in range(first[node], i):
                is_new &= labels[around[j]] != label
            euler[label] += is_new
    return count_runs(segments, faces, len(first) - 1, runs)


@_compiled
def count_changed(own, segments, beside, first, around, labels, wanted_euler, wanted_runs, wanted_vertices, changes):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """By how much counts differ from those that are wanted once labels are changed, for each of some changes (c, k, 2).

    A change is k quads and the labels that they get.
    """
    labels = labels.copy()
    found = np.empty(len(changes), dtype=np.int64)
    euler, runs = np.empty_like(wanted_euler), np.empty_like(wanted_runs)
    kept = np.empty(changes.shape[1], dtype=np.int64)
    for c in range(len(changes)):
        for k in range(len(kept)):
            kept[k] = labels[changes[c, k, 0]]
            labels[changes[c, k, 0]] = changes[c, k, 1]
        n = count_skin(own, segments, beside, first, around, labels, euler, runs)
        found[c] = np.abs(euler - wanted_euler).sum() + np.abs(runs - wanted_runs).sum() + abs(n - wanted_vertices)
        for k in range(len(kept) - 1, -1, -1):
            labels[changes[c, k, 0]] = kept[k]
    return found
