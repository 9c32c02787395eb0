"""Slots cross bores, and each other, as bores do that are spread out: planes part them into cells with a fill each."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import load
from cadsweep.cad.edit.axes import find_axes
from cadsweep.cad.edit.crossings import at_crossings, find_crossings
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.slots import find_passages
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad


def slotted(length, width, turn, *, bore=None, at=(0.0, 0.0), slot=None):
    """A block with a slot along z, its long side along x or, turned, along y; a bore or another slot goes along x."""
    block = cq.Workplane().box(60, 60, 40)
    block = block.cut(cq.Workplane("XY").slot2D(length, width, turn).extrude(20, both=True))
    other = cq.Workplane("YZ").center(*at)
    other = other.circle(bore) if slot is None else other.slot2D(*slot)
    return block.cut(other.extrude(30, both=True))


CASES = {
    "a bore in the flat sides": slotted(24, 8, 90, bore=3, at=(1, 0)),
    "a bore at the end": slotted(24, 8, 90, bore=5, at=(9, 0)),
    "a bore beyond most of the end": slotted(26, 12, 90, bore=4, at=(10.5, 0)),
    "a bore beyond the end": slotted(24, 6, 90, bore=6, at=(13, 1)),
    "a bore around a slot": slotted(14, 6, 90, bore=10),
    "a bore along the long side": slotted(24, 6, 0, bore=6, at=(2, 0)),
    "two slots": slotted(16, 6, 0, slot=(26, 12, 0)),
    "slots across each other": slotted(26, 12, 90, slot=(20, 8, 90), at=(4, 0)),
}


@pytest.mark.parametrize("case", CASES)
def test_every_cell_of_a_crossing_is_filled_and_all_agree(case):
    part = load(CASES[case])
    (cutter,) = at_crossings(part.solids[0])
    cells = cut_cell(part, 0, cutter.tools)
    fills = [recognise(cell) for cell in cells.solids]
    assert all(fills)
    make_plan(cells, fills)
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)


def test_a_slot_is_spread_from_one_end_to_the_other():
    (solid,) = load(slotted(24, 8, 90, bore=3)).solids
    bore, slot = find_passages(solid)
    assert not bore.is_slot
    assert slot.is_slot
    assert np.linalg.norm(slot.spread) == pytest.approx(np.ptp(solid.vertices[:, 1]) * 16 / 60)
    (crossing,) = find_crossings([bore, slot])
    # What they have in common across both is all of the bore.
    assert np.ptp(crossing.common) == pytest.approx(2.0 * bore.radius)


def test_ends_of_a_slot_that_a_bore_parts_are_no_bores():
    """Two faces of one end, one behind the other, go half around together."""
    (solid,) = load(slotted(14, 6, 90, bore=10)).solids
    assert {round(axis.radius / find_axes(solid)[0].radius, 6) for axis in find_axes(solid)} == {1.0}


def test_a_bore_that_passes_by_a_slot_does_not_cross_it():
    (solid,) = load(slotted(24, 8, 90, bore=3, at=(20, 0))).solids
    assert find_crossings(find_passages(solid)) == []


def test_a_keyway_does_not_cross_its_shaft():
    shaft = cq.Workplane("YZ").circle(10).extrude(50).cut(cq.Workplane(origin=(25, 0, 6)).slot2D(20, 6).extrude(10))
    (solid,) = load(shaft).solids
    assert [axis.is_slot for axis in find_passages(solid)] == [False, True]
    assert find_crossings(find_passages(solid)) == []
