"""Sheets under patches of a design's mesh: no volume, no face and no quad's own hexahedron is lost."""

import numpy as np
import pytest

from cadsweep.blends import Blend
from cadsweep.blends.sheets import DesignMesh, with_sheet
from cadsweep.cells import HEX_FACES
from cadsweep.quality import quad_areas, scaled_jacobians, volume_and_area

N = 4
TOP, FRONT = 0, 1


def skin_of(hexes):
    """Faces of hexahedra that no other has, outward."""
    every = hexes[:, HEX_FACES].reshape(-1, 4)
    _, first, count = np.unique(np.sort(every, axis=1), axis=0, return_index=True, return_counts=True)
    return every[first[count == 1]]


def block(kept):
    """Unit cells of a grid for which `kept` of their middles is true; faces are planes, by normal and place."""
    at = np.arange(N + 1)
    points = np.stack(np.meshgrid(at, at, at, indexing="ij"), axis=-1).reshape(-1, 3).astype(float)
    number = np.arange(len(points)).reshape(N + 1, N + 1, N + 1)
    cells = np.stack(np.meshgrid(*[np.arange(N)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    cells = cells[[kept(*(cell + 0.5)) for cell in cells]]
    steps = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    hexes = number[tuple((cells[:, None] + steps).transpose(2, 0, 1))]
    used, hexes = np.unique(hexes, return_inverse=True)
    points, hexes = points[used], hexes.reshape(-1, 8)
    quads = skin_of(hexes)
    corners = points[quads]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2
    planes = np.column_stack([normals, (normals * corners.mean(axis=1)).sum(axis=1)]).round(6)
    known = np.array([(0, 0, 1, N), (0, -1, 0, 0)])  # TOP and FRONT
    others = [row for row in np.unique(planes, axis=0).tolist() if row not in known.tolist()]
    order = [tuple(row) for row in [*known.tolist(), *others]]
    return DesignMesh(points, hexes, quads, np.array([order.index(tuple(row)) for row in planes.tolist()])), order


def rounding(radius):
    """A rounding of the edge between the top and the front."""
    return Blend(kind="edge", faces=(99,), supports=((TOP,), (FRONT,)), convex=True, radii=(radius, radius), turn=1.57)


def patches(n, *together):
    """Patch of every face: those `together` are one."""
    found = np.arange(n)
    found[list(together)] = min(together)
    return found


def areas(mesh):
    """Area of every face."""
    return np.bincount(mesh.faces, quad_areas(mesh.points, mesh.quads))


SHAPES = {
    "block": lambda x, y, z: True,
    "step": lambda x, y, z: z < 2 or y < 2,  # the top ends at a re-entrant edge's wall
    "notch": lambda x, y, z: z > 1 or y > 1 or x < 2,  # the front ends at a re-entrant corner
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_every_quad_of_a_patch_has_a_hexahedron_and_all_faces_stay_as_they_are(shape):
    mesh, planes = block(shape)
    found = with_sheet(mesh, patches(len(planes), TOP, FRONT), [rounding(3.0)])
    assert found is not None
    assert scaled_jacobians(found.points, found.hexes).min() > 0
    assert volume_and_area(found.points, found.quads)[0] == pytest.approx(len(mesh.hexes), rel=1e-12)
    np.testing.assert_allclose(areas(found), areas(mesh), rtol=1e-12)
    # Every quad lies in the plane of its face, and they are the skin of the hexahedra.
    normals, places = np.array(planes)[found.faces][:, :3], np.array(planes)[found.faces][:, 3]
    np.testing.assert_allclose(
        np.einsum("qij,qj->qi", found.points[found.quads], normals), places[:, None] + np.zeros(4)
    )
    assert {tuple(sorted(q)) for q in found.quads.tolist()} == {tuple(sorted(q)) for q in skin_of(found.hexes).tolist()}
    assert _hexes_of_both(mesh)
    assert not _hexes_of_both(found)


def _hexes_of_both(mesh):
    """Hexahedra with quads of the top and of the front."""
    face_of = {frozenset(quad): face for quad, face in zip(mesh.quads.tolist(), mesh.faces.tolist(), strict=True)}
    on = [{face_of.get(frozenset(hexa[side].tolist())) for side in HEX_FACES} for hexa in mesh.hexes]
    return [own for own in on if {TOP, FRONT} <= own]


@pytest.mark.parametrize(
    ("blends", "together"),
    [([rounding(0.9)], (TOP, FRONT)), ([], (TOP, FRONT)), ([rounding(3.0)], (TOP,))],
    ids=["narrow", "sharp", "apart"],
)
def test_without_a_wide_rounding_between_faces_of_one_patch_there_is_no_sheet(blends, together):
    mesh, planes = block(SHAPES["block"])
    assert with_sheet(mesh, patches(len(planes), *together), blends) is None
