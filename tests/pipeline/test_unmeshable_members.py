"""A member of an assembly that cannot be meshed with the others, or not at all, does not take them with it."""

import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep import NotSweepableError

from .test_assemblies import assembly, block, rod_on_pipe

pytestmark = pytest.mark.cad


def test_a_contact_that_no_mesh_can_follow_is_left_separate_and_said():
    mesh = cs.sweep_mesh(rod_on_pipe(), size=0.8, decompose=False)
    assert set(mesh.parts) == {"bar", "rod"}
    assert not mesh.interfaces
    assert {"bar__rod_1", "bar__rod_2"} <= set(mesh.boundaries)
    assert any("shares no nodes" in note for note in mesh.info["notes"])


def test_only_the_member_at_fault_shares_no_nodes():
    """A plate on the far end of the rod keeps its contact with it."""
    bar = cq.Workplane("YZ").circle(3).extrude(20)
    rod = cq.Workplane().circle(1.5).extrude(8).translate((10, 0, 0)).cut(bar)
    mesh = cs.sweep_mesh(assembly(bar=bar, rod=rod, top=block(6, 6, 1, (10, 0, 8))), size=0.8, decompose=False)
    assert set(mesh.parts) == {"bar", "rod", "top"}
    assert "rod__top" in mesh.interfaces
    assert "bar__rod_1" in mesh.boundaries


def test_a_member_without_a_mesh_is_named_and_left_out_on_request():
    whole = assembly(low=block(8, 8, 1, (0, 0, 4)), ball=_lens())
    with pytest.raises(NotSweepableError) as refused:
        cs.sweep_mesh(whole, size=1.0, decompose=False)
    assert refused.value.solids == ("ball",)
    mesh = cs.sweep_mesh(whole, size=1.0, decompose=False, skip_unmeshable=True)
    assert set(mesh.parts) == {"low"}
    assert any("'ball' is left out" in note for note in mesh.info["notes"])


def test_a_model_of_nothing_else_is_refused_all_the_same():
    with pytest.raises(NotSweepableError):
        cs.sweep_mesh(assembly(ball=_lens(), other=_lens((20, 0, 0))), size=1.0, decompose=False, skip_unmeshable=True)


def _lens(place=(0, 0, 0)):
    """Two balls' common part: its rim is sharp, and no face of it is a cap."""
    return cq.Workplane().sphere(3).intersect(cq.Workplane().sphere(3).translate((0, 0, 3))).translate(place)
