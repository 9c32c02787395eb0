"""Small meshes for the tests of files: straight, twisted, of two parts, of order 2."""

from __future__ import annotations

import numpy as np

from cadsweep.cells import side_quads, sweep_hexes
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate


def box(nx: int = 3, ny: int = 2, nz: int = 4, *, size: tuple[float, float, float] = (3.0, 2.0, 1.0)) -> HexMesh:
    """A box of nx * ny * nz hexes with all sides named, and ``walls`` over the four linking sides."""
    x, y = np.meshgrid(np.linspace(0, size[0], nx + 1), np.linspace(0, size[1], ny + 1), indexing="ij")
    n = x.size
    ids = np.arange(n).reshape(nx + 1, ny + 1)
    quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1).reshape(-1, 4)
    layers = [np.stack([x.ravel(), y.ravel(), np.full(n, z)], axis=-1) for z in np.linspace(0, size[2], nz + 1)]
    loop = np.concatenate([ids[:-1, 0], ids[-1, :-1], ids[:0:-1, -1], ids[0, :0:-1]])
    sides = side_quads([loop], n, nz)
    boundaries = {"source": quads[:, ::-1], "target": quads + nz * n}
    for j, part in enumerate(np.split(sides, np.cumsum([nx, ny, nx]), axis=1), 1):
        boundaries[f"side_{j}"] = part.reshape(-1, 4)
    boundaries["walls"] = sides.reshape(-1, 4)
    hexes = sweep_hexes(quads, n, nz)
    return HexMesh(
        points=np.concatenate(layers), hexes=hexes, boundaries=boundaries, parts={"box": np.arange(len(hexes))}
    )


def twisted_box(**sizes: int) -> HexMesh:
    """A box turned about its axis with height, so that no two coordinates are alike."""
    mesh = box(**sizes)
    x, y, z = mesh.points.T
    points = np.column_stack([x * np.cos(0.4 * z) - y * np.sin(0.4 * z), x * np.sin(0.4 * z) + y * np.cos(0.4 * z), z])
    return HexMesh(points=points + 0.1, hexes=mesh.hexes, boundaries=mesh.boundaries, parts=mesh.parts)


def two_parts() -> HexMesh:
    """A twisted box whose hexes belong by turns to two parts, with their interface among the boundaries.

    ``odd_layers`` overlaps both parts and ``corner`` overlaps two boundaries in part.
    """
    mesh = twisted_box()
    per_layer = mesh.n_hexes // 4
    layer = np.arange(mesh.n_hexes) // per_layer
    column = np.arange(mesh.n_hexes) % per_layer
    parts = {
        "left": np.flatnonzero(column % 2 == 0),
        "right": np.flatnonzero(column % 2 == 1),
        "odd_layers": np.flatnonzero(layer % 2 == 1),
    }
    boundaries = dict(mesh.boundaries)
    boundaries["corner"] = np.concatenate([boundaries["side_1"][:2], boundaries["side_2"][:1]])
    boundaries["interface"] = mesh.hexes[layer == 0][:, 4:8]
    return HexMesh(points=mesh.points, hexes=mesh.hexes, boundaries=boundaries, parts=parts)


def bent_box(nodes: int) -> HexMesh:
    """A box bent about the y axis to a part of a ring, of order 1 or 2, all nodes on the bend."""
    mesh = box(size=(1.0, 2.0, 1.0))
    points = _bent(mesh.points)
    bent = HexMesh(points=points, hexes=mesh.hexes, boundaries=mesh.boundaries, parts=mesh.parts)
    if nodes == 8:
        return bent
    quads = np.concatenate(list(mesh.boundaries.values()))
    return elevate(bent, nodes=nodes, surfaces=[(quads, _on_bend)])


def _bent(points: np.ndarray) -> np.ndarray:
    radius, angle = 3.0 + points[:, 0], points[:, 2]
    return np.column_stack([radius * np.cos(angle), points[:, 1], radius * np.sin(angle)])


def _on_bend(points: np.ndarray) -> np.ndarray:
    """Middles of chords, put to the radius of the nearest node circle (radii of a third apart)."""
    radius = np.hypot(points[:, 0], points[:, 2])
    steps = np.round((radius - 3.0) * 6) / 6
    factor = ((3.0 + steps) / radius)[:, None]
    return points * np.column_stack([factor, np.ones_like(factor), factor])


TOLERANCES = {".inp": 1e-12, ".rad": 1e-12, ".bdf": 1e-9, ".k": 1e-9}
"""How far off a coordinate that was read back may be, in formats whose fields hold fewer digits than a float has."""
