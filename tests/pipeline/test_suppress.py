"""Features are removed where the user asks for it, each with its place and volume; names of the rest stay."""

from math import pi

import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

from cadsweep import InputError, cad, load, sweep_mesh
from cadsweep.cad.edit.defeaturing import small_features

pytestmark = pytest.mark.cad


def plate():
    """A plate 40 x 30 x 10 with a through hole, a blind hole and a rounded rim, its bottom and hole named."""
    part = cq.Workplane().box(40, 30, 10).faces(">Z").edges().fillet(0.4)
    part = part.faces("<Z").workplane().pushPoints([(-10, 0)]).circle(1).cutThruAll()
    part = part.faces("<Z").workplane().pushPoints([(10, 0)]).circle(1.5).cutBlind(-4)
    assembly = cq.Assembly(part, name="plate")
    assembly.addSubshape(part.faces("<Z").val(), name="bottom")
    return assembly


def suppressed(notes):
    return [note for note in notes if note.startswith("suppressed")]


def test_volumes_are_those_of_the_features():
    """The plate without anything is a box; each hole adds its cylinder."""
    part = load(plate())
    filled = cad.suppress(part, ["holes d<3.5"])
    assert len(suppressed(filled.notes)) == 2
    assert filled.models[0].volume - part.models[0].volume == pytest.approx(10 * pi + 4 * 2.25 * pi, rel=1e-6)
    box = cad.suppress(filled, ["fillets r<0.5"])
    assert box.models[0].volume == pytest.approx(40 * 30 * 10)
    assert len(box.solids[0].faces) == 6


def test_what_a_refusal_proposes_can_be_asked_as_it_stands():
    part = load(plate())
    left = cad.suppress(part, small_features(part))
    assert suppressed(left.notes)
    assert small_features(left) == []


def test_limits_choose():
    part = load(plate())
    (note,) = suppressed(cad.suppress(part, ["holes d<2.5"]).notes)
    assert "diameter 2 " in note
    assert f"{10 * pi:+.4f}"[:6] in note


def test_names_of_the_rest_stay_and_those_of_what_is_gone_are_told():
    part = load(plate())
    kept = cad.suppress(part, ["holes"])
    assert any("bottom" in face.name for face in kept.solids[0].faces if face.name)
    (hole,) = (f for f in kept.solids[0].faces if f.name)
    assert hole.kind == "plane"


def test_the_slot_keeps_its_round_ends():
    """Half a turn is no rounding."""
    part = load(cq.Workplane().box(40, 20, 5).faces(">Z").workplane().slot2D(20, 6).cutThruAll())
    with pytest.raises(InputError, match="no such feature"):
        cad.suppress(part, ["fillets"])


@pytest.mark.parametrize(
    ("word", "said"), [("fillets d<2", "fillets r<"), ("holes d<x", "holes d<2"), ("holes d<0.1", "no such")]
)
def test_what_is_not_understood_or_not_there_is_refused(word, said):
    with pytest.raises(InputError, match=said):
        cad.suppress(load(plate()), [word])


def test_a_face_without_which_nothing_closes_is_refused():
    with pytest.raises(InputError, match="none can be removed"):
        cad.suppress(load(cq.Workplane().box(4, 3, 2)), ["face 0"])


def test_the_mesh_is_that_of_the_plain_part_and_tells_what_is_gone():
    mesh = sweep_mesh(plate(), suppress=["holes", "fillets r<0.5"], size=5.0)
    assert mesh.info["quality"].volume == pytest.approx(12000)
    assert len(suppressed(mesh.info["notes"])) == 3


def stacked():
    """Two plates 20 x 20 x 4 on one another, the lower one with a hole of diameter 2, the upper one of 3."""
    assembly = cq.Assembly()
    for name, z, radius in (("low", 0.0, 1.0), ("high", 4.0, 1.5)):
        assembly.add(cq.Workplane(origin=(0, 0, z)).rect(20, 20).circle(radius).extrude(4), name=name)
    return load(assembly)


def shared_area(part):
    """Area of the faces that both solids have."""
    one, other = ({int(k): f.area for k, f in zip(s.face_keys, s.faces, strict=True)} for s in part.solids)
    return sum(area for key, area in one.items() if key in other)


@pytest.mark.parametrize(
    ("word", "radii"), [("holes d<2.5", (0.0, 1.5)), ("high: holes", (1.0, 0.0)), ("holes", (0.0, 0.0))]
)
def test_solids_of_an_assembly_lose_theirs_and_touch_as_before(word, radii):
    """What is left in contact is the square without the wider of the two holes."""
    found = cad.suppress(stacked(), [word])
    assert [model.name for model in found.models] == ["low", "high"]
    volumes = [4 * (400 - pi * r**2) for r in radii]
    assert [model.volume for model in found.models] == pytest.approx(volumes)
    assert shared_area(found) == pytest.approx(400 - pi * max(radii) ** 2)
    assert len(suppressed([note.split(": ", 1)[1] for note in found.notes])) == radii.count(0.0)


def test_the_number_of_a_face_needs_the_name_of_its_solid():
    part = stacked()
    with pytest.raises(InputError, match="NAME: face 0"):
        cad.suppress(part, ["face 0"])
    hole = next(face.id for face in part.solids[0].faces if face.kind == "cylinder")
    found = cad.suppress(part, [f"low: face {hole}", "low: holes"])  # one half of its wall, then what is left of it
    assert [model.volume for model in found.models] == pytest.approx([1600, 4 * (400 - 2.25 * pi)])
