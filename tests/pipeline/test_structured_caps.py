"""Simple caps get the quads that a person would draw: regular, and as symmetric as the cap."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

import cadsweep as cs

pytestmark = pytest.mark.cad


def polygon(*corners):
    import cadquery as cq

    return cq.Workplane().polyline(corners).close().extrude(1)


def plate(*cuts, width=6, height=4):
    import cadquery as cq

    part = cq.Workplane().rect(width, height).extrude(1)
    for cut in cuts:
        part = part.cut(cut(cq.Workplane()).extrude(1))
    return part


RECTILINEAR = {
    "L": lambda: polygon((0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)),
    "T": lambda: polygon((0, 0), (1, 0), (1, 2), (2, 2), (2, 3), (-1, 3), (-1, 2), (0, 2)),
    "U": lambda: polygon((0, 0), (3.1, 0), (3.1, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)),
    "leaning L": lambda: polygon((0, 0), (3, 0.2), (2.9, 1.1), (1.1, 1), (1, 3), (0, 2.9)),
    "one hole": lambda: plate(lambda w: w.circle(0.6)),
    "four holes": lambda: plate(lambda w: w.rect(4, 2, forConstruction=True).vertices().circle(0.4)),
    "window": lambda: plate(lambda w: w.rect(2, 1.5)),
    "holes anywhere": lambda: plate(lambda w: w.pushPoints([(-2, 0.5), (1, -0.7), (2, 1.1)]).circle(0.5)),
}
ROUND = {
    "disc": lambda w: w.circle(1).extrude(1),
    "ellipse": lambda w: w.ellipse(2, 1).extrude(1),
    "slot": lambda w: w.slot2D(4, 1).extrude(1),
}


def source_quads(mesh):
    """Quads of the section, its nodes' points on the source, and which of them lie inside."""
    quads = mesh.structure.quads
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    edges, uses = np.unique(ends, axis=0, return_counts=True)
    inner = np.ones(quads.max() + 1, dtype=bool)
    inner[edges[uses == 1]] = False
    return quads, mesh.points[: len(inner)], inner


def n_irregular(mesh):
    quads, _, inner = source_quads(mesh)
    return int((np.bincount(quads.ravel())[inner] != 4).sum())


@pytest.mark.parametrize("size", [0.15, 0.11])
@pytest.mark.parametrize("name", RECTILINEAR)
def test_a_cap_of_right_corners_has_no_irregular_node_inside(name, size):
    mesh = cs.sweep_mesh(RECTILINEAR[name](), size=size, layers=1)
    assert mesh.quality().valid
    # Beside holes free quads may be better than a lattice that has to bend: they are taken where it is below 0.65.
    assert n_irregular(mesh) == 0 or (len(mesh.structure.loops) > 1 and mesh.quality().min_scaled_jacobian > 0.65)


@pytest.mark.parametrize("name", ROUND)
def test_a_cap_without_corners_has_four(name):
    import cadquery as cq

    mesh = cs.sweep_mesh(ROUND[name](cq.Workplane()), size=0.12, layers=1)
    assert mesh.quality().min_scaled_jacobian > 0.75
    assert n_irregular(mesh) == 4


@pytest.mark.parametrize("name", ["disc", "ellipse", "slot", "T"])
def test_what_is_symmetric_is_meshed_so(name):
    import cadquery as cq

    part = ROUND[name](cq.Workplane()) if name in ROUND else RECTILINEAR[name]().translate((-0.5, 0, 0))
    mesh = cs.sweep_mesh(part, size=0.12, layers=1)
    _, points, _ = source_quads(mesh)
    for mirror in ([-1, 1, 1],) if name == "T" else ([-1, 1, 1], [1, -1, 1]):
        distance = np.linalg.norm((points * mirror)[:, None] - points, axis=2).min(axis=1)
        assert distance.max() < 1e-9


def test_a_hole_that_finds_no_place_in_the_lattice_is_meshed_all_the_same():
    mesh = cs.sweep_mesh(plate(lambda w: w.pushPoints([(2.6, 1.6)]).circle(0.3)), size=0.5, layers=1)
    assert mesh.quality().valid
    assert n_irregular(mesh) > 0


def test_quads_still_grow_where_the_outline_is_fine():
    fine = cs.sweep_mesh(plate(), size=0.6, layers=1, sizes={"edges:|X and >Y": 0.1})
    assert len(fine.structure.quads) < 60 * 40 / 2


