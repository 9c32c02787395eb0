"""Plane faces of many holes: what is found sound in short time is what OpenCASCADE finds sound."""

import cadquery as cq
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepCheck import BRepCheck_Analyzer

from cadsweep.cad.heal.crowded import MANY, is_valid_apart
from cadsweep.cad.heal.validate import faults


def sheet(*more: tuple[float, float, float], turned: bool = True, n: int = MANY):
    """A square sheet with n round holes, and holes (x, y, radius) besides."""
    maker = BRepBuilderAPI_MakeFace(cq.Wire.makePolygon([(0, 0), (40, 0), (40, 40), (0, 40)], close=True).wrapped)
    for x, y, radius in [*((4.0 + 4 * (k % 8), 4.0 + 4 * (k // 8), 1.0) for k in range(n)), *more]:
        normal = cq.Vector(0, 0, -1 if turned else 1)
        maker.Add(cq.Wire.makeCircle(radius, cq.Vector(x, y, 0), normal).wrapped)
    return maker.Face()


def test_many_holes_apart_are_sound():
    assert is_valid_apart(sheet())
    assert BRepCheck_Analyzer(sheet()).IsValid()
    assert faults(sheet()) == []


def test_a_solid_of_many_holes_is_sound_and_so_is_its_mirror():
    points = [(4.0 * (k % 8), 4.0 * (k // 8)) for k in range(MANY)]
    plate = cq.Workplane().rect(80, 80).extrude(2).cut(cq.Workplane().pushPoints(points).circle(1).extrude(2))
    for solid in (plate, plate.mirror("XY"), plate.rotate((0, 0, 0), (1, 2, 3), 40)):
        assert is_valid_apart(solid.val().wrapped)


@pytest.mark.parametrize(
    "more",
    [
        (5.5, 4.0, 1.0),  # crosses its neighbour
        (4.0, 4.0, 0.5),  # lies in another
        (40.0, 20.0, 1.0),  # crosses the rim
        (60.0, 20.0, 1.0),  # lies outside
    ],
)
def test_a_hole_out_of_place_is_left_to_opencascade(more):
    face = sheet(more)
    assert not is_valid_apart(face)
    assert not BRepCheck_Analyzer(face).IsValid()
    assert faults(face)


def test_nothing_is_said_of_few_holes_and_of_holes_turned_over():
    assert not is_valid_apart(sheet(n=4))
    assert not is_valid_apart(sheet(turned=False))
