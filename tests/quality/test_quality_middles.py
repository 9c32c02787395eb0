"""Middle nodes of order 2 are held against CAD faces and edges as corner nodes are."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.mesh import HexMesh
from cadsweep.quality import CadReference, check_mesh

from .quality_meshes import UNIT_CUBE, raised

SIDES = {  # nodes of the sides of a hex27, corners and middles outward; the axis and the level of their planes
    "left": ((0, 4, 7, 3, 16, 15, 19, 11, 20), 0, 0.0),
    "right": ((1, 2, 6, 5, 9, 18, 13, 17, 21), 0, 1.0),
    "front": ((0, 1, 5, 4, 8, 17, 12, 16, 22), 1, 0.0),
    "back": ((3, 7, 6, 2, 19, 14, 18, 10, 23), 1, 1.0),
    "bottom": ((0, 3, 2, 1, 11, 10, 9, 8, 24), 2, 0.0),
    "top": ((4, 5, 6, 7, 12, 13, 14, 15, 25), 2, 1.0),
}


def check_cube(node, move):
    """A cube of order 2 with one node moved, against the planes and edges of the unit cube."""
    points = raised(UNIT_CUBE[None], 27)[0]
    points[node] += move
    boundaries = {name: np.array([nodes]) for name, (nodes, _, _) in SIDES.items()}
    mesh = HexMesh(points=points, hexes=np.arange(27)[None], boundaries=boundaries)

    def distance(places, name, close):
        _, axis, level = SIDES[name]
        return abs(places[:, axis] - level)

    def rim_distance(places, blocks):
        planes = [SIDES[name][1:] for names in blocks for name in names]
        return np.max([abs(places[:, axis] - level) for axis, level in planes], axis=0)

    return check_mesh(mesh, cad=CadReference(distance=distance, rim_distance=rim_distance)).problems


@pytest.mark.parametrize(("node", "move", "said"), [
    (25, [0, 0, 1e-3], ["of 'top'", "CAD face"]),  # centre of a face
    (25, [1e-3, 0, 0], None),  # along its plane
    (9, [1e-3, 0, 0], ["of 'right'", "CAD face"]),  # middle of the edge between right and bottom
    (9, [0, 0, 1e-3], ["'bottom'", "'right'", "meet", "CAD edge"]),
    (9, [0, 1e-3, 0], None),  # along the edge
    (26, [1e-3, 1e-3, 1e-3], None),  # inside
])  # fmt: skip
def test_a_middle_node_off_its_face_or_edge_is_found(node, move, said):
    problems = check_cube(node, move)
    if said is None:
        assert problems == ()
    else:
        assert any(all(word in problem for word in said) for problem in problems)
