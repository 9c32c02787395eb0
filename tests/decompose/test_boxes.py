"""Boxes around features that pass each other: outside of them all cells are bricks, and all agree."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import decompose, load
from cadsweep.cad.edit.boxes import around_features
from cadsweep.cad.edit.circles import find_outlines
from cadsweep.cad.edit.cushions import cushion
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.errors import NotSweepableError
from cadsweep.options import SweepOptions
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.pipeline.complexes.decomposing import is_planar, mesh_decomposed
from cadsweep.pipeline.run import Run, silent
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad

FLAT = 1e-4
BLOCK = (50.0, 40.0, 30.0)


def drilled():
    """A block with a hole along x, and a blind hole from above that ends over it: no plane parts them alone."""
    block = cq.Workplane().box(*BLOCK)
    block = block.cut(cq.Workplane("YZ").center(0, -6).circle(5).extrude(30, both=True))
    return block.cut(cq.Workplane(origin=(0, 0, 15)).circle(6).extrude(-11))


@pytest.fixture(scope="module")
def cells():
    return decompose(load(drilled()))


def test_all_cells_agree_after_one_set_of_cuts(cells):
    assert [(cut.kind, cut.place) for cut in cells.cuts] == [("boxes", (0.0, 0.0, 0.0))]
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(drilled().val().Volume(), rel=1e-6)


def test_cells_beside_the_boxes_are_bricks(cells):
    bricks = 0
    for cell in cells.solids:
        normals = np.array([face.normal for face in cell.faces if face.kind == "plane"])
        if len(normals) < len(cell.faces) or np.abs(normals).max(axis=1).min() < 1.0 - 1e-9:
            continue  # in the box of a feature, or of the cells under its circle
        bricks += 1
        box = np.ptp(cell.vertices, axis=0)
        assert cell.volume == pytest.approx(float(np.prod(box)), rel=1e-9)
    assert bricks


def test_one_direction_for_all_needs_no_boxes():
    block = cq.Workplane().box(*BLOCK).faces(">Z").workplane().pushPoints([(-10, 0), (10, 0)]).hole(8)
    assert around_features(load(block).solids[0], FLAT) == []


OUTLINES = {
    "triangle": lambda sketch: sketch.polygon(3, 14),
    "slot": lambda sketch: sketch.slot2D(18, 6),
}


@pytest.mark.parametrize("name", OUTLINES)
def test_an_outline_of_any_convex_shape_ends_in_a_cushion(name):
    block = OUTLINES[name](cq.Workplane().box(24, 20, 16).faces(">Z").workplane()).cutBlind(-5)
    part = load(block)
    (rim,) = find_outlines(part.solids[0], FLAT)
    across = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    widths = np.array([[-12.0, 12.0], [-10.0, 10.0]]) / part.scale - (across @ rim.center)[:, None]
    cells = cut_cell(part, 0, cushion(rim, across, widths, 6.0 / part.scale))
    assert cells is not None
    # What is above the floor and below the box, the core, and five cells each between it, the bowl, and the sides.
    assert len(cells.solids) == 13
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)
    ways = [recognise(cell) for cell in cells.solids]
    assert all(ways)
    assert make_plan(cells, ways)
    # The sides of the box know nothing of the outline.
    for face in (face for cell in cells.solids for face in cell.faces):
        if abs(face.normal[2]) < 1e-9 and face.known >= 0 and abs(face.center[:2] * part.scale).max() > 9.0:
            assert len(face.loops[0].edges) == 4


def test_planes_that_part_nothing_are_followed_by_boxes():
    block = cq.Workplane().box(30, 24, 24).faces(">Z").workplane().polygon(6, 12).cutBlind(-6)
    part = load(block.cut(cq.Workplane("YZ").center(0, -6).polygon(3, 8).extrude(15, both=True)))
    assert is_planar(part)
    few = 0.01  # of the budget of a search by planes, which finds nothing then
    mesh = mesh_decomposed(
        part, SweepOptions(size=5.0), Run(on_progress=silent), NotSweepableError("no sweep"), share=few
    )
    assert mesh.info["quality"].valid
    assert any("boxes around 2 features" in note for note in mesh.info["notes"])


def test_no_side_of_a_box_lies_on_a_wall_that_goes_on_into_a_rounding():
    pocket = cq.Workplane().box(24, 6, 10).edges("|X").fillet(2.5).translate((-25, -13, 4))
    block = drilled().cut(pocket)
    part = load(block)
    (boxes,) = around_features(part.solids[0], FLAT)
    cells = cut_cell(part, 0, boxes.tools)
    assert cells is not None
    # Between a wall and the arc that it goes on into there would be a cell with no angle at its end.
    assert min(edge.dihedral for cell in cells.solids for edge in cell.edges) > np.radians(15)
