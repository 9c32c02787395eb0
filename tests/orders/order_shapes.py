"""Shapes that several tests of orders bend."""

import numpy as np

from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate


def roll(flat: HexMesh, order: int, nodes: int = 27) -> HexMesh:
    """A plate rolled to a part of a ring about the y axis, its faces at z = 0 and 1 on cylinders of radius 3 and 4."""
    angle, radius = flat.points[:, 0], 3.0 + flat.points[:, 2]
    points = np.column_stack([radius * np.sin(angle), flat.points[:, 1], radius * np.cos(angle)])
    mesh = HexMesh(points=points, hexes=flat.hexes, boundaries=flat.boundaries, parts=flat.parts)

    def onto(places):
        own = np.hypot(places[:, 0], places[:, 2])
        scale = np.where(own < 3.45, 3.0, 4.0) / own
        return places * np.column_stack([scale, np.ones_like(scale), scale])

    curved = [(mesh.boundaries[name], onto) for name in ("source", "target")]
    return elevate(mesh, order=order, nodes=nodes, surfaces=curved)
