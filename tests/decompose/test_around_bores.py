"""A hub with pins on the sides around its bore is parted between the sides, and each piece swept to the bore."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.cad.edit.around_bores import around_bores
from cadsweep.cad.edit.central import plane_tool
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad


def hub(angles, *, bore=4.0):
    """A block of 24 x 24 x 20 with pins on some of its sides."""
    made = cq.Workplane().box(24, 24, 20)
    for angle in angles:
        made = made.union(cq.Workplane("YZ").circle(7).extrude(32).rotate((0, 0, 0), (0, 0, 1), angle))
    return made.cut(cq.Workplane(origin=(0, 0, -10)).circle(bore).extrude(20))


def test_every_piece_is_swept_and_all_agree():
    angles = (0, 90, 180, 270)
    part = load(hub(angles))
    (cutter,) = around_bores(part.solids[0])
    cells = cut_cell(part, 0, cutter.tools)
    assert len(cells.solids) == len(angles)
    for face in part.solids[0].faces:
        if face.kind == "plane" and len(face.loops) == 2 and abs(face.normal[2]) < 0.5:  # below a pin
            tool = plane_tool(part.solids[0], face.normal, face.center)
            (cells,) = filter(None, (cut_cell(cells, j, [tool]) for j in range(len(cells.solids))))
    plan = make_plan(cells, [recognise(cell) for cell in cells.solids])
    assert sorted(plan.order) == list(range(2 * len(angles)))
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)


@pytest.mark.parametrize("angles", [(), (0,), (0, 90), (0, 180)])
def test_a_hub_whose_pins_are_not_all_around_is_left(angles):
    assert around_bores(load(hub(angles)).solids[0]) == []


def test_what_opens_into_the_bore_is_left_to_crossings():
    cross = cq.Workplane("YZ").circle(2).extrude(40, both=True).union(cq.Workplane("XZ").circle(2).extrude(40))
    assert around_bores(load(hub((0, 90, 180, 270)).cut(cross)).solids[0]) == []
