"""Pieces put in a cell's place are what a general fuse of all cells makes of them, and share what the cell shared."""

import numpy as np
import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import load
from cadsweep.cad.edit.central import plane_tool
from cadsweep.cad.edit.cutting import contact_area, split_cell
from cadsweep.decomposition.curved import CellSearch
from cadsweep.pipeline.complexes.complexes import cutting_tools
from cadsweep.pipeline.run import Run, silent

pytestmark = pytest.mark.cad


X_IS_14 = ((1.0, 0.0, 0.0), (14.0, 0.0, 0.0))
Z_IS_6 = ((0.0, 0.0, 1.0), (0.0, 0.0, 6.0))


@pytest.fixture(scope="module")
def drilled():
    """A block with a slanted bore between two cross bores."""
    slanted = cq.Workplane(cq.Plane((0, 0, 0), (0, 1, 0), (0.5, 0, 1))).circle(5).extrude(30, both=True)
    across = cq.Workplane("XZ", origin=(0, 30, 0)).pushPoints([(-22, 0), (22, 0)]).circle(3).extrude(60)
    return load(cq.Workplane().box(60, 30, 16).cut(slanted).cut(across))


def distinct(part, what):
    return len(np.unique(np.concatenate([getattr(solid, what) for solid in part.solids])))


def test_both_ways_share_the_same(drilled):
    """A second cut goes through a face that the first one made, so that a neighbour is divided with the piece."""
    upright, level = (plane_tool(drilled.solids[0], np.array(n), np.array(at)) for n, at in (X_IS_14, Z_IS_6))
    first = split_cell(drilled, 0, [upright]).imprinted()
    one = split_cell(first, 0, [level])
    grafted, fused = one.imprinted(), one.fused()
    for what in ("face_keys", "edge_keys", "vertex_keys"):
        assert distinct(grafted, what) == distinct(fused, what)
    for a, b in zip(grafted.solids, fused.solids, strict=True):
        assert (len(a.faces), len(a.edges)) == (len(b.faces), len(b.edges))
        assert a.volume == pytest.approx(b.volume, rel=1e-9)
        assert [face.key for face in a.faces if face.key] != []


def test_sweeps_are_those_of_the_cells_as_they_are_now(drilled):
    """A cell that a cut leaves as it was is recognised once; its keys are those of the part of today."""
    found = next(CellSearch(drilled, cutting_tools(Run(on_progress=silent))).solutions())
    assert len(found.part.solids) == 3
    for way, solid in zip(found.plan.ways, found.part.solids, strict=True):
        assert way.fill.solid is solid


def shaft_in_hub(turned):
    """A shaft in a hub, the seam of its side turned by degrees; loaded as one part."""
    shaft = cq.Workplane().circle(6).extrude(40).rotate((0, 0, 0), (0, 0, 1), turned)
    hub = cq.Workplane().circle(15).circle(6).extrude(20).translate((0, 0, 10))
    return load(cq.Assembly().add(shaft, name="shaft").add(hub, name="hub"))


@pytest.mark.parametrize("turned", [0, 30, 90])
@pytest.mark.parametrize("both", [False, True])
def test_a_cut_takes_no_seam_away_from_a_contact_area(turned, both):
    """The halves of a side are one face of each piece, or two, but the same ones for the solid that they touch."""
    part = shaft_in_hub(turned)
    before = contact_area(part)
    tool = plane_tool(part.solids[1], np.array((1.0, 0.0, 0.0)), np.array((0.0, 0.0, 20.0) - part.offset) / part.scale)
    cut = split_cell(part, 0, [tool], [1] if both else []).imprinted()
    assert len(cut.solids) == (4 if both else 3)
    assert contact_area(cut) == pytest.approx(before, rel=1e-9)


def test_cells_parted_together_share_what_they_would_one_by_one(drilled):
    """Two cells side by side are cut by one plane: they share the pieces of the face between them."""
    upright, level = (plane_tool(drilled.solids[0], np.array(n), np.array(at)) for n, at in (X_IS_14, Z_IS_6))
    first = split_cell(drilled, 0, [upright]).imprinted()
    together = split_cell(first, 0, [level], [1]).imprinted()
    one = split_cell(first, 1, [level]).imprinted()
    after = split_cell(one, 0, [level]).imprinted()
    assert len(together.solids) == len(after.solids) == 4
    for what in ("face_keys", "edge_keys", "vertex_keys"):
        assert distinct(together, what) == distinct(after, what)
