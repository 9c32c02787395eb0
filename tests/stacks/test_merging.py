"""Outlines that nearly coincide in plan: laid together in the mesh of the plane, each in its place in the part."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.pipeline.columns.stack_merging import merged_stack
from cadsweep.pipeline.columns.stacking import find_stacks


def two_pockets(gap: float, *, same_side: bool = False) -> cq.Workplane:
    """A block with two pockets whose walls are `gap` apart in plan: from above and from below, or both from above."""
    part = cq.Workplane().box(12, 8, 6)
    first = cq.Workplane().box(4, 4, 2).translate((-2, 0, 2))
    second = cq.Workplane().box(4, 4, 2).translate((2 + gap, 0, 2 if same_side else -2))
    return part.cut(first).cut(second)


def stack_along_z(part: cq.Workplane):
    return next(stack for stack in find_stacks(cs.load(part)) if abs(stack.direction[2]) > 0.9)


def test_walls_at_different_heights_are_one_line_of_the_plane():
    stack = stack_along_z(two_pockets(-0.05))
    merged = merged_stack(stack, 1.0)
    assert len(stack.columns) == 4  # two pockets, the strip in both, what is around
    assert len(merged.columns) == 3
    assert {f for own in merged.arrangement.caps for f in own} == {f for own in stack.arrangement.caps for f in own}


@pytest.mark.parametrize("gap", [0.05, -0.05])
def test_the_mesh_is_the_part_to_the_digit(gap):
    part = two_pockets(gap)
    mesh = cs.sweep_mesh(part, size=1.0)
    report = mesh.quality()
    assert report.valid, report.problems
    assert report.volume == pytest.approx(part.val().Volume(), rel=1e-12)
    assert sum(report.areas.values()) == pytest.approx(part.val().Area(), rel=1e-12)
    assert report.min_scaled_jacobian > 0.7
    # No hexahedron as thin as the strip: there is none between the lines.
    edges = np.linalg.norm(mesh.points[mesh.hexes[:, [0, 1, 2, 3]]] - mesh.points[mesh.hexes[:, [1, 2, 3, 0]]], axis=2)
    assert edges.min() > 0.3


def test_a_thin_wall_of_the_part_stays():
    part = two_pockets(0.1, same_side=True)
    stack = stack_along_z(part)
    assert len(merged_stack(stack, 1.0).columns) == len(stack.columns)
    mesh = cs.sweep_mesh(part, size=1.0, decompose=False)
    report = mesh.quality()
    assert report.valid, report.problems
    assert report.volume == pytest.approx(part.val().Volume(), rel=1e-12)


def test_a_corner_beside_an_arc_of_another_height_is_brought_to_it():
    block = cq.Workplane().box(12, 12, 6)
    drum = cq.Workplane().circle(3).extrude(2).translate((0, 0, 1))
    corner = cq.Workplane().box(5, 5, 2).translate((3 / np.sqrt(2) - 2.5 + 0.01, 3 / np.sqrt(2) - 2.5 + 0.01, -2))
    part = block.cut(drum).cut(corner)
    stack = stack_along_z(part)
    merged = merged_stack(stack, 1.0)
    lengths = [min(s.arrangement.prism.edges[e].length for e in s.arrangement.over) for s in (stack, merged)]
    assert lengths[0] < 0.1 < lengths[1]
    report = cs.sweep_mesh(part, size=1.0, decompose=False).quality()
    assert report.valid, report.problems
    assert report.min_scaled_jacobian > 0.3


def test_lines_that_cross_at_a_sharp_angle_are_opened_where_only_one_is_real():
    """Two slots at 12 degrees, one above the other: in plan the quads are sharp, in the part they need not be."""
    part = cq.Workplane().box(20, 20, 6)
    part = part.cut(cq.Workplane().box(14, 4, 2).translate((0, 0, 2)))
    part = part.cut(cq.Workplane().box(14, 4, 2).rotate((0, 0, 0), (0, 0, 1), 12).translate((0.3, 0.4, -2)))
    report = cs.sweep_mesh(part, size=1.5, decompose=False).quality()
    assert report.valid, report.problems
    assert report.min_scaled_jacobian > np.sin(np.radians(12)) + 0.05
    assert report.volume == pytest.approx(part.val().Volume(), rel=1e-9)
