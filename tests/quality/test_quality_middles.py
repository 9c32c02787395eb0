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


def check_pair(node, move):
    """Two cubes as parts, above each other, the upper one's nodes from 27 on; one node moved."""
    nodes = np.concatenate([raised(UNIT_CUBE[None], 27)[0], raised(UNIT_CUBE[None] + [0, 0, 1], 27)[0]])
    points, numbers = np.unique(np.round(nodes, 9), axis=0, return_inverse=True)
    lower, upper = numbers.reshape(2, 27)
    points[numbers[node]] += move
    cells = {"lower": lower, "upper": upper}
    inner = {"lower": "top", "upper": "bottom"}
    boundaries = {
        f"{part}_{name}": hexes[None, list(SIDES[name][0])]
        for part, hexes in cells.items()
        for name in SIDES
        if name != inner[part]
    }
    mesh = HexMesh(
        points=points,
        hexes=np.stack([lower, upper]),
        boundaries=boundaries,
        interfaces={"lower__upper": lower[None, list(SIDES["top"][0])]},
        parts={"lower": np.array([0]), "upper": np.array([1])},
    )

    def reference(part):
        def distance(places, name, close):
            if name == "lower__upper":
                return abs(places[:, 2] - 1)
            _, axis, level = SIDES[name.removeprefix(f"{part}_")]
            return abs(places[:, axis] - level - (axis == 2 and part == "upper"))

        return CadReference(distance=distance)

    assert check_mesh(mesh).order == 2
    return check_mesh(mesh, cad={part: reference(part) for part in cells}).problems


@pytest.mark.parametrize(("node", "move", "said"), [
    (25, [0, 0, 1e-3], ["part 'lower': 1 nodes of 'lower__upper'", "part 'upper': 1 nodes of 'lower__upper'"]),
    (27 + 25, [0, 0, 1e-3], ["part 'upper': 1 nodes of 'upper_top'"]),
    (27 + 17, [1e-3, 0, 0], ["part 'upper': 1 nodes of 'upper_right'"]),  # an upright edge of the upper cube
    (25, [1e-3, 0, 0], []),  # along the interface
])  # fmt: skip
def test_middle_nodes_of_several_parts_are_held_against_the_faces_of_each(node, move, said):
    problems = [problem for problem in check_pair(node, move) if "off their CAD face" in problem]
    assert [any(problem.startswith(words) for problem in problems) for words in said] == [True] * len(said)
    assert len(problems) == len(said)
