"""The design of a part: sharp edges where the model is blended, the other faces one to one."""

import cadquery as cq
import pytest

import cadsweep as cs
from cadsweep.blends import find_blends
from cadsweep.cad.edit.design import design_of


def designed(shape):
    part = cs.load(shape)
    return part, design_of(part, find_blends(part.solids[0]))


@pytest.mark.parametrize(
    ("model", "sharp"),
    [
        (cq.Workplane().box(10, 8, 6).edges().fillet(1.5), cq.Workplane().box(10, 8, 6)),
        (
            cq.Workplane().box(20, 16, 8).cut(
                cq.Workplane().box(12, 8, 4).edges("|Z").fillet(2).faces("<Z").edges().fillet(1).translate((0, 0, 2))
            ),
            cq.Workplane().box(20, 16, 8).cut(cq.Workplane().box(12, 8, 4).translate((0, 0, 2))),
        ),
        (
            cq.Workplane().box(20, 20, 4).faces(">Z").workplane().circle(4).extrude(6)
            .edges(cq.selectors.BoxSelector((-5, -5, 1.5), (5, 5, 2.5))).fillet(1),
            cq.Workplane().box(20, 20, 4).faces(">Z").workplane().circle(4).extrude(6),
        ),
    ],
    ids=["box", "pocket", "boss"],
)  # fmt: skip
def test_blends_are_gone_and_the_other_faces_are_those_of_the_model(model, sharp):
    part, design = designed(model)
    (solid,), (found,) = part.solids, design.part.solids
    assert not design.left
    assert not find_blends(found)
    assert found.volume * part.scale**3 == pytest.approx(sharp.val().Volume(), rel=1e-6)
    kept = {f for own in design.model_faces for f in own}
    assert kept | design.gone == set(range(len(solid.faces)))
    assert not kept & design.gone
    for face, own in zip(found.faces, design.model_faces, strict=True):
        for of in own:
            assert face.kind == solid.faces[of].kind
            assert solid.faces[of].surface.distance(face.center[None])[0] < 1e-6 * solid.size or face.kind != "plane"


def test_a_part_without_blends_has_no_design():
    assert designed(cq.Workplane().box(3, 2, 1))[1] is None


def test_a_name_stays_on_a_face_whose_edges_were_joined():
    boss = cq.Workplane().box(20, 20, 4).faces(">Z").workplane().circle(4).extrude(6)
    boss = boss.edges(cq.selectors.BoxSelector((-5, -5, 1.5), (5, 5, 2.5))).fillet(1).faces(">Z").tag("top").end()
    _, design = designed(boss)
    named = [face for face in design.part.solids[0].faces if face.name == "top"]
    assert [face.kind for face in named] == ["plane"]
