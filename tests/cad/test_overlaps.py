"""Where solids overlap, the smaller keeps its shape and the larger is cut, if that is asked for."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import CadError


def pin_in_plate(*, first="plate"):
    """A plate of 12 x 10 x 2 with a pin of radius 1.5 through it that stands out at both sides."""
    plate = cq.Workplane().box(12, 10, 2)
    pin = cq.Workplane().circle(1.5).extrude(3, both=True)
    parts = {"plate": plate, "pin": pin}
    assembly = cq.Assembly()
    for name in (first, *(name for name in parts if name != first)):
        assembly.add(parts[name], name=name)
    return assembly


def volumes(part):
    return {model.name: model.volume * part.scale**3 for model in part.models}


PIN, HOLE = np.pi * 1.5**2 * 6, np.pi * 1.5**2 * 2


@pytest.mark.parametrize("first", ["plate", "pin"])
def test_the_smaller_keeps_its_shape_whatever_comes_first(first):
    part = cs.load(pin_in_plate(first=first), cut_overlaps=True)
    assert volumes(part) == pytest.approx({"pin": PIN, "plate": 240 - HOLE})
    assert sum(note.startswith("'pin' cut out of 'plate'") for note in part.notes) == 1


def test_they_share_the_faces_that_they_touch_in():
    mesh = cs.sweep_mesh(pin_in_plate(), cut_overlaps=True)
    quality = mesh.info["quality"]
    assert quality.valid
    assert len(mesh.interfaces) == 1
    assert quality.volume == pytest.approx(240 - HOLE + PIN, rel=5e-3)


def test_a_solid_wholly_inside_another_leaves_a_hollow_that_it_fills():
    core = cq.Workplane().box(2, 2, 2)
    block = cq.Workplane().box(6, 6, 6)
    part = cs.load(cq.Assembly().add(core, name="core").add(block, name="block"), cut_overlaps=True)
    assert volumes(part) == pytest.approx({"core": 8, "block": 216 - 8})


def test_names_and_colours_of_faces_outlive_the_cut():
    plate = cq.Workplane().box(12, 10, 2)
    assembly = cq.Assembly().add(plate, name="plate", color=cq.Color("red"))
    assembly.add(cq.Workplane().circle(1.5).extrude(3, both=True), name="pin")
    part = cs.load(assembly, cut_overlaps=True)
    cell = next(solid for solid in part.solids if solid.name == "plate")
    assert cell.color == "#ff0000"
    assert {face.key for face in cell.faces if face.kind == "plane"} == {f"face {j}" for j in range(6)}


def test_solids_that_only_touch_are_not_cut():
    plate = cq.Workplane().box(12, 10, 2)
    boss = cq.Workplane().workplane(offset=1).circle(2).extrude(3)
    assembly = cq.Assembly().add(plate, name="plate").add(boss, name="boss")
    part, as_ever = cs.load(assembly, cut_overlaps=True), cs.load(assembly)
    assert [len(solid.faces) for solid in part.solids] == [len(solid.faces) for solid in as_ever.solids]
    assert not [note for note in part.notes if "cut out" in note]


def test_what_would_fall_into_pieces_is_refused_by_name():
    bar = cq.Workplane().box(20, 2, 2)
    wall = cq.Workplane().box(1, 5, 5)
    assembly = cq.Assembly().add(bar, name="bar").add(wall, name="wall")
    with pytest.raises(CadError, match=r"cutting 'wall' out of 'bar' leaves 2 pieces"):
        cs.load(assembly, cut_overlaps=True)


def test_the_same_solid_twice_is_refused_all_the_same():
    assembly = cq.Assembly().add(cq.Workplane().box(2, 2, 2), name="one").add(cq.Workplane().box(2, 2, 2), name="two")
    with pytest.raises(CadError, match="the same solid twice"):
        cs.load(assembly, cut_overlaps=True)


def test_who_did_not_ask_is_told_of_it():
    with pytest.raises(CadError, match=r"(?s)overlap by a volume of 14\.14.*cut_overlaps=True \(--cut-overlaps\)"):
        cs.load(pin_in_plate())
