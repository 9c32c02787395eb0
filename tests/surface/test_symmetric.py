"""Plane caps with mirrors get meshes with the same mirrors, also where a mesher makes their quads."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import cadsweep as cs
from cadsweep.polygons import signed_area
from cadsweep.surface.symmetry import find_wedges
from cadsweep.surface.wedge_domain import Core, cut_wedge

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


def ring_of_nodes(radius, n, middle=(0.0, 0.0)):
    at = 2 * np.pi * np.arange(n) / n
    return np.array(middle) + radius * np.column_stack([np.cos(at), np.sin(at)])


def top(mesh):
    return mesh.points[mesh.points[:, 2] > mesh.points[:, 2].max() - 1e-9][:, :2]


def off_mirror(points, angle):
    """Greatest distance of a node's image from a node, in sizes, under the mirror at an angle through the origin."""
    c, s = np.cos(2 * angle), np.sin(2 * angle)
    far, _ = cKDTree(points).query(points @ np.array([[c, s], [s, -c]]))
    return far.max() / np.ptp(points)


def flange(n_holes, bore):
    work = cq.Workplane().circle(10).extrude(3).faces(">Z").workplane()
    if bore:
        work = work.hole(2 * bore).faces(">Z").workplane()
    return work.polarArray(7, 0, 360, n_holes).circle(0.9).cutThruAll()


def test_mirrors_of_nodes_are_found():
    hexagonal = [ring_of_nodes(3, 24), ring_of_nodes(1, 12)[::-1]]
    assert next(wedge.n for wedge in find_wedges(hexagonal)) == 6  # diameters through 12 nodes; others meet segments
    assert find_wedges([ring_of_nodes(3, 24), ring_of_nodes(1, 12, (0.3, 0.2))[::-1]]) == []
    one = find_wedges([ring_of_nodes(3, 24), ring_of_nodes(1, 12, (0.3, 0.0))[::-1]])
    assert [wedge.n for wedge in one] == [1]
    # A mirror that meets segments in their middles alone is none: 5 nodes have each one node and one middle.
    assert find_wedges([ring_of_nodes(3, 5)]) == []


@pytest.mark.parametrize(("n_holes", "bore"), [(4, 4), (6, 4), (8, 4)])
def test_a_flange_has_the_mirrors_of_its_holes(n_holes, bore):
    mesh = cs.sweep_mesh(flange(n_holes, bore), source="<Z", layers=2)
    points = top(mesh)
    for k in range(n_holes):
        assert off_mirror(points, np.pi * k / n_holes) < 1e-9
    assert mesh.info["quality"].min_scaled_jacobian > 0.6


def test_a_plate_with_rounded_corners_and_holes_has_both_mirrors():
    work = cq.Workplane().box(40, 30, 5).edges("|Z").fillet(5).faces(">Z").workplane()
    mesh = cs.sweep_mesh(work.rect(26, 18, forConstruction=True).vertices().hole(4), source="<Z", layers=2)
    for angle in (0, np.pi / 2):
        assert off_mirror(top(mesh), angle) < 1e-9


def test_quads_grow_between_slots_with_mirrors_as_without():
    """Sixteen slots in rows, and with the first of them moved a little: no mirrors are left then."""
    counts = []
    for off in (0.0, 0.4):
        places = [(14 * i + (off if i == j == 0 else 0.0), 9 * j) for i in range(4) for j in range(4)]
        plate = cq.Workplane().rect(56, 36).extrude(3).translate((21, 13.5, 0))
        plate = plate.cut(cq.Workplane().pushPoints(places).slot2D(9, 3).extrude(3))
        counts.append(cs.sweep_mesh(plate, layers=1).n_hexes)
    assert counts[0] < 1.2 * counts[1]


def test_one_mirror_is_kept_and_none_is_no_error():
    fish = cq.Workplane().polyline([(0, 0), (8, 9), (25, 9), (36, 0), (25, -9), (8, -9)]).close().extrude(4)
    fish = fish.cut(cq.Workplane().center(12, 0).circle(3).extrude(4))
    assert off_mirror(top(cs.sweep_mesh(fish, source="<Z")), 0) < 1e-9
    odd = cq.Workplane().polyline([(0, 0), (10, 7), (25, 1), (12, -4)]).close().extrude(4)
    assert cs.sweep_mesh(odd.faces(">Z").workplane().hole(4), source="<Z").quality().valid


def arms(n):
    part = cq.Workplane().circle(4).extrude(3)
    for k in range(n):
        arm = cq.Workplane().center(8, 0).rect(16, 4).extrude(3)
        part = part.union(arm.rotate((0, 0, 0), (0, 0, 1), 360 * k / n))
    return part


