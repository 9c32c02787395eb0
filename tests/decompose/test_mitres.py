"""Arms of equal radii that meet in one point are parted at their mitres, and each half is swept along its arm."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load, recognition
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.mitres import at_mitres

pytestmark = pytest.mark.cad


def bar(radius, angle, start, end):
    """A bar about a line through the origin, turned about y."""
    made = cq.Workplane(origin=(0, 0, start)).circle(radius).extrude(end - start)
    return made.rotate((0, 0, 0), (0, 1, 0), angle)


def arms(angles, radius):
    """A bar through the origin, and others that end there."""
    found = bar(radius, 0.0, -50.0, 50.0)
    for angle in angles:
        found = found.union(bar(radius, angle, 0.0, 50.0))
    return found


@pytest.mark.parametrize("bore", [0.0, 6.0])
@pytest.mark.parametrize("angles", [(90.0,), (50.0,), (60.0, 120.0), (90.0, 270.0)])
def test_two_halves_of_every_arm_are_swept(angles, bore):
    made = arms(angles, 9.0)
    part = load(made.cut(arms(angles, bore)) if bore else made)
    (cutter,) = at_mitres(part.solids[0])
    pieces = cut_cell(part, 0, cutter.tools)
    assert len(pieces.solids) == 2 * (len(angles) + 2)
    assert all(recognition.search_sweeps(cell, folds=False, most_readings=1).sweeps for cell in pieces.solids)
    assert sum(cell.volume for cell in pieces.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)


@pytest.mark.parametrize(
    "made",
    [
        arms((), 9.0).union(bar(8.0, 90.0, 0.0, 50.0)),  # unlike radii
        arms((90.0,), 9.0).cut(bar(6.0, 0.0, -50.0, 50.0)).cut(bar(5.0, 90.0, 0.0, 50.0)),  # their bores are unlike
        arms((), 9.0).union(bar(9.0, 90.0, 0.0, 50.0).translate((0, 4, 0))),  # axes pass each other
        cq.Workplane().box(60, 60, 60).cut(arms((90.0,), 9.0)),  # bores, no bars
    ],
)
def test_what_meets_in_no_plane_has_no_mitres(made):
    assert at_mitres(load(made).solids[0]) == []
