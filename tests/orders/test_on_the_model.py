"""Orders above 1 on CAD models: rows bend with their wall, what is invalid when bent is mended on the model."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.lattice import EDGES
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
cs = pytest.importorskip("cadsweep")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(300)]


def raised(mesh: HexMesh, order: int, nodes: int = 27, **options) -> HexMesh:
    entities = mesh.origin.entities
    return elevate(
        mesh, order=order, nodes=nodes, curves=entities.on_curves(), surfaces=entities.on_surfaces(), **options
    )


def edges_of(mesh: HexMesh) -> tuple[np.ndarray, np.ndarray]:
    """Ends (m * 12, 2) and nodes between (m * 12, p - 1) of the edges of all hexahedra."""
    inner = mesh.order - 1
    ends = mesh.hexes[:, EDGES].reshape(-1, 2)
    return ends, mesh.hexes[:, 8 : 8 + 12 * inner].reshape(-1, inner)


def radius(points: np.ndarray) -> np.ndarray:
    return np.hypot(points[..., 0], points[..., 1])


@pytest.mark.parametrize(("order", "nodes"), [(2, 20), (2, 27), (4, 20)])
def test_rows_on_a_bore_bend_with_it_in_the_caps_too(order, nodes):
    """Each row is a circle but for a fifth of what its chords are off: towards the straight sides that fades."""
    walls = {"%CYLINDER": cs.WallLayers(first=0.02, growth=1.3, n=6)}
    plate = cq.Workplane().box(10, 10, 2).faces(">Z").workplane().hole(4)
    mesh = cs.sweep_mesh(plate, size=1.5, wall_layers=walls, order=order, nodes=nodes)
    assert mesh.quality().valid
    heights = 2.0 + 0.02 * np.cumsum([0.0, *1.3 ** np.arange(6)])
    ends, between = edges_of(mesh)
    off = np.abs(radius(mesh.points[between]) - radius(mesh.points[ends[:, :1]]))
    for height in heights:
        around = (np.abs(radius(mesh.points[ends]) - height) < 1e-6).all(axis=1)
        around &= np.linalg.norm(np.diff(mesh.points[ends], axis=1)[:, 0, :2], axis=1) > 0.1
        assert around.any()
        chord = radius(mesh.points[ends[around]].mean(axis=1))
        assert off[around].max() < 0.2 * (height - chord).max()


def slot():
    return cq.Workplane().slot2D(4, 1).extrude(0.5)


def on_slot(points):
    """Distance from the slot's wall."""
    along = np.maximum(np.abs(points[:, 0]) - 1.5, 0.0)
    return np.abs(np.hypot(along, points[:, 1]) - 0.5)


def ball():
    return cq.Workplane().sphere(1)


def on_ball(points):
    return np.abs(np.linalg.norm(points, axis=1) - 1.0)


@pytest.mark.parametrize(
    ("model", "off", "name", "size"), [(slot, on_slot, "side", 0.5), (ball, on_ball, "", 0.7)], ids=["slot", "ball"]
)
def test_what_is_invalid_when_bent_is_mended_on_the_model(model, off, name, size):
    coarse = cs.sweep_mesh(model(), size=size, allow_coarse=True)
    for order, nodes in ((2, 20), (2, 27), (3, 27), (5, 27)):
        broken = raised(coarse, order, nodes, allow_inverted=True).quality()
        assert broken.n_inverted > 0
        mesh = raised(coarse, order, nodes)
        assert mesh.quality().valid
        assert f"order {order}: {broken.n_inverted} hexahedra" in mesh.info["notes"][-1]
        np.testing.assert_array_equal(mesh.points[: coarse.n_nodes], coarse.points)
        there = np.concatenate([quads for key, quads in mesh.boundaries.items() if key.startswith(name)])
        # Between cells that a cut made, nodes have slid on the face.
        assert off(mesh.points[np.unique(there)]).max() < 1e-6


@pytest.mark.parametrize("order", [3, 5])
def test_cells_of_a_cut_are_of_any_order(order):
    tube = cq.Workplane().circle(1).circle(0.6).extrude(1)
    mesh = cs.sweep_mesh(tube, size=0.4, cuts=["plane x=0.1"], order=order)
    assert mesh.quality().valid
    assert len(mesh.info["sweeps"]) == 2
    sides = np.unique(np.concatenate([quads for name, quads in mesh.boundaries.items() if name.startswith("side")]))
    assert np.abs(np.abs(radius(mesh.points[sides]) - 0.8) - 0.2).max() < 1e-9
    assert mesh.quality().volume == pytest.approx(0.64 * np.pi, rel=3 * 10.0**-order)


@pytest.mark.parametrize("order", [3, 4])
def test_solids_of_an_assembly_share_the_nodes_of_their_contact(order):
    model = cq.Assembly()
    model.add(cq.Workplane().box(4, 4, 1).faces(">Z").workplane().hole(2), name="plate")
    model.add(cq.Workplane().circle(1).extrude(1.5).translate((0, 0, -0.5)), name="pin")
    mesh = cs.sweep_mesh(model, size=0.8, order=order)
    assert mesh.quality().valid
    contact = np.unique(mesh.interfaces["plate__pin"])
    assert np.abs(radius(mesh.points[contact]) - 1.0).max() < 1e-9
    shared = np.intersect1d(*(mesh.hexes[ids] for ids in mesh.parts.values()))
    np.testing.assert_array_equal(shared, contact)
    assert mesh.quality().volume == pytest.approx(16 + 0.5 * np.pi, rel=10.0**-order)
