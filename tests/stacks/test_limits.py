"""Where a mesh of columns ends below 0.3, the sharp outline or the steep cap that limits it is named."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.pipeline.columns.stacking import find_stacks
from cadsweep.stacks import is_round_across


def wedge_with_boss(angle: float) -> cq.Workplane:
    """A plate whose outline has a sharp corner at (0, 0), and a boss on it: no plain sweep."""
    plate = cq.Workplane().polyline([(0, 0), (10, 0), (10, 10 * np.tan(np.radians(angle)))]).close().extrude(2)
    return plate.union(cq.Workplane().rect(1, 0.8).extrude(3).translate((8.5, 0.8, 0)))


def sloped(lean: float, step: float) -> cq.Workplane:
    """A body whose flank leans a little from upright and ends at a wall or at a step's floor, with a blind hole."""
    run = 4 * np.tan(np.radians(lean))
    profile = [(0, 0), (6 + run + step, 0), (6 + run + step, 3), (6 + run, 3), (6, 7), (0, 7)]
    part = cq.Workplane("XZ").polyline(profile if step else profile[:2] + profile[3:]).close().extrude(6)
    return part.cut(cq.Workplane("XY", (0, 0, 5)).center(3, -3).circle(1).extrude(9))


def test_the_corner_of_a_sharp_outline_is_named():
    mesh = cs.sweep_mesh(wedge_with_boss(14.0), size=1.0, decompose=False)
    limit = mesh.info["sweeps"][0]["limit"]
    assert limit == pytest.approx(np.sin(np.radians(14.0)), abs=1e-3)
    assert mesh.quality().min_scaled_jacobian <= limit + 1e-3
    (note,) = (note for note in mesh.info["notes"] if "limits its columns" in note)
    assert "meet at 14 degrees at edge" in note
    assert "(line at 0, 0, 1)" in note
    blunt = cs.sweep_mesh(wedge_with_boss(40.0), size=1.0, decompose=False)
    assert blunt.info["sweeps"][0]["limit"] == pytest.approx(np.sin(np.radians(40.0)), abs=1e-3)
    assert not any("limits its columns" in note for note in blunt.info["notes"])


def test_a_steep_cap_that_ends_at_a_wall_is_named():
    mesh = cs.sweep_mesh(sloped(10.0, 0.0), size=1.0, decompose=False)
    limit = mesh.info["sweeps"][0]["limit"]
    assert limit == pytest.approx(np.sin(np.radians(10.0)), abs=1e-3)
    assert mesh.quality().min_scaled_jacobian <= limit + 1e-3
    (note,) = (note for note in mesh.info["notes"] if "limits its columns" in note)
    assert "meet at 170 degrees at edge" in note


def test_a_steep_cap_is_named_while_columns_are_upright():
    part = cs.load(sloped(10.0, 4.0))
    mesh = cs.sweep_mesh(part, size=1.0, decompose=False, smoothing=False)
    assert mesh.info["sweeps"][0]["limit"] == 1.0
    assert mesh.quality().min_scaled_jacobian <= np.sin(np.radians(10.0)) + 1e-3
    (note,) = (note for note in mesh.info["notes"] if "limits its columns" in note)
    (steep,) = (f for f in part.solids[0].faces if 0.1 < abs(f.normal[2]) < 0.9)
    assert f"{steep.label()} leans 10 degrees" in note
    assert note.endswith("while columns are upright")


def keyed_shaft():
    shaft = cq.Workplane("YZ").circle(10).extrude(60)
    return shaft.cut(cq.Workplane("XY", (30, 0, 6)).slot2D(25, 6).extrude(10))


def rounded_boss():
    return cq.Workplane().box(20, 20, 4).union(cq.Workplane().rect(8, 8).extrude(6).faces(">Z").edges().fillet(1.5))


@pytest.mark.parametrize(("make", "across"), [(keyed_shaft, True), (rounded_boss, False)])
def test_what_is_round_across_columns_is_told_from_a_rounding(make, across):
    """A slot's end is tangent to walls on both sides, a rounding of an edge to a wall and a cap."""
    stack = find_stacks(cs.load(make()))[0]
    assert stack.rounded
    assert is_round_across(stack) == across


def test_a_shaft_with_a_round_ended_keyway_is_cut_where_columns_are_fair_alone():
    """Its columns run along it and lean at the ends of the keyway; at the default size 0.40, where cells give 0.64."""
    mesh, columns = (cs.sweep_mesh(keyed_shaft(), size=3.0, decompose=decompose) for decompose in (True, False))
    assert columns.info["sweeps"][0]["columns"] == 3
    assert len(mesh.info["sweeps"]) > 1
    assert mesh.quality().min_scaled_jacobian >= columns.quality().min_scaled_jacobian
