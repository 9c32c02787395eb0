"""Bores that just touch the line at which another one's wall is divided."""

import cadquery as cq
import pytest

from cadsweep.cad.heal.validate import faults
from cadsweep.pipeline import load


def _touched(*, seam: float) -> cq.Workplane:
    """A block with a bore of radius 3 along x, and one of radius 2 across it: its wall ends half way up.

    The crossing bore goes from the axis of the first to beyond its top, so its loops run along the two lines at the
    height of the axis and touch them. The seam is at an angle, in degrees, from one of them.
    """
    frame = cq.Plane(origin=(-20, 0, 0), xDir=(0, 1, 0), normal=(1, 0, 0)).rotated((0, 0, seam))
    along = cq.Workplane(frame).circle(3).extrude(40)
    across = cq.Workplane("XZ", origin=(0, 20, 2)).circle(2).extrude(40)
    return cq.Workplane().box(40, 40, 20).cut(along).cut(across)


@pytest.mark.parametrize("seam", [0.0, 180.0, 90.0])
def test_a_bore_is_divided_where_no_loop_touches(seam: float) -> None:
    part = _touched(seam=seam)
    found = load(part)
    (solid,) = found.solids
    assert not faults(solid.kernel.shape)
    assert solid.volume == pytest.approx(part.val().Volume(), rel=1e-6)
    assert not any(note.startswith("repaired") for note in found.notes)
    assert any("at another angle" in note for note in found.notes) == (seam != 90.0)
    # every face of the model is there, under its own number
    assert {face.key for face in solid.faces} == {f"face {j}" for j in range(len(part.faces().vals()))}


@pytest.mark.parametrize("angle", [0.0, 180.0])
def test_a_hole_that_just_touches_a_shaft_is_divided_beside_the_point(tmp_path, angle: float) -> None:
    """In a file, its rim has a vertex there and the seam's opposite to it; its other rim has the seam's alone."""
    shaft = cq.Workplane().circle(24).extrude(8).union(cq.Workplane().circle(14).extrude(20))
    hole = cq.Workplane(cq.Solid.makeCylinder(3, 40, cq.Vector(17, 0, -10))).rotate((0, 0, 0), (0, 0, 1), angle)
    part = shaft.cut(hole)
    cq.exporters.export(part, str(tmp_path / "part.step"))
    found = load(tmp_path / "part.step")
    (solid,) = found.solids
    assert not faults(solid.kernel.shape)
    assert solid.volume * found.scale**3 == pytest.approx(part.val().Volume(), rel=1e-6)
    assert {face.key for face in solid.faces} == {f"face {j}" for j in range(len(part.faces().vals()))}
