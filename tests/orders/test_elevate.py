"""Order 2: corners stay, middles lie where they belong, and a mesh is valid or refused."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.cells import HEX_EDGES
from cadsweep.errors import InputError, InvertedHexError
from cadsweep.io.sides import SIDES
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate
from cadsweep.quality import positive_inside

from ..io.io_meshes import bent_box, box, twisted_box


@pytest.mark.parametrize("nodes", [20, 27])
def test_a_mesh_without_geometry_stays_the_same_body(nodes):
    mesh = twisted_box()
    high = elevate(mesh, nodes=nodes)
    np.testing.assert_array_equal(high.points[: mesh.n_nodes], mesh.points)
    np.testing.assert_array_equal(high.hexes[:, :8], mesh.hexes)
    np.testing.assert_allclose(
        high.points[high.hexes[:, 8:20]], mesh.points[mesh.hexes[:, HEX_EDGES]].mean(axis=2), rtol=1e-15
    )
    before, after = (positive_inside(m.points, m.hexes)[1] for m in (mesh, high))
    np.testing.assert_allclose(after, before, rtol=1e-12)
    # Every node is used, once by its place.
    assert len(np.unique(high.hexes)) == high.n_nodes == len(np.unique(high.points.round(12), axis=0))


@pytest.mark.parametrize("nodes", [20, 27])
def test_boundary_quads_are_sides_of_the_hexes(nodes):
    high = bent_box(nodes)
    width = {20: 8, 27: 9}[nodes]
    sides = {frozenset(row) for row in high.hexes[:, SIDES[:, :width]].reshape(-1, width).tolist()}
    for quads in high.boundaries.values():
        assert quads.shape[1] == width
        assert all(frozenset(quad) in sides for quad in quads.tolist())
        ends = high.points[quads[:, :4]] + high.points[np.roll(quads[:, :4], -1, axis=1)]
        assert np.linalg.norm(high.points[quads[:, 4:8]] - ends / 2, axis=2).max() < 0.05


def test_bent_sides_bend_what_is_inside():
    """All nodes are put on circles at the boundary; inside, the middles follow to within a hundredth of the bow."""
    mesh = bent_box(8)
    high = bent_box(27)
    radius = np.hypot(high.points[:, 0], high.points[:, 2])
    uprights = high.hexes[:, 16:20]
    ends = high.hexes[:, [0, 1, 2, 3]]
    bow = radius[ends] * (1 - np.cos(0.125))  # of chords over 0.25 rad
    assert np.abs(radius[uprights] - radius[ends]).max() < 0.01 * bow.min()
    exact = 2 * (4**2 - 3**2) / 2
    errors = [abs(positive_inside(m.points, m.hexes)[1].sum() - exact) for m in (mesh, high)]
    assert errors[1] < 1e-2 * errors[0]


def test_hex20_and_hex27_are_the_same_body():
    volumes = [positive_inside(m.points, m.hexes)[1] for m in (bent_box(20), bent_box(27))]
    np.testing.assert_allclose(volumes[0], volumes[1], rtol=1e-3)


def test_curves_come_before_surfaces():
    mesh = box(1, 1, 1)
    segment = mesh.boundaries["source"][:1, :2]

    def lifted(points):
        return points + [0.0, 0.0, 0.01]

    def sunk(points):
        return points - [0.0, 0.0, 0.02]

    high = elevate(mesh, curves=[(segment, lifted)], surfaces=[(mesh.boundaries["source"], sunk)])
    heights = high.points[high.boundaries["source"][0, 4:8], 2]
    np.testing.assert_allclose(np.sort(heights), [-0.02, -0.02, -0.02, 0.01])


def test_a_bow_that_folds_a_hex_is_refused():
    mesh = box(2, 2, 2)

    def far(points):
        return points + [0.0, 0.0, 3.0]

    surfaces = [(mesh.boundaries["source"], far)]
    with pytest.raises(InvertedHexError, match="smaller size") as caught:
        elevate(mesh, surfaces=surfaces)
    assert len(caught.value.hexes) > 0
    assert elevate(mesh, surfaces=surfaces, allow_inverted=True).order == 2


def test_wrong_arguments_are_named():
    mesh = box(1, 1, 1)
    with pytest.raises(InputError, match="20 or 27"):
        elevate(mesh, nodes=26)
    with pytest.raises(InputError, match="order 2 already"):
        elevate(elevate(mesh))
    with pytest.raises(InputError, match="segment"):
        elevate(mesh, curves=[(np.array([[0, 7]]), lambda p: p)])
    with pytest.raises(InputError, match="quad"):
        elevate(mesh, surfaces=[(np.array([[0, 1, 2, 7]]), lambda p: p)])
    bare = HexMesh(points=mesh.points, hexes=mesh.hexes, boundaries={})
    assert elevate(bare, nodes=27).hexes.shape == (1, 27)


@pytest.mark.cad
@pytest.mark.parametrize("nodes", [20, 27])
def test_middles_lie_on_the_cad_surface(nodes):
    """A tube: every node of the bore and of the outside lies on its circle, and the volume is right to 1e-4."""
    cq = pytest.importorskip("cadquery")
    import cadsweep as cs

    tube = cq.Workplane().circle(3).circle(2).extrude(4)
    mesh = cs.sweep_mesh(tube, size=0.8, layers=3, order=2, nodes=nodes)
    assert mesh.hexes.shape[1] == nodes
    sides = np.unique(np.concatenate([quads for name, quads in mesh.boundaries.items() if name.startswith("side")]))
    radius = np.hypot(*mesh.points[sides, :2].T)
    assert np.minimum(abs(radius - 2), abs(radius - 3)).max() < 1e-6
    volume = positive_inside(mesh.points, mesh.hexes)[1].sum()
    assert volume == pytest.approx(np.pi * 5 * 4, rel=1e-4)
