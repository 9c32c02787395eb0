"""Numbering of swept meshes: what SweptStructure promises."""

import numpy as np
import pytest

from cadsweep.cells import HEX_FACES, side_quads, sweep_hexes
from cadsweep.mesh import HexMesh

SQUARE = np.array([[0, 1, 2, 3]])
CYCLE = (np.array([0, 1, 2, 3]),)
CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def cube_points(n_layers: int) -> np.ndarray:
    """A unit square moved up by one for every layer."""
    return np.concatenate([CORNERS + [0, 0, k] for k in range(n_layers + 1)])


def quad_areas(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Vector areas (q, 3)."""
    a, b, c, d = (points[quads[..., i]] for i in range(4))
    return 0.5 * np.cross(c - a, d - b)


def test_hexes_stack_quads_bottom_below_top():
    hexes = sweep_hexes(SQUARE, 4, 2)
    assert hexes.tolist() == [[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]]


def test_periodic_sweep_closes_on_its_first_layer():
    hexes = sweep_hexes(SQUARE, 4, 3, periodic=True)
    assert hexes.max() == 11
    assert hexes[-1].tolist() == [8, 9, 10, 11, 0, 1, 2, 3]


@pytest.mark.parametrize("n_layers", [1, 3])
def test_boundary_of_a_stack_is_closed_and_outward(n_layers):
    points = cube_points(n_layers)
    sides = side_quads(CYCLE, 4, n_layers).reshape(-1, 4)
    caps = np.concatenate([SQUARE[:, ::-1], SQUARE + 4 * n_layers])
    areas = quad_areas(points, np.concatenate([sides, caps]))
    assert np.allclose(areas.sum(axis=0), 0)  # closed: vector areas cancel
    centres = points[np.concatenate([sides, caps])].mean(axis=1)
    assert np.einsum("ij,ij->", areas, centres) / 3 == pytest.approx(n_layers)  # outward: divergence gives the volume


def test_hex_faces_point_outward():
    points = cube_points(1)
    hexahedron = sweep_hexes(SQUARE, 4, 1)[0]
    faces = hexahedron[HEX_FACES]
    areas = quad_areas(points, faces)
    outward = points[faces].mean(axis=1) - points.mean(axis=0)
    assert (np.einsum("ij,ij->i", areas, outward) > 0).all()


def test_a_name_that_is_not_there_lists_those_that_are():
    import pickle

    quads = np.array([[0, 3, 2, 1]])
    mesh = HexMesh(points=np.zeros((8, 3)), hexes=np.arange(8)[None], boundaries={"inlet": quads, "wall": quads})
    for same in (mesh, pickle.loads(pickle.dumps(mesh))):
        with pytest.raises(KeyError, match=r"^the mesh has no boundary 'inlett' \(did you mean 'inlet'\?\); there are"):
            same.boundaries["inlett"]
        assert list(same.boundaries) == ["inlet", "wall"]
        assert same.boundaries.get("x") is None
    with pytest.raises(KeyError, match="no part 'a'; there is none"):
        mesh.parts["a"]


def test_what_is_shown_of_a_mesh_has_three_lines_at_most():
    boundaries = {f"side_{i}": np.zeros((5, 4), dtype=np.int64) for i in range(30)}
    mesh = HexMesh(points=np.zeros((8, 3)), hexes=np.arange(8)[None], boundaries=boundaries, parts={"a": np.array([0])})
    shown = repr(mesh)
    assert len(shown.splitlines()) <= 3
    assert "side_0 (5 quads)" in shown
    assert "and 24 more" in shown
    assert len(repr(mesh.quality()).splitlines()) <= 3