@pytest.mark.parametrize(("n", "rim", "bore", "pitch", "hole"), [(6, 40, 20, 31, 4), (4, 50, 20, 36, 5)])
def test_a_flange_is_circles_and_rays_around_its_holes(n, rim, bore, pitch, hole):
    import cadquery as cq

    flange = cq.Workplane().circle(rim).circle(bore).extrude(5)
    flange = flange.faces(">Z").workplane().polarArray(pitch, 0, 360, n).circle(hole).cutThruAll()
    mesh = cs.sweep_mesh(flange, size=4.0, layers=1)
    assert n_irregular(mesh) == 0
    assert mesh.info["quality"].min_scaled_jacobian > 0.65
    _, points, _ = source_quads(mesh)
    turn = 2 * np.pi / n
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    for element in (rotation, np.diag([1.0, -1.0, 1.0])):
        distance = np.linalg.norm((points @ element.T)[:, None] - points, axis=2).min(axis=1)
        assert distance.max() < 1e-9 * 2 * rim


def test_a_ring_takes_holes_that_are_nowhere_alike():
    import cadquery as cq

    ring = cq.Workplane().circle(20).circle(10).extrude(2)
    ring = ring.faces(">Z").workplane().pushPoints([(14.5, 1), (-3, 15), (-11, -9)]).circle(1.5).cutThruAll()
    mesh = cs.sweep_mesh(ring, size=1.5, layers=1)
    assert n_irregular(mesh) == 0
    assert mesh.info["quality"].min_scaled_jacobian > 0.5


@pytest.mark.parametrize(("n", "pitch", "irregular"), [(6, 36, 7), (4, 30, 4)])
def test_a_round_plate_with_holes_is_rings_around_a_core(n, pitch, irregular):
    import cadquery as cq

    disc = cq.Workplane().circle(50).extrude(4).faces(">Z").workplane().polarArray(pitch, 0, 360, n).hole(9)
    mesh = cs.sweep_mesh(disc, size=3, layers=1)
    # A rectangle has an irregular node at each corner, six kites one at each corner and one in their middle.
    assert n_irregular(mesh) == irregular
    assert mesh.info["quality"].min_scaled_jacobian > 0.65
    _, points, _ = source_quads(mesh)
    turn = 2 * np.pi / n
    rotation = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    for element in (rotation, np.diag([1.0, -1.0, 1.0])):
        distance, _ = cKDTree(points).query(points @ element.T)
        assert distance.max() < 1e-9 * 100


def test_a_rounded_plate_is_rings_around_a_lattice_with_its_holes():
    part = plate(lambda w: w.circle(0.8)).edges("|Z and (<X or >X)").fillet(0.7)
    mesh = cs.sweep_mesh(part, layers=1)
    assert n_irregular(mesh) == 4
    assert mesh.info["quality"].min_scaled_jacobian > 0.65


@pytest.mark.parametrize("n", [3, 5, 6])
def test_a_polygon_is_grids_that_meet_in_its_middle(n):
    import cadquery as cq

    mesh = cs.sweep_mesh(cq.Workplane().polygon(n, 20).extrude(5), size=1.1, layers=1)
    assert n_irregular(mesh) == 1
    # What meets in the middle, or is a corner of the polygon, cannot be better; their neighbours bend a little more.
    sharpest = min(2 * np.pi / n, (n - 2) * np.pi / n, key=np.sin)
    assert mesh.info["quality"].min_scaled_jacobian > 0.95 * np.sin(sharpest)
    quads, points, _ = source_quads(mesh)
    edges = np.linalg.norm(points[quads] - np.roll(points[quads], 1, axis=1), axis=2)
    assert edges.max() < 2.5 * 1.1


@pytest.mark.parametrize(("n", "bore", "inside", "thick"), [(6, 22, 15, 30), (5, 20, 16, 5), (3, 35, 30, 5)])
def test_a_tube_beside_a_ring_with_holes_has_as_many_segments_around(n, bore, inside, thick):
    import cadquery as cq

    plate = cq.Workplane().circle(50).circle(bore).extrude(thick)
    ring = plate.faces(">Z").workplane().polarArray(25 + bore / 2, 0, 360, n).hole(7)
    sleeve = cq.Workplane().circle(bore).circle(inside).extrude(40)
    mesh = cs.sweep_mesh(cq.Assembly().add(ring, name="ring").add(sleeve, name="sleeve"))
    _, uses = np.unique(np.sort(mesh.hexes, axis=None), return_counts=True)
    inner = np.ones(len(uses), dtype=bool)
    for quads in (*mesh.boundaries.values(), *mesh.interfaces.values()):
        inner[quads] = False
    assert (uses[inner] == 8).all()
    # The far end of the sleeve, which no hole is in, wants fewer: what is turned by a hole is itself all the same.
    turn = 2 * np.pi / n
    turned = mesh.points @ np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    distance, _ = cKDTree(mesh.points).query(turned)
    assert distance.max() < 1e-9 * 100
