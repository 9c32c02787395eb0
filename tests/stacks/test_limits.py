"""Where a mesh of columns ends below 0.3, the sharp outline or the steep cap that limits it is named."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs


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
