"""Planes through all of a block whose bores cross beside other features: they harm none, and all cells agree."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import load
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.grids import on_grid
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad

FLAT = 1e-4


def bored(*, blind=True, offset=0.0):
    """A block with a bore along y that a counterbored one along z crosses, its floor just outside."""
    block = cq.Workplane().box(50, 46, 40)
    block = block.cut(cq.Workplane("XZ").center(-12 + offset, 5).circle(8).extrude(23, both=True))
    block = block.cut(cq.Workplane("XY", origin=(-12, 6, 0)).circle(4).extrude(20, both=True))
    block = block.cut(cq.Workplane("XY", origin=(-12, 6, -20)).circle(7).extrude(11))
    return block.cut(cq.Workplane("XZ", origin=(12, -23, -6)).circle(5).extrude(-17)) if blind else block


def crossed():
    """Two bores that cross, and nothing else."""
    block = cq.Workplane().box(40, 40, 40)
    block = block.cut(cq.Workplane("XZ").circle(8).extrude(20, both=True))
    return block.cut(cq.Workplane("XY").circle(4).extrude(20, both=True))


@pytest.fixture(scope="module")
def parted():
    part = load(bored())
    (cutter,) = on_grid(part.solids[0], FLAT)
    return part, cut_cell(part, 0, cutter.tools)


def test_all_cells_can_be_filled_and_agree(parted):
    _, cells = parted
    fills = [recognise(cell) for cell in cells.solids]
    assert all(fills)
    make_plan(cells, fills)


def test_nothing_is_lost_and_all_of_the_surface_is_in_the_cells(parted):
    part, cells = parted
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-9)
    known = sum(face.area for cell in cells.solids for face in cell.faces if face.known >= 0)
    assert known == pytest.approx(sum(face.area for face in part.solids[0].faces), rel=1e-6)


def test_the_circle_of_a_counterbore_goes_no_further_than_its_cone(parted):
    part, cells = parted
    radii = {
        round(float(np.ptp(edge.curve.evaluate(np.linspace(0, 1, 9)), axis=0).max() * part.scale), 3): edge
        for cell in cells.solids
        for edge in cell.edges
        if edge.kind == "circle" and abs(edge.midpoint[2] * part.scale - 20.0) < 1e-6
    }
    # On the far side of the block is the bore alone: quarters of its circle.
    assert set(radii) == {4.0}


@pytest.mark.parametrize(("offset", "places"), [(0.0, {-12.0}), (-2.0, {-12.0, -14.0})])
def test_axes_that_pass_each_other_get_a_plane_each(offset, places):
    part = load(bored(offset=offset))
    (cutter,) = on_grid(part.solids[0], FLAT)
    cells = cut_cell(part, 0, cutter.tools)
    corners = np.concatenate([cell.vertices for cell in cells.solids]) * part.scale
    on_side = corners[np.abs(corners[:, 2] - 20.0) < 1e-6]
    # On the side that both bores leave alone but for one circle, planes through the axes end in corners.
    assert places <= set(np.round(on_side[:, 0], 6))


def test_one_crossing_alone_is_left_to_fewer_cuts():
    assert on_grid(load(crossed()).solids[0], FLAT) == []


def bossed():
    """A boss with a blind bore that ends next to a bore across it, which another one crosses."""
    block = cq.Workplane().box(60, 75, 40).union(cq.Workplane("YZ", origin=(-41, -17, 4)).circle(10).extrude(11))
    block = block.cut(cq.Workplane("YZ", origin=(-41, -17, 4)).circle(3).extrude(41))
    block = block.cut(cq.Workplane("XZ").center(9, -4).circle(5).extrude(38, both=True))
    return block.cut(cq.Workplane("YZ").center(22, -10).circle(3).extrude(30, both=True))


def test_between_a_cone_and_the_cushion_below_it_the_sides_of_the_cushion_end():
    part = load(bossed())
    (cutter,) = on_grid(part.solids[0], FLAT)
    cells = cut_cell(part, 0, cutter.tools)
    # What goes through the face of the boss goes through its axis.
    ends = {
        tuple(np.round(cell.vertices[v] * part.scale, 6))
        for cell in cells.solids
        for v in range(len(cell.vertices))
        if abs(cell.vertices[v][0] * part.scale + 41.0) < 1e-6
    }
    assert {round(float(np.hypot(y + 17.0, z - 4.0)), 6) for _, y, z in ends} == {3.0, 10.0}
