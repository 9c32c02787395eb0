"""Swept meshes for the tests of smoothing: blocks and bends whose inside has been disturbed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from cadsweep.cells import SweptStructure
from cadsweep.projection import project_layers


def swept_grid(n, layers, place):
    """A square of n x n quads on [-1, 1]^2 times layers; `place(t, xy)` gives a layer: points, structure, fixed."""
    ids = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    y, x = np.meshgrid(*[np.linspace(-1, 1, n + 1)] * 2, indexing="ij")
    xy = np.stack([x.ravel(), y.ravel()], axis=1)
    loop = np.concatenate([ids[0, :-1], ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0]])
    points = np.concatenate([place(k / layers, xy) for k in range(layers + 1)])
    structure = SweptStructure(quads=quads, loops=(loop,), n_nodes=len(xy), n_layers=layers)
    fixed = np.zeros((layers + 1, len(xy)), dtype=bool)
    fixed[[0, -1]] = True
    fixed[:, loop] = True
    return points, structure, fixed.ravel()


def block(n=6, layers=6, *, heights=None):
    """A cube of side 2; `heights` (layers + 1,) where its layers are not even."""
    z = np.linspace(0, 2, layers + 1) if heights is None else np.asarray(heights)
    return swept_grid(n, layers, lambda t, xy: np.c_[xy, np.full(len(xy), z[round(t * layers)])])


def domed_bend(n=8, layers=12, dome=0.6):
    """A bend of 90 degrees with a dome out of its source, which fades along the sweep."""

    def place(t, xy):
        angle = t * np.pi / 2
        height = -dome * (1 - t) * (1 - xy[:, 0] ** 2) * (1 - xy[:, 1] ** 2)
        radius = 3 - xy[:, 0]
        x, z = radius * np.cos(angle), radius * np.sin(angle)
        return np.c_[x - height * np.sin(angle), xy[:, 1], z + height * np.cos(angle)]

    points, structure, fixed = swept_grid(n, layers, place)
    # The first axis of the section runs towards the bend's axis: turn the quads to face along the sweep.
    turned = SweptStructure(
        quads=structure.quads[:, ::-1].copy(),
        loops=tuple(loop[::-1] for loop in structure.loops),
        n_nodes=structure.n_nodes,
        n_layers=layers,
    )
    return points, turned, fixed


def disturbed(mesh, amount, seed=0):
    """The same mesh with its inner nodes displaced at random by `amount`."""
    points, structure, fixed = mesh
    points = points.copy()
    points[~fixed] += np.random.default_rng(seed).normal(size=(np.count_nonzero(~fixed), 3)) * amount
    return points, structure, fixed


def closed_ring(n=5, layers=16):
    """A ring of square section, turned about the z axis, without caps."""
    points, structure, _ = swept_grid(
        n,
        layers,
        # The section's axes are z and the radius, so that it faces along the sweep.
        lambda t, xy: np.c_[(4 + xy[:, 1]) * np.cos(2 * np.pi * t), (4 + xy[:, 1]) * np.sin(2 * np.pi * t), xy[:, 0]],
    )
    size = structure.n_nodes
    closed = SweptStructure(quads=structure.quads, loops=structure.loops, n_nodes=size, n_layers=layers, periodic=True)
    on_rim = np.zeros((layers, size), dtype=bool)
    on_rim[:, structure.loops[0]] = True
    return points[: layers * size], closed, on_rim.ravel()


def folded_angle(n=4, layers=16):
    """An angle with arms 3 long and 1 thick that are 7 long half way: its projection folds there."""
    ids = np.full((3 * n + 1, 3 * n + 1), -1)
    kept = np.minimum(*np.meshgrid(np.arange(3 * n + 1), np.arange(3 * n + 1), indexing="ij")) <= n
    ids[kept] = np.arange(np.count_nonzero(kept))
    j, i = np.nonzero(kept)  # in the order of their numbers
    xy = np.c_[i, j] / n
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    quads = quads[(quads >= 0).all(axis=1)]
    path = [(0, 0), (3 * n, 0), (3 * n, n), (n, n), (n, 3 * n), (0, 3 * n), (0, 0)]
    loop = []
    for (a, b), (c, d) in pairwise(path):
        m = max(abs(c - a), abs(d - b))
        loop += [ids[b + (d - b) * k // m, a + (c - a) * k // m] for k in range(m)]
    loop = np.array(loop)
    source = np.c_[xy, np.zeros(len(xy))]
    longer = np.where(source > 1, 1 + 3 * (source - 1), source)
    t = np.linspace(0, 1, layers + 1)[:, None, None]
    share = np.sin(np.pi * t)
    rings = ((1 - share) * source + share * longer)[:, loop] + [0, 0, 6] * t
    sweep = project_layers(
        source, quads, rings, loops=(loop,), strategy="both", target_points=source + [0, 0, 6], residual=True
    )
    structure = SweptStructure(quads=quads, loops=(loop,), n_nodes=len(xy), n_layers=layers)
    fixed = np.zeros((layers + 1, len(xy)), dtype=bool)
    fixed[[0, -1]] = True
    fixed[:, loop] = True
    return sweep.points().reshape(-1, 3), structure, fixed.ravel()
