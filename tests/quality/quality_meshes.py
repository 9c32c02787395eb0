"""Small meshes for the tests of metrics, checks and smoothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cadsweep.cells import SweptStructure, side_quads, sweep_hexes
from cadsweep.mesh import HexMesh

UNIT_CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
)


def hex_soup(corners):
    """Points and hexes of separate hexahedra with corners (m, 8, 3)."""
    corners = np.asarray(corners, dtype=float)
    return corners.reshape(-1, 3).copy(), np.arange(8 * len(corners)).reshape(-1, 8)


def random_hexes(n, amplitude, seed=0):
    """Corners (n, 8, 3) of unit cubes with every node displaced at random."""
    return UNIT_CUBE + np.random.default_rng(seed).normal(size=(n, 8, 3)) * amplitude


def grid_quads(n, m, *, hole=None):
    """Unit quads of an n x m rectangle, with the block `hole` = (i0, i1, j0, j1) left out: points, quads, loops."""
    ids = np.arange((n + 1) * (m + 1)).reshape(m + 1, n + 1)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1)
    y, x = np.meshgrid(np.arange(m + 1.0), np.arange(n + 1.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    loops = [np.concatenate([ids[0, :-1], ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0]])]
    keep = np.ones((m, n), dtype=bool)
    if hole is not None:
        i0, i1, j0, j1 = hole
        keep[j0:j1, i0:i1] = False
        rim = [ids[j0, i0:i1], ids[j0:j1, i1], ids[j1, i1:i0:-1], ids[j1:j0:-1, i0]]
        loops.append(np.concatenate(rim)[::-1])
    quads = quads[keep]
    used = np.unique(quads)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    return points[used], number[quads].astype(np.int64), tuple(number[loop].astype(np.int64) for loop in loops)


def swept_block(n=4, m=3, layers=3, *, hole=None, place=None):
    """A swept mesh: a rectangle of unit quads times layers of height 1; `place` maps (k, xy) to a layer's points."""
    plane, quads, loops = grid_quads(n, m, hole=hole)
    place = place or (lambda k, xy: np.c_[xy, np.full(len(xy), float(k))])
    return swept_mesh(np.concatenate([place(k, plane) for k in range(layers + 1)]), quads, loops, layers)


def swept_mesh(points, quads, loops, layers, *, periodic=False):
    """A mesh from the nodes of all layers."""
    n = len(points) // (layers + (not periodic))
    structure = SweptStructure(quads=quads, loops=loops, n_nodes=n, n_layers=layers, periodic=periodic)
    boundaries = {"side": side_quads(loops, n, layers, periodic=periodic).reshape(-1, 4)}
    if not periodic:
        boundaries |= {"source": quads[:, ::-1].copy(), "target": quads + layers * n}
    hexes = sweep_hexes(quads, n, layers, periodic=periodic)
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, structure=structure)


def swept_ring(n=3, m=2, layers=12):
    """A closed ring of rectangular section about the z axis."""
    plane, quads, loops = grid_quads(n, m)
    turns = 2 * np.pi * np.arange(layers) / layers
    # Seen along the sweep the section's first axis is the axis of revolution.
    radius, height = 5 + plane[:, 1], plane[:, 0]
    points = [np.c_[radius * np.cos(t), radius * np.sin(t), height] for t in turns]
    return swept_mesh(np.concatenate(points), quads, loops, layers, periodic=True)


def without_structure(mesh):
    """The same mesh as a file would give it back."""
    return replace(mesh, structure=None)


def fixed_nodes(mesh):
    """Boundary nodes (n,) bool of a mesh."""
    fixed = np.zeros(mesh.n_nodes, dtype=bool)
    for quads in mesh.boundaries.values():
        fixed[quads] = True
    return fixed


MIDDLES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
FACES = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]


def raised(corners, n_nodes):
    """Nodes (m, 20 or 27, 3) of straight-edged order-2 hexahedra with the given corners (m, 8, 3)."""
    groups = [*MIDDLES, *FACES, tuple(range(8))][: n_nodes - 8]
    return np.concatenate([corners, *(corners[:, list(g)].mean(axis=1, keepdims=True) for g in groups)], axis=1)
