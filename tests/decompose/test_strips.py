"""What goes across the axis of a turned body is parted by strips, rings and levels into cells that all agree."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.fillets import divide_corners
from cadsweep.cad.edit.strips import along_features
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad

FLAT = 1e-4


def rod(radius, length, *, start=0.0):
    return cq.Workplane(origin=(0, 0, start)).circle(radius).extrude(length)


def drilled(radius, z, *, plane="YZ"):
    return cq.Workplane(plane).center(0, z).circle(radius).extrude(50, both=True)


def keyway(width, length, floor, z):
    return cq.Workplane("YZ", origin=(floor, 0, 0)).center(0, z).slot2D(length, width, 90).extrude(50)


def piston():
    groove = rod(40, 4, start=50).cut(rod(31, 4, start=50))
    return rod(35, 60).cut(rod(26, 46)).cut(groove).cut(drilled(9, 24))


def keyed_and_drilled():
    """A hole across, and a keyway square to it."""
    shaft = rod(16, 30).union(rod(12, 55, start=30))
    return shaft.cut(keyway(6, 24, 8.5, 62)).cut(drilled(4, 14, plane="XZ"))


def drilled_sleeve():
    """The hole lies within faces, on which OpenCASCADE's quick integrals are not exact."""
    return rod(18, 80).cut(rod(11, 80)).cut(drilled(4, 25)).cut(drilled(4, 55))


def banjo_bolt():
    """A hexagon goes all around the axis: the strips leave through its flats."""
    bolt = cq.Workplane().polygon(6, 19).extrude(7).union(rod(6, 38))
    return bolt.cut(rod(2.5, 26, start=12)).cut(drilled(1.5, 20))


def rounded_pin():
    """Every rounding becomes a ring all around: four grids, or its pieces would follow each other in a circle."""
    pin = rod(11, 22).union(rod(18, 8, start=22))
    return pin.faces("<Z or >Z").edges().fillet(2).cut(drilled(4, 10))


def drilled_wider_than_its_bore():
    """The strip holds the bore, and the counterbore ends in a cone, as its ring would touch the hole."""
    tube = rod(18, 30).cut(rod(4, 30)).cut(rod(6, 4))
    return tube.cut(drilled(6, 18))


def keyed_tube():
    """No width on a coarse scale fits into the bore, and the ring of the shaft lies under the floor of the keyway."""
    shaft = rod(24, 14).union(rod(18, 20, start=14)).cut(rod(4, 34))
    return shaft.cut(keyway(2, 8, 22, 7)).cut(drilled(3, 24, plane="XZ"))


def keyed_and_half_drilled():
    """The hole ends on the axis: its floor goes on through the strip of the keyway."""
    shaft = rod(11, 31).union(rod(14, 20, start=31))
    return shaft.cut(keyway(6, 27, 7, 15.5)).cut(cq.Workplane("XZ").center(0, 41).circle(3).extrude(50))


def chamfered():
    """Lines of chamfers at both ends: what is swept along the axis beside the strips is parted along both."""
    shaft = rod(14, 10, start=30).union(rod(10, 80)).faces("<Z").chamfer(1).faces(">Z").chamfer(1.5)
    return shaft.cut(keyway(5, 18, 6.5, 62)).cut(drilled(2, 15, plane="XZ"))


def chamfered_with_one_strip():
    return rod(9, 40).faces("<Z or >Z").chamfer(1).cut(drilled(3, 22))


@pytest.mark.parametrize(
    "make",
    [
        piston,
        keyed_and_drilled,
        drilled_sleeve,
        banjo_bolt,
        rounded_pin,
        drilled_wider_than_its_bore,
        keyed_tube,
        keyed_and_half_drilled,
        chamfered,
        chamfered_with_one_strip,
    ],
)
def test_all_cells_sweep_and_agree_without_a_search(make):
    part = load(make())
    part = divide_corners(part) or part
    (cutter,) = along_features(part.solids[0], FLAT)
    cells = cut_cell(part, 0, cutter.tools)
    plan = make_plan(cells, [recognise(cell) for cell in cells.solids])
    assert sorted(plan.order) == list(range(len(cells.solids)))
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-5)


def test_nothing_is_parted_where_nothing_goes_across_or_there_is_no_room():
    wide = rod(10, 40).cut(drilled(9.5, 20))
    assert all(along_features(load(body).solids[0], FLAT) == [] for body in (rod(10, 40), wide))


def test_faces_divided_next_to_one_point_share_it(tmp_path):
    """The wall of the hole and the rod's are divided where they meet: one vertex, no edge of no length."""
    groove = rod(40, 2.5, start=48).cut(rod(32, 2.5, start=48))
    hole = cq.Workplane(cq.Solid.makeCylinder(9, 100, cq.Vector(-50, 0, 28), cq.Vector(1, 0, 0)))
    cq.exporters.export(rod(35, 60).cut(groove).cut(hole), str(tmp_path / "drilled.step"))
    (solid,) = load(tmp_path / "drilled.step").solids
    assert min(edge.length for edge in solid.edges) > 1.0


def test_pipes_of_unequal_width_that_cross_are_divided(tmp_path):
    """The seams of two bores meet in one point, at which both are divided."""

    def along_and_up(radius, other):
        along = cq.Solid.makeCylinder(radius, 100, cq.Vector(-50, 0, 0), cq.Vector(1, 0, 0))
        return cq.Workplane(along), cq.Workplane(cq.Solid.makeCylinder(other, 90, cq.Vector(0, 0, -45)))

    (along, up), (bore, other) = along_and_up(18, 11), along_and_up(14, 7.5)
    cq.exporters.export(along.union(up).cut(bore).cut(other), str(tmp_path / "cross.step"))
    (solid,) = load(tmp_path / "cross.step").solids
    assert min(edge.length for edge in solid.edges) > 1.0


def test_a_body_without_cylinders_has_no_strips():
    """A bore across a ring: there is no cylinder that the sides of a strip would leave through."""
    ring = cq.Workplane(cq.Solid.makeTorus(20, 6)).cut(cq.Workplane("YZ").circle(2).extrude(40))
    assert along_features(load(ring).solids[0], FLAT) == []
