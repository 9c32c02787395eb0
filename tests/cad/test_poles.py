"""Domes whose arcs end on the axis but are not centred on it: STEP readers keep the rim of their faces alone."""

import cadquery as cq
import pytest

import cadsweep as cs
from cadsweep.cad.heal.validate import faults

pytestmark = pytest.mark.cad


def dome(*, middle, is_up=True, radius=30.0):
    """A solid dome: half an arc from the floor to the axis through (`middle`, `middle`), turned around it."""
    up = 1.0 if is_up else -1.0
    outline = cq.Workplane("XZ").moveTo(0, 0).lineTo(radius, 0)
    outline = outline.threePointArc((middle, up * middle), (0, up * radius)).close()
    return outline.revolve(360, (0, 0, 0), (0, 1, 0))


@pytest.mark.parametrize("middle", [21.0, 21.2, 21.22, 21.5])
@pytest.mark.parametrize("is_up", [True, False])
@pytest.mark.parametrize("is_hollow", [True, False])
def test_a_dome_is_read_with_its_pole(tmp_path, middle, is_up, is_hollow):
    part = dome(middle=middle, is_up=is_up)
    if is_hollow:
        part = cq.Workplane().circle(40).extrude(80, both=True).cut(part)
    cq.exporters.export(part, str(tmp_path / "dome.step"))
    found = cs.load(tmp_path / "dome.step")
    (solid,) = found.solids
    assert not faults(solid.kernel.shape)
    assert solid.volume * found.scale**3 == pytest.approx(part.val().Volume(), rel=1e-6)
    assert {face.key for face in solid.faces} == {f"face {j}" for j in range(len(part.faces().vals()))}


def test_a_shell_of_two_domes_is_meshed_from_a_file(tmp_path):
    part = dome(middle=21.2).cut(dome(middle=19.1, radius=27.0))
    cq.exporters.export(part, str(tmp_path / "shell.step"))
    found = cs.load(tmp_path / "shell.step")
    assert any(note.startswith("turned faces closed at their axis") for note in found.notes)
    mesh = cs.sweep_mesh(tmp_path / "shell.step", size=3.0)
    assert mesh.info["quality"].min_scaled_jacobian > 0.3
