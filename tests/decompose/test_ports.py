"""Bores that end in a wider one get a box each; these and the rest sweep and agree without a search."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.ports import at_ports
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad


def block(*size):
    return cq.Workplane().box(*size, centered=(True, True, False))


def bore(radius, x=0.0, y=0.0, start=0.0):
    return cq.Workplane(origin=(x, y, start)).circle(radius).extrude(200)


def port(radius, z, start, end, *, y=0.0):
    return cq.Workplane("YZ", origin=(start, 0, 0)).center(y, z).circle(radius).extrude(end - start)


def bolted():
    """Planes through the axes would meet the bolt holes, which lie in the plane of the port's height alone."""
    body = block(60, 60, 30).cut(bore(18)).cut(port(4, 15, 0, 40))
    for x, y in ((22, 22), (-22, 22), (-22, -22), (22, -22)):
        body = body.cut(bore(3.5, x, y))
    return body


def blind():
    """The box ends where the bore does; all of the block is parted there."""
    return block(60, 50, 30).cut(bore(15, start=12)).cut(port(4, 21, 0, 40, y=3))


def in_a_boss():
    boss = cq.Workplane("YZ", origin=(30, 0, 0)).center(0, 15).circle(8).extrude(10)
    return block(60, 60, 30).union(boss).cut(bore(16)).cut(port(4, 15, 0, 50))


def one_above_the_other():
    """A plane half way between two ports is the side of both boxes, and goes no further."""
    return block(60, 60, 60).cut(bore(16)).cut(port(5, 15, 0, 40)).cut(port(5, 45, 0, 40)).cut(port(4, 24, -40, 0))


def from_bore_to_bore():
    return block(100, 50, 40).cut(bore(12, -25)).cut(bore(10, 25)).cut(port(4, 20, -25, 25))


def counterbored():
    """The wider piece of a port is carried on from its shoulder to the bore, on each side by itself."""
    body = block(60, 40, 40).cut(bore(12)).cut(port(4, 20, -40, 40))
    return body.cut(port(6, 20, 24, 40)).cut(port(6, 20, -40, -26))


def into_the_end_of_a_slot():
    return block(80, 50, 30).cut(cq.Workplane(origin=(0, 0, 10)).slot2D(50, 24).extrude(40)).cut(port(4, 20, 15, 60))


def into_bores_that_overlap():
    body = block(90, 50, 30).cut(bore(18, -14)).cut(bore(18, 14))
    return body.cut(port(4, 15, 20, 60)).cut(port(4, 15, -60, -20)).cut(bore(3, 38, 20))


ALL = [
    bolted,
    blind,
    in_a_boss,
    one_above_the_other,
    from_bore_to_bore,
    counterbored,
    into_the_end_of_a_slot,
    into_bores_that_overlap,
]


@pytest.mark.parametrize("make", ALL)
def test_all_cells_sweep_and_agree_without_a_search(make):
    part = load(make())
    (cutter,) = at_ports(part.solids[0])
    cells = cut_cell(part, 0, cutter.tools)
    plan = make_plan(cells, [recognise(cell) for cell in cells.solids])
    assert sorted(plan.order) == list(range(len(cells.solids)))
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-5)


def test_nothing_is_boxed_where_no_bore_ends_in_another_or_it_has_no_room():
    nothing = block(60, 60, 30).cut(bore(18, -5)).cut(bore(3.5, 25))
    as_wide = block(60, 60, 60).cut(bore(18)).cut(port(17, 30, 0, 40))
    beside = block(80, 50, 30).cut(cq.Workplane().slot2D(50, 24).extrude(30)).cut(port(4, 15, 0, 60, y=9))
    slanted = block(60, 60, 60).cut(bore(12)).cut(port(4, 30, 0, 60).rotate((0, 0, 30), (0, 1, 30), 30))
    assert all(at_ports(load(body).solids[0]) == [] for body in (nothing, as_wide, beside, slanted))
