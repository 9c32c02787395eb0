"""How much of a mesh is one hexahedron thick: known by counting on blocks of cubes."""

import numpy as np
import pytest

from cadsweep.cells import HEX_FACES
from cadsweep.quality.thickness import single_share


def cubes(nx, ny, nz, hollow=()):
    """A block of unit cubes without those listed, and its outward quads."""
    node = np.arange((nx + 1) * (ny + 1) * (nz + 1)).reshape(nx + 1, ny + 1, nz + 1)
    points = np.argwhere(node >= 0).astype(float)
    corner = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    places = [p for p in np.ndindex(nx, ny, nz) if p not in hollow]
    hexes = np.array([node[tuple((corner + p).T)] for p in places])
    faces = hexes[:, HEX_FACES].reshape(-1, 4)
    _, number, count = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    return points, hexes, faces[count[number.reshape(-1)] == 1]


@pytest.mark.parametrize(
    ("shape", "share"),
    [
        ((4, 3, 2), 0.0),
        ((4, 3, 1), 24 / 38),  # top and bottom
        ((5, 1, 1), 20 / 22),  # all but the ends
        ((1, 1, 1), 1.0),
    ],
)
def test_share_is_that_of_the_sides_with_one_cube_between(shape, share):
    points, hexes, quads = cubes(*shape)
    assert single_share(points, hexes, [quads[::2], quads[1::2]]) == pytest.approx(share, abs=1e-15)


def test_a_step_is_thick_where_it_stands():
    # A floor of 4 x 2 with a second layer on half of it: two cubes by two have a top and a bottom to themselves.
    points, hexes, quads = cubes(4, 2, 2, hollow=[(x, y, 1) for x in (2, 3) for y in (0, 1)])
    assert single_share(points, hexes, [quads]) == pytest.approx(8 / len(quads), abs=1e-15)