def pinwheel(n):
    angles = 2 * np.pi * np.arange(n) / n
    tips, roots = ([(r * np.cos(a), r * np.sin(a)) for a in angles + off] for r, off in ((15, 0), (8, 0.35)))
    return cq.Workplane().polyline([p for pair in zip(tips, roots, strict=True) for p in pair]).close().extrude(3)


def triangle_with_holes():
    work = cq.Workplane().polygon(3, 30).extrude(3).faces(">Z").workplane(origin=(0, 0, 0))
    return work.polarArray(7, 0, 360, 3).hole(3)


TURNED = {
    "three arms and a hub": (lambda: arms(3), 3),
    "five arms and a hub": (lambda: arms(5), 5),
    "pinwheel, no mirror": (lambda: pinwheel(5), 5),
    "pinwheel of four": (lambda: pinwheel(4), 4),
    "octagon": (lambda: cq.Workplane().polygon(8, 20).extrude(3), 8),
    "triangle with three holes": (triangle_with_holes, 3),
    "disc with five holes": (lambda: flange(5, 0), 5),
    "disc": (lambda: cq.Workplane().circle(7.9).extrude(3), 4),
    "ring": (lambda: cq.Workplane().circle(13.7).circle(11).extrude(3), 4),
}


@pytest.mark.parametrize("name", TURNED)
def test_what_turns_carry_to_itself_is_meshed_so(name):
    make, n = TURNED[name]
    mesh = cs.sweep_mesh(make(), source="<Z", size=1.0, layers=1)
    points = top(mesh)
    c, s = np.cos(2 * np.pi / n), np.sin(2 * np.pi / n)
    far, _ = cKDTree(points).query(points @ np.array([[c, s], [-s, c]]))
    assert far.max() < 1e-9 * np.ptp(points)
    assert mesh.quality().valid


@pytest.mark.parametrize(("columns", "rows"), [(2, 2), (3, 1), (3, 2)])
def test_bolt_holes_in_a_plate_have_both_mirrors(columns, rows):
    work = cq.Workplane().rect(12 * columns, 12 * rows).extrude(3).faces(">Z").workplane(origin=(0, 0, 0))
    mesh = cs.sweep_mesh(work.rarray(11, 11, columns, rows).hole(3), source="<Z", size=1.0, layers=1)
    for angle in (0, np.pi / 2):
        assert off_mirror(top(mesh), angle) < 1e-9


def test_half_of_a_channel_is_cut_out_though_its_middle_is_outside():
    corners = np.array([(0, -6), (8, -6), (8, -4), (2, -4), (2, 4), (8, 4), (8, 6), (0, 6)], dtype=float)
    pairs = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    nodes = np.concatenate([np.linspace(a, b, int(np.abs(b - a).sum()) + 1)[:-1] for a, b in pairs])
    (wedge,) = find_wedges([nodes])
    core = Core(points=nodes, loops=[np.arange(len(nodes))])
    half = cut_wedge(core, wedge, 1.0)
    (loop,) = half.loops
    assert not core.is_centre_inside(wedge)
    assert signed_area(half.places(nodes)[loop]) == pytest.approx(signed_area(nodes) / 2)


def test_a_rounded_rectangle_has_a_core_as_symmetric_as_itself():
    mesh = cs.sweep_mesh(cq.Workplane().rect(50, 30).extrude(5).edges("|Z").fillet(7), source="<Z")
    for angle in (0, np.pi / 2):
        assert off_mirror(top(mesh), angle) < 1e-9


@pytest.mark.parametrize("n", [12, 15])
def test_kites_of_many_teeth_are_carried_by_the_turns_of_both(n):
    at = 2 * np.pi * np.arange(4 * n) / (4 * n)
    nodes = np.where(np.arange(4 * n) % 4 < 2, 10.0, 8.0)[:, None] * np.column_stack([np.cos(at), np.sin(at)])
    wedge = find_wedges([nodes], between=True)[0]
    assert wedge.n == n
    core = Core(points=nodes, loops=[np.arange(len(nodes))])
    kept = core.with_kites(wedge, 1.0).symmetry(wedge)
    assert n % kept.n == 0  # kites of n rays would be too sharp
    points = core.with_kites(wedge, 1.0).points
    for element in kept.elements():
        assert cKDTree(points).query(kept.carry(element, points))[0].max() < 1e-9
    assert core.sharpest(wedge) == pytest.approx(np.sin(np.pi / n))
