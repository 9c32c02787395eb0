"""What a refusal says of a stack: the part's own faces and edges, by name or id and place, and what to try."""

import re

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import CadSweepError, InputError, SurfaceMeshError
from cadsweep.pipeline.columns import stacking
from cadsweep.pipeline.columns.stacking import describe_stacks, find_stacks


@pytest.fixture(scope="module")
def part():
    """A block with a named pocket, a blind hole from below it, and a boss."""
    shape = cq.Workplane().box(40, 30, 10, centered=(True, True, False))
    shape = shape.cut(cq.Workplane("XY", (-10, 0, 6)).rect(10, 12).extrude(10))
    shape = shape.cut(cq.Workplane("XY", (-10, 0, 0)).circle(2).extrude(3))
    shape = shape.union(cq.Workplane("XY", (5, 5, 10)).rect(6, 6).extrude(3))
    shape.faces(cq.selectors.NearestToPointSelector((-10, 0, 6))).tag("floor")
    return cs.load(shape)


def edge_near(part, place):
    return min(part.solids[0].edges, key=lambda edge: float(np.linalg.norm(edge.midpoint - np.array(place)))).id


def test_edges_and_faces_of_the_plane_are_named_by_the_parts(part):
    stack = find_stacks(part)[0]
    solid, prism, arrangement = part.solids[0], stack.arrangement.prism, stack.arrangement
    for e, over in arrangement.over.items():
        own = {solid.edges[one].label() for one in over}
        assert {edge.label() for edge in prism.edges[e].stands_for} == own
        assert prism.edges[e].label().split(" under ")[0] in own
        assert prism.edges[arrangement.top_edges[e]].label() == prism.edges[e].label()
    for f, caps in zip(arrangement.bottoms, arrangement.caps, strict=True):
        heights = [float(face.center @ stack.direction) for face in prism.faces[f].stands_for]
        assert {face.id for face in prism.faces[f].stands_for} == caps
        assert heights == sorted(heights)
    for side in stack.plan.linking_sides:
        assert {face.id for face in prism.faces[side.face].stands_for} <= set(stack.walls)


def test_too_few_layers_name_the_caps_over_each_other(part):
    with pytest.raises(
        InputError, match=r"(?s)layers = 3 cannot be had:.*'floor'.* lie over each other.*take 4 or more"
    ):
        cs.sweep_mesh(part, layers=3)


def test_layers_that_contradict_each_other_are_named_and_no_others(part):
    beside, whole = (edge_near(part, place) for place in ((-15, 6, 8), (20, 15, 5)))
    with pytest.raises(
        InputError, match=r"(?s)^4 layers from face \d+ 'floor'.* contradict each other: change or drop"
    ) as no:
        cs.sweep_mesh(part, counts={f"edge {beside}": 4, f"edge {whole}": 5, "edge 0": 5}, layers=30)
    assert "layers = 30" not in str(no.value)


def test_no_room_in_the_plane_is_told_of_the_caps_there(part):
    wall = next(f.id for f in part.solids[0].faces if f.center[0] == -20.0)
    with pytest.raises(
        SurfaceMeshError, match=r"(?s)^face \d+ \(plane at .*, 0\) under face \d+ .*ask for fewer or thinner"
    ):
        cs.sweep_mesh(part, wall_layers={f"face {wall}": cs.WallLayers(first=0.5, growth=1.2, n=30)}, decompose=False)


def test_levels_are_those_of_flat_caps_and_directions_are_without_noise():
    """A chamfer is of one sheet with the face that it ends at; a part that is turned has rounding in its direction."""
    shape = cq.Workplane().box(20, 12, 4, centered=(True, True, False)).faces("<Z").chamfer(0.8)
    shape = shape.union(cq.Workplane("XY", (0, 0, 4)).rect(6, 4).extrude(3))
    for turned, axis in ((shape, (0, 0, 1)), (shape.rotate((0, 0, 0), (0, 1, 0), 90), (1, 0, 0))):
        (row,) = (row for row in describe_stacks(cs.load(turned), ())[0] if len(row["levels"]) == 3)
        assert row["direction"].tolist() == list(axis)
        assert row["levels"] == pytest.approx([0, 4, 7], abs=1e-9)


def test_a_part_that_no_cuts_help_says_why_it_is_no_stack():
    """A dimple in each of three sides: whatever the direction, one of them turns towards it and away."""
    shape = cq.Workplane().box(20, 20, 20)
    for place in ((10, 3, 2), (2, 10, 3), (3, 2, 10)):
        shape = shape.cut(cq.Workplane().sphere(4).translate(place))
    with pytest.raises(cs.NotSweepableError) as refused:
        cs.sweep_mesh(shape, decompose_time=0.2, fitted=False)
    assert re.match(r"the solid cannot be meshed: no sweep, no columns and no cuts fit it", str(refused.value))
    said = r"no stack of columns along \(.*\), face \d+ .* turns from facing along it"
    assert any(re.match(said, reason) for reason in refused.value.reasons)


def test_columns_that_nobody_asked_to_be_so_many_are_refused_and_those_of_a_size_are_not(monkeypatch):
    block = cq.Workplane().box(20, 16, 4).union(cq.Workplane(origin=(3, 2, 2)).box(8, 6, 6))
    monkeypatch.setattr(stacking, "MOST_UNASKED", 20)
    with pytest.raises(CadSweepError, match="would be about"):
        cs.sweep_mesh(block, decompose=False)
    assert cs.sweep_mesh(block, decompose=False, size=2.0).n_hexes > 20
