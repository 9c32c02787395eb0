"""What stands on a turned body or goes into it is parted by spokes, at any angles, into cells that all agree."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import load
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.spokes import along_spokes
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad

FLAT = 1e-4


def rod(radius, length, *, start=0.0):
    return cq.Workplane(origin=(0, 0, start)).circle(radius).extrude(length)


def turned_by(body, angle):
    return body.rotate((0, 0, 0), (0, 0, 1), angle)


def hub(*, ribs=(), holes=(), bore=15):
    """A flange with a hub; ribs run out on the flange, holes go through the hub's wall."""
    body = rod(50, 12).union(rod(28, 50))
    rib = cq.Workplane("XZ").polyline([(27, 12), (46, 12), (27, 40)]).close().extrude(3, both=True)
    for angle in ribs:
        body = body.union(turned_by(rib, angle))
    body = body.cut(rod(bore, 60)) if bore else body
    for angle in holes:
        body = body.cut(turned_by(cq.Workplane("YZ").center(0, 30).circle(2.5).extrude(60), angle))
    return body


@pytest.mark.parametrize(
    "features",
    [
        {"ribs": (0, 120, 240)},
        {"ribs": (0, 90, 180, 270), "holes": (45,)},
        {"holes": (0, 72, 200)},
        {"ribs": (0, 120), "bore": 0},
    ],
    ids=["three ribs", "four ribs and a hole", "three holes", "no bore"],
)
def test_all_cells_sweep_and_agree_without_a_search(features):
    part = load(hub(**features))
    (cutter,) = along_spokes(part.solids[0], FLAT)
    cells = cut_cell(part, 0, cutter.tools)
    plan = make_plan(cells, [recognise(cell) for cell in cells.solids])
    assert sorted(plan.order) == list(range(len(cells.solids)))
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-5)


def test_there_are_no_spokes_where_nothing_goes_outwards_or_without_room():
    ribs = tuple(range(0, 360, 20))
    for body in (hub(), hub(ribs=ribs, bore=15), rod(30, 20)):
        assert along_spokes(load(body).solids[0], FLAT) == []


def test_a_spoke_ends_on_the_ring_around_what_it_is_for():
    """A bolt hole beyond the hub, at the angle of the hole through its wall, keeps its own circle."""
    body = hub(holes=(0,)).cut(cq.Workplane().center(40, 0).circle(4).extrude(20))
    part = load(body)
    (cutter,) = along_spokes(part.solids[0], FLAT)
    cells = cut_cell(part, 0, cutter.tools)
    bolt = np.array([40.0, 0.0])
    radii = {
        round(float(np.hypot(*(edge.curve.evaluate(np.array([0.5]))[0, :2] - bolt))), 6)
        for solid in cells.solids
        for edge in solid.edges
        if edge.kind == "circle" and np.hypot(*(edge.curve.evaluate(np.array([0.5]))[0, :2] - bolt)) < 4.5
    }
    assert radii == {4.0}
