"""Features that go different ways are parted by planes into boxes, each of which one direction suits."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import load
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.regions import into_boxes

pytestmark = pytest.mark.cad

FLAT = 1e-4


def drilled(*directions):
    """A long block with a hole in each direction, one beside the other."""
    part = cq.Workplane().box(20.0 * len(directions), 20, 20)
    for j, direction in enumerate(directions):
        place = (20.0 * j - 10.0 * len(directions) + 10.0, 0, 0)
        plane = cq.Plane(place, (1, 0, 0), direction)
        part = part.cut(cq.Workplane(plane).circle(4).extrude(20, both=True))
    return load(part)


def axes_of(solid):
    """Directions of the holes of a solid, by the extent of its cylinders' edges."""
    found = set()
    for face in solid.faces:
        if face.kind == "cylinder":
            ends = [solid.edges[e] for e in face.edges if solid.edges[e].kind == "line"]
            found.add(int(np.abs(ends[0].tangents[0]).argmax()))
    return found


def test_nothing_is_parted_where_one_direction_suits_all():
    (solid,) = drilled((0, 0, 1), (0, 0, 1), (0, 0, 1)).solids
    assert into_boxes(solid, FLAT)[0] == []


@pytest.mark.parametrize("ways", [[(0, 0, 1), (0, 1, 0)], [(0, 0, 1), (0, 1, 0), (0, 0, 1)]])
def test_every_box_has_holes_of_one_direction(ways):
    part = drilled(*ways)
    (cutter,), _ = into_boxes(part.solids[0], FLAT)
    pieces = cut_cell(part, 0, cutter.tools)
    # Holes that change direction n times along the block need n planes between them.
    assert len(pieces.solids) == len(ways)
    assert all(len(axes_of(solid)) == 1 for solid in pieces.solids)
    assert sum(solid.volume for solid in pieces.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)


def test_planes_go_through_what_is_swept_square_to_them():
    """A hole along the whole block is left as it is, what goes across it above is parted from it."""
    block = cq.Workplane().box(40, 20, 40).faces(">X").workplane(centerOption="CenterOfMass").center(0, -10)
    block = block.hole(8).faces(">Y").workplane(centerOption="CenterOfMass").center(0, 10).hole(8)
    part = load(block)
    (cutter,), _ = into_boxes(part.solids[0], FLAT)
    assert len(cutter.tools) == 1
    pieces = cut_cell(part, 0, cutter.tools)
    assert sorted(axes_of(solid) for solid in pieces.solids) == [{0}, {1}]
