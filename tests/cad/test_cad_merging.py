"""Faces that only divide one surface, merged; names of pieces stay as patches."""

import numpy as np
import pytest

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

from cadsweep.brep import lie_in  # noqa: E402
from cadsweep.cad import find_mergeable, load, merge_faces  # noqa: E402


def imprinted(part, tool):
    return part.cut(tool).fuse(part.intersect(tool)).Solids()[0]


def lofted():
    return cq.Workplane().rect(10, 8).workplane(offset=15).transformed(rotate=(0, 0, 30)).rect(6, 6).loft().val()


def sphere_slice():
    return cq.Workplane("XZ").moveTo(0, -3).lineTo(4, -3).threePointArc((5, 0), (4, 3)).lineTo(0, 3).close()


BODIES = {
    "plane": lambda: cq.Workplane().box(10, 10, 15).translate((0, 0, 7.5)).val(),
    "cylinder": lambda: cq.Workplane().circle(5).extrude(15).val(),
    "cone": lambda: cq.Solid.makeCone(6, 4, 15),
    "sphere": lambda: sphere_slice().revolve(360, (0, 0, 0), (0, 1, 0)).val().translate(cq.Vector(0, 0, 7)),
    "bspline": lofted,
    "extrusion": lambda: (
        cq.Workplane()
        .spline([(6, 0), (4, 4), (0, 3), (-5, 4), (-6, -1), (0, -5)], periodic=True)
        .close()
        .extrude(15)
        .val()
    ),
}


@pytest.mark.parametrize("through_file", [False, True], ids=["as made", "from a file"])
@pytest.mark.parametrize("kind", BODIES)
def test_an_imprint_on_any_surface_is_merged_and_stays_a_patch(kind, through_file, tmp_path):
    body = BODIES[kind]()
    tool = cq.Workplane("YZ", origin=(1, 0.5, 7)).circle(1.5).extrude(9).val()
    solid = imprinted(body, tool)
    if through_file:
        cq.exporters.export(cq.Workplane(solid), str(tmp_path / "body.step"))
        solid = cq.importers.importStep(str(tmp_path / "body.step")).val()
    pads = [face for face in solid.Faces() if face.Center().x > 2 and face.Area() < 12]
    assembly = cq.Assembly(solid)
    for pad in pads:
        assembly.addSubshape(pad, name="pad")
    part, plain = load(assembly), load(body)
    merged = merge_faces(part, find_mergeable(part))
    (before,), (after,), (as_drawn,) = part.solids, merged.solids, plain.solids
    assert len(after.faces) == len(as_drawn.faces)
    assert after.volume == pytest.approx(before.volume, rel=1e-6)
    patches = [(face, patch) for face in after.faces for patch in face.former]
    assert {patch.names for _, patch in patches} == {("pad",)}
    pieces = [face for face in before.faces if face.name == "pad"]
    different = {id(patch): patch.area for _, patch in patches}  # parts of a divided face share theirs
    assert sum(different.values()) == pytest.approx(sum(piece.area for piece in pieces))
    for face, patch in patches:
        distance = np.linalg.norm(face.surface.evaluate(face.surface.project(patch.place[None])) - patch.place)
        assert distance < 1e-6
        assert lie_in([patch], patch.place[None]).all()
        opposite = face.surface.evaluate(face.surface.project(patch.place[None] * [1, 1, 0]))
        assert not lie_in([patch], opposite).any()


def test_tangent_faces_of_different_surfaces_stay():
    part = load(cq.Workplane().rect(10, 6).extrude(5).edges("|Z").fillet(2).val())
    assert find_mergeable(part) == []


def test_only_the_chosen_groups_are_merged():
    body = cq.Workplane().box(20, 20, 4).val()
    for z in (-2, 2):
        body = imprinted(body, cq.Workplane(origin=(0, 0, z)).rect(5, 5).extrude(1, both=True).val())
    part = load(body)
    groups = find_mergeable(part)
    assert len(groups) == 2
    (merged,) = merge_faces(part, groups[:1]).solids
    assert len(merged.faces) == len(part.solids[0].faces) - 1


def test_a_mitre_across_a_flat_side_is_kept_for_a_station():
    path = cq.Workplane("XZ").polyline([(0, 0), (0, 20), (12, 36)])
    bar = cq.Workplane().rect(8, 6).sweep(path, transition="right").val()
    halves = [face for face in bar.Faces() if abs(face.normalAt().y) > 0.9]
    if len(halves) == 2:  # the sweep has joined the flat sides; draw the mitre on them again
        beyond = cq.Solid.makeBox(100, 100, 100, pnt=cq.Vector(-50, -50, 0))
        beyond = beyond.rotate(cq.Vector(0, 0, 0), cq.Vector(0, 1, 0), 18.434948822922).translate(cq.Vector(0, 0, 20))
        bar = bar.cut(beyond).fuse(bar.intersect(beyond)).Solids()[0]
    part = load(bar)
    assert len(part.solids[0].faces) == 10
    assert find_mergeable(part) == []
    assert [len(group) for group in find_mergeable(part, across_kinks=True)] == [1, 1]
