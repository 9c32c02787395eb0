"""Boxes around features that pass each other: outside of them all cells are bricks, and all agree."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import decompose, load
from cadsweep.cad.edit.boxes import around_features

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
