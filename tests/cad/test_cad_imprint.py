"""Solids of one part share what they touch in: keys, curves, surfaces, positions; faults are refused by name."""

import itertools
import math

import numpy as np
import pytest

from cadsweep.brep import Part
from cadsweep.errors import CadError, InputError

pytestmark = pytest.mark.cad


@pytest.fixture(scope="module")
def cq():
    return pytest.importorskip("cadquery")


@pytest.fixture
def load(cq):
    from cadsweep.cad import load

    return load


def box(cq, corner, size=(1, 1, 1)):
    return cq.Workplane().box(*size, centered=False).translate(corner)


def several(cq, *shapes):
    return cq.Compound.makeCompound([solid for shape in shapes for solid in shape.solids().vals()])


def shared(part: Part, kind: str, i: int = 0, j: int = 1) -> list[tuple[int, int]]:
    """Local ids of what cells i and j share: faces, edges or vertices."""
    keys = [list(getattr(part.solids[k], f"{kind}_keys")) for k in (i, j)]
    return [(keys[0].index(key), keys[1].index(key)) for key in sorted(set(keys[0]) & set(keys[1]))]


def assert_shares_exactly(part: Part):
    """What has one key is one thing, bit for bit, in every pair of cells; a face has two sides."""
    at = np.linspace(0.0, 1.0, 7)
    for i, j in itertools.combinations(range(len(part.solids)), 2):
        a, b = part.solids[i], part.solids[j]
        for one, other in shared(part, "vertex", i, j):
            assert np.array_equal(a.vertices[one], b.vertices[other])
        for one, other in shared(part, "edge", i, j):
            first, second = a.edges[one], b.edges[other]
            assert np.array_equal(first.curve.evaluate(at), second.curve.evaluate(at))
            for end in ("start", "end"):
                keys = [solid.vertex_keys[getattr(edge, end)] for solid, edge in ((a, first), (b, second))]
                assert keys[0] == keys[1]
        for one, other in shared(part, "face", i, j):
            first, second = a.faces[one], b.faces[other]
            assert np.allclose(first.normal, -second.normal)
            assert {a.edge_keys[e] for e in first.edges} == {b.edge_keys[e] for e in second.edges}
            for e in first.edges:
                twin = list(b.edge_keys).index(a.edge_keys[e])
                uv = first.surface.edge_uv(e, at)
                assert np.array_equal(uv, second.surface.edge_uv(twin, at))
                assert np.array_equal(first.surface.evaluate(uv), second.surface.evaluate(uv))
    for solid in part.solids:
        for edge in solid.edges:
            ends = edge.curve.evaluate(np.array([0.0, 1.0]))
            assert np.abs(ends - solid.vertices[[edge.start, edge.end]]).max() < max(1e-6, 2 * solid.tolerance)


CONTACTS = {
    # corner and size of the second box beside a unit box; shared faces, edges, vertices; faces of both
    "whole face": ((1, 0, 0), (1, 1, 1), (1, 4, 4), (6, 6)),
    "part of a face": ((1, 0.5, 0), (1, 1, 1), (1, 4, 4), (7, 7)),
    "an edge": ((1, 1, 0), (1, 1, 1), (0, 1, 2), (6, 6)),
    "a point": ((1, 1, 1), (1, 1, 1), (0, 0, 1), (6, 6)),
    "inside a face": ((0.25, 0.25, 1), (0.5, 0.5, 1), (1, 4, 4), (7, 6)),
    "nowhere": ((3, 0, 0), (1, 1, 1), (0, 0, 0), (6, 6)),
    "a sliver": ((1, 0.99, 0), (1, 1, 1), (1, 4, 4), (7, 7)),
}


@pytest.mark.parametrize("contact", CONTACTS)
def test_boxes_share_what_they_touch_in(cq, load, contact):
    corner, size, counts, n_faces = CONTACTS[contact]
    part = load(several(cq, box(cq, (0, 0, 0)), box(cq, corner, size)))
    assert tuple(len(shared(part, kind)) for kind in ("face", "edge", "vertex")) == counts
    assert tuple(len(solid.faces) for solid in part.solids) == n_faces
    assert [solid.volume for solid in part.solids] == pytest.approx([1, math.prod(size)], rel=1e-12)
    assert_shares_exactly(part)


@pytest.mark.parametrize("turned", [0, 90, 37])
@pytest.mark.parametrize("height", [3, 2, 5])
def test_a_pin_shares_the_wall_of_its_hole_wherever_the_seams_are(cq, load, turned, height):
    plate = cq.Workplane().box(6, 6, 3).faces(">Z").workplane().hole(2)
    pin = cq.Workplane().circle(1).extrude(height).translate((0, 0, -1.5)).rotate((0, 0, 0), (0, 0, 1), turned)
    part = load(several(cq, plate, pin))
    volumes = [solid.volume for solid in part.solids]
    assert volumes == pytest.approx([6 * 6 * 3 - 3 * math.pi, height * math.pi], rel=1e-9)
    common = [part.solids[0].faces[f] for f, _ in shared(part, "face")]
    assert {face.kind for face in common} == {"cylinder"}
    assert sum(face.area for face in common) == pytest.approx(2 * math.pi * min(height, 3), rel=1e-9)
    assert_shares_exactly(part)


def test_a_ball_shares_its_whole_surface_with_the_void_that_it_fills(cq, load):
    ball = cq.Workplane().sphere(1)
    part = load(several(cq, cq.Workplane().box(4, 4, 4).cut(ball), ball))
    assert len(shared(part, "face")) == len(part.solids[1].faces)
    assert [solid.volume for solid in part.solids] == pytest.approx([64 - 4 / 3 * math.pi, 4 / 3 * math.pi], rel=1e-9)
    assert_shares_exactly(part)


def test_every_piece_of_a_face_keeps_the_names_of_the_faces_it_comes_from_its_own_first(cq, load):
    base, cap = box(cq, (0, 0, 0), (2, 2, 1)), box(cq, (0, 0, 1), (1, 1, 1))
    base.faces(">Z").tag("top")
    cap.faces("<Z").tag("seat")
    part = load(cq.Assembly(name="all").add(base, name="base").add(cap, name="cap"))
    ((of_base, of_cap),) = shared(part, "face")
    assert part.solids[0].faces[of_base].names == ("base_top", "cap_seat")
    assert part.solids[1].faces[of_cap].names == ("cap_seat", "base_top")
    assert [face.names for face in part.solids[0].faces if "base_top" in face.names and face.id != of_base] == [
        ("base_top",)
    ]
    for solid in part.solids:
        assert all(face.key for face in solid.faces)


def nested(cq):
    bolt = cq.Workplane().circle(0.2).extrude(0.5)
    whole = cq.Assembly(name="pump").add(box(cq, (-1, -1, -1), (2, 2, 1)), name="base", color=cq.Color("red"))
    for side, x in (("left", -0.5), ("right", 0.5)):
        arm = cq.Assembly(name=side, loc=cq.Location((x, 0, 0)))
        whole.add(arm.add(bolt, name="bolt", loc=cq.Location((0, 0.1, 0)), color=cq.Color("blue")))
    return whole


@pytest.mark.parametrize("form", ["object", "step"])
def test_solids_of_an_assembly_have_names_of_their_own_paths_and_colours(cq, load, form, tmp_path):
    source = nested(cq)
    if form == "step":
        source.export(str(tmp_path / "pump.step"))
        source = tmp_path / "pump.step"
    part = load(source)
    assert [model.name for model in part.models] == ["base", "bolt_1", "bolt_2"]
    assert [model.path for model in part.models] == ["pump/base", "pump/left/bolt", "pump/right/bolt"]
    assert [model.color for model in part.models] == ["#ff0000", "#0000ff", "#0000ff"]
    assert [solid.name for solid in part.solids] == [model.name for model in part.models]
    assert part.owners == (0, 1, 2)
    for j, x in ((1, -0.5), (2, 0.5)):
        assert len(shared(part, "face", 0, j)) == 1
        assert np.mean(part.to_model(part.solids[j].vertices), axis=0) == pytest.approx([x, 0.1, 0.25])
    assert load(source, part="bolt_2").solids[0].faces[0].kind
    assert any("bolt_1 to bolt_2" in note for note in part.notes)


@pytest.mark.parametrize("form", ["step", "brep", "iges of solids", "iges of faces"])
def test_files_of_several_solids_are_read_with_all_of_them(cq, load, form, tmp_path):
    whole = several(cq, box(cq, (0, 0, 0)), box(cq, (1, 0, 0), (1, 1, 2)))
    path = tmp_path / f"two.{form.split()[0]}"
    if form.startswith("iges"):
        from OCP.IGESControl import IGESControl_Controller, IGESControl_Writer

        IGESControl_Controller.Init_s()
        writer = IGESControl_Writer("MM", 1 if form.endswith("solids") else 0)
        writer.AddShape(whole.wrapped)
        assert writer.Write(str(path))
    else:
        whole.export(str(path))
    part = load(path)
    assert sorted(solid.volume * part.scale**3 for solid in part.solids) == pytest.approx([1, 2], rel=1e-6)
    assert len(shared(part, "face")) == 1
    assert_shares_exactly(part)


def test_loose_faces_of_solids_side_by_side_and_round_ones_are_told_apart(cq, load):
    plate = cq.Workplane().box(6, 6, 3).faces(">Z").workplane().hole(2)
    pin = cq.Workplane().circle(1).extrude(3).translate((0, 0, -1.5))
    away = cq.Workplane().sphere(1).translate((9, 0, 0))
    part = load(cq.Compound.makeCompound([face for w in (plate, pin, away) for face in w.faces().vals()]))
    volumes = [6 * 6 * 3 - 3 * math.pi, 3 * math.pi, 4 / 3 * math.pi]
    assert [solid.volume for solid in part.solids] == pytest.approx(volumes, rel=1e-9)
    assert {part.solids[0].faces[f].kind for f, _ in shared(part, "face")} == {"cylinder"}


@pytest.mark.parametrize("form", ["step", "faces"])
def test_a_shell_that_looks_inwards_is_a_void(cq, load, tmp_path, form):
    """CadQuery writes a body that is hollow all around as two shells without a solid."""
    hollow = cq.Workplane().box(10, 10, 10).shell(-2)
    if form == "step":
        cq.exporters.export(hollow, str(tmp_path / "hollow.step"))
        part = load(tmp_path / "hollow.step")
    else:
        drops = hollow.union(cq.Workplane().sphere(1)).cut(cq.Workplane().sphere(0.5)).translate((3, 0, 0))
        part = load(cq.Compound.makeCompound(drops.faces().vals()))
    volumes = [10**3 - 6**3] + ([] if form == "step" else [4 / 3 * math.pi * (1 - 0.5**3)])
    assert [solid.volume * part.scale**3 for solid in part.solids] == pytest.approx(volumes, rel=1e-6)
    assert any("taken for a void" in note for note in part.notes)


def test_shells_that_both_look_outwards_are_two_solids(cq, load):
    nested = [face for size in (4, 2) for face in cq.Workplane().box(size, size, size).faces().vals()]
    with pytest.raises(CadError, match="lies wholly inside"):
        load(cq.Compound.makeCompound(nested))


def test_a_list_of_shapes_of_any_kind_is_one_part(cq, load):
    low, high = box(cq, (0, 0, 0)), box(cq, (0, 0, 1))
    low.faces("<Z").tag("foot")
    named = cq.Assembly(name="all").add(box(cq, (0, 0, 2)), name="lid")
    part = load([low, high.val(), named, box(cq, (5, 0, 0)).val().wrapped])
    assert [solid.name for solid in part.solids] == ["solid_1", "solid_2", "lid", "solid_3"]
    assert [len(shared(part, "face", i, j)) for i, j in ((0, 1), (1, 2), (0, 3))] == [1, 1, 0]
    assert [face.name for face in part.solids[0].faces if face.name] == ["foot"]
    with pytest.raises(InputError, match="item 1 of the list is a str"):
        load([low, "file.step"])
    with pytest.raises(InputError, match="empty"):
        load([])


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e5])
def test_working_units_are_those_of_the_whole_part(cq, load, scale):
    part = load(several(cq, *[box(cq, (k * scale, 0, 0), (scale, scale, scale)) for k in range(3)]))
    assert len({solid.units for solid in part.solids}) == 1
    assert [solid.volume * part.scale**3 for solid in part.solids] == pytest.approx([scale**3] * 3, rel=1e-9)
    assert [len(shared(part, "face", i, j)) for i, j in ((0, 1), (1, 2), (0, 2))] == [1, 1, 0]
    assert_shares_exactly(part)


def test_overlapping_solids_are_refused_with_names_volume_and_place(cq, load):
    whole = cq.Assembly(name="all").add(box(cq, (0, 0, 0), (2, 2, 2)), name="low")
    whole.add(box(cq, (1, 1, 1), (3, 3, 3)), name="high")
    with pytest.raises(CadError, match=r"'low' and 'high' overlap by a volume of 1 at \(1.5, 1.5, 1.5\)"):
        load(whole)


def test_a_solid_inside_another_is_refused(cq, load):
    with pytest.raises(CadError, match="'solid_2' lies wholly inside 'solid_1'"):
        load(several(cq, box(cq, (0, 0, 0), (3, 3, 3)), box(cq, (1, 1, 1))))


@pytest.mark.parametrize("how", ["one shape twice", "two alike"])
def test_the_same_solid_twice_is_refused(cq, load, how):
    one = box(cq, (2, 0, 0))
    other = one if how == "one shape twice" else box(cq, (2, 0, 0))
    whole = cq.Assembly(name="all").add(one, name="left").add(other, name="right")
    with pytest.raises(CadError, match=r"'left' and 'right'.*same solid.*\(2.5, 0.5, 0.5\)"):
        load(whole)


def test_an_invalid_solid_among_ten_is_named(cq, load):
    whole = cq.Assembly(name="all")
    for k in range(9):
        whole.add(box(cq, (2 * k, 0, 0)), name=f"brick{k}")
    faces = box(cq, (0, 5, 0)).faces().vals()[1:]
    whole.add(cq.Solid.makeSolid(cq.Shell.makeShell(faces)), name="broken")
    with pytest.raises(CadError, match="'broken': the solid is open"):
        load(whole)


def test_an_open_solid_of_a_step_file_is_named_when_it_is_left_out(cq, load, tmp_path):
    faces = box(cq, (0, 5, 0)).faces().vals()[1:]
    broken = cq.Solid.makeSolid(cq.Shell.makeShell(faces))
    whole = cq.Assembly(name="all").add(box(cq, (0, 0, 0)), name="one").add(box(cq, (1, 0, 0)), name="two")
    whole.add(broken, name="broken").export(str(tmp_path / "all.step"))
    part = load(tmp_path / "all.step")
    assert [model.name for model in part.models] == ["one", "two"]
    assert "5 faces that belong to no solid left out, of 'all/broken'" in part.notes


@pytest.mark.parametrize("touch", [-1.0, math.nan, math.inf])
def test_touch_is_a_distance(cq, load, touch):
    with pytest.raises(InputError, match="touch is a distance"):
        load(box(cq, (0, 0, 0)), touch=touch)


def gapped(cq, gap):
    return several(cq, box(cq, (0, 0, 0)), box(cq, (1 + gap, 0.25, 0.25)))


@pytest.mark.parametrize("gap", [1e-4, 1e-3])
def test_a_small_gap_is_noted_with_its_width_and_place(cq, load, gap):
    part = load(gapped(cq, gap))
    assert not shared(part, "vertex")
    (note,) = [note for note in part.notes if "apart" in note]
    assert note.startswith(f"'solid_1' and 'solid_2' are {gap:.3g} apart at (1, ")
    assert f"touch={1.1 * gap:.2g}" in note


@pytest.mark.parametrize("gap", [1e-4, 1e-3])
def test_touch_closes_the_gap_and_changes_volumes_by_no_more_than_it_explains(cq, load, gap):
    part = load(gapped(cq, gap), touch=1.1 * gap)
    assert len(shared(part, "face")) == 1
    assert not any("apart" in note for note in part.notes)
    for solid, model in zip(part.solids, part.models, strict=True):
        assert model.volume == pytest.approx(1, rel=1e-9)
        assert abs(solid.volume - model.volume) < 1.1 * gap * 6
    assert_shares_exactly(part)


def test_a_wide_gap_is_meant(cq, load):
    assert load(gapped(cq, 0.1)).notes == ()


def test_a_gap_between_round_faces_and_at_one_point_is_found(cq, load):
    plate = cq.Workplane().box(6, 6, 3).faces(">Z").workplane().hole(2)
    pin = cq.Workplane().circle(0.999).extrude(3).translate((0, 0, -1.5))
    assert any("are 0.001 apart" in note for note in load(several(cq, plate, pin)).notes)
    ball = cq.Workplane().sphere(1).translate((0, 0, 2.501))
    bed = cq.Workplane().box(6, 6, 3)
    assert any("are 0.001 apart at (0, 0, 1.5)" in note for note in load(several(cq, bed, ball)).notes)


def test_a_gap_beside_a_contact_is_found(cq, load):
    beam = box(cq, (0, 0, 1), (4, 1, 1))
    part = load(several(cq, box(cq, (0, 0, 0)), box(cq, (3, 0, -0.002)), beam))
    assert [sorted((len(shared(part, "face", 0, 2)), len(shared(part, "face", 1, 2))))] == [[0, 1]]
    assert any("'solid_2' and 'solid_3' are 0.002 apart" in note for note in part.notes)


def test_a_pin_a_little_too_thick_is_an_overlap_that_touch_closes(cq, load):
    plate = cq.Workplane().box(6, 6, 3).faces(">Z").workplane().hole(2)
    pin = cq.Workplane().circle(1.001).extrude(3).translate((0, 0, -1.5))
    with pytest.raises(CadError, match="overlap by a volume"):
        load(several(cq, plate, pin))
    assert len(shared(load(several(cq, plate, pin), touch=0.0012), "face")) == 2


def test_a_solid_may_rest_on_a_face_along_a_line_or_at_a_point(cq, load):
    bed = box(cq, (-2, -2, -1), (4, 4, 1))
    lying = cq.Workplane("XZ").circle(1).extrude(1).translate((0, 0, 1))
    tip = cq.Workplane(cq.Solid.makeCone(0, 1, 2))
    for resting, volume in (
        (lying, math.pi),
        (tip, math.pi * 2 / 3),
        (cq.Workplane().sphere(1).translate((0, 0, 1)), 4 / 3 * math.pi),
    ):
        part = load(several(cq, bed, resting))
        assert [solid.volume for solid in part.solids] == pytest.approx([16, volume], rel=1e-9)
        assert (len(part.solids[0].faces), len(part.solids[0].edges)) == (6, 12)


def test_contacts_say_what_touches_what(cq, load):
    from cadsweep.cad import find_contacts

    part = load(several(cq, box(cq, (0, 0, 0)), box(cq, (1, 0.5, 0)), box(cq, (0, -1, 1)), box(cq, (5, 5, 5))))
    found = {contact.models: (contact.kind, contact.area) for contact in find_contacts(part)}
    assert found == {(0, 1): ("face", pytest.approx(0.5)), (0, 2): ("edge", 0)}
    (contact,) = [c for c in find_contacts(part) if c.faces]
    ((i, f), (j, g)) = contact.faces[0]
    assert part.solids[i].face_keys[f] == part.solids[j].face_keys[g]


def test_pieces_of_one_solid_touch_in_cuts_and_not_in_contacts(cq):
    from cadsweep.cad import find_contacts, imprint

    shapes = [
        solid.wrapped
        for w in (box(cq, (0, 0, 0)), box(cq, (1, 0, 0)), box(cq, (2, 0, 0)))
        for solid in w.solids().vals()
    ]
    part = imprint(shapes, owners=[0, 0, 1])
    assert [contact.models for contact in find_contacts(part)] == [(0, 1)]
    assert [model.volume for model in part.models] == pytest.approx([2, 1])
    assert [solid.name for solid in part.solids] == ["solid_1", "solid_1", "solid_2"]


@pytest.mark.parametrize("degrees", [1e-5, 1.0, 37.0, 180.0])
def test_seams_of_coaxial_faces_do_not_cut_each_other_into_strips(cq, load, degrees):
    pin = cq.Workplane().circle(1).extrude(3)
    sleeve = cq.Workplane().circle(1.5).circle(1).extrude(3).rotate((0, 0, 0), (0, 0, 1), degrees)
    sleeve.faces("<Z").tag("foot")
    block = cq.Workplane().box(4, 4, 3, centered=(True, True, False)).faces(">Z").workplane().hole(3)
    whole = cq.Assembly(name="all").add(pin, name="pin").add(sleeve, name="sleeve").add(block, name="block")
    part = load(whole)
    # a pin is two halves and two caps, a sleeve two more halves, a block with a hole six sides and two halves
    assert [len(solid.faces) for solid in part.solids] == [4, 6, 8]
    assert min(edge.length for solid in part.solids for edge in solid.edges) == pytest.approx(3)
    volumes = [3 * math.pi, 3 * math.pi * (1.5**2 - 1), 3 * (16 - 1.5**2 * math.pi)]
    assert [solid.volume for solid in part.solids] == pytest.approx(volumes, rel=1e-12)
    (foot,) = [face for face in part.solids[1].faces if face.names]
    assert foot.names == ("sleeve_foot",)
    assert foot.center[2] == pytest.approx(0)
    assert len({face.key for solid in part.solids for face in solid.faces}) == 3 + 4 + 7
    assert_shares_exactly(part)


def test_a_seam_goes_to_the_edges_of_a_neighbour_drawn_in_two_halves(cq, load):
    halves = cq.Workplane().moveTo(1, 0).threePointArc((0, 1), (-1, 0)).threePointArc((0, -1), (1, 0)).close()
    pin = halves.extrude(3).rotate((0, 0, 0), (0, 0, 1), 20)
    sleeve = cq.Workplane().circle(1.5).circle(1).extrude(3)
    part = load(several(cq, sleeve, pin))
    assert [len(solid.faces) for solid in part.solids] == [6, 4]
    assert len(shared(part, "face")) == 2
    assert_shares_exactly(part)


def halved(cq, shape, x):
    """Two pieces of a solid cut at a plane of constant x, which share the cut."""
    from OCP.BOPAlgo import BOPAlgo_Splitter

    from cadsweep.cad.shapes import SOLID, subshapes

    splitter = BOPAlgo_Splitter()
    splitter.AddArgument(shape.solids().val().wrapped)
    splitter.AddTool(cq.Face.makePlane(20, 20, (x, 0, 0), (1, 0, 0)).wrapped)
    splitter.SetNonDestructive(True)
    splitter.Perform()
    return subshapes(splitter.Shape(), SOLID)


@pytest.mark.parametrize("x", [0.0, 0.8])
def test_pieces_of_a_cut_solid_share_their_cut_with_each_other_and_its_lines_with_the_neighbours(cq, x):
    from cadsweep.cad import find_contacts, imprint

    plate = cq.Workplane().box(4, 4, 1).faces(">Z").workplane().hole(1)
    lid = cq.Workplane().box(2, 2, 1).translate((0.3, 0, 1))
    pin = cq.Workplane().circle(0.5).extrude(1).translate((0, 0, -0.5)).rotate((0, 0, 0), (0, 0, 1), 10)
    whole = [w.solids().val().wrapped for w in (lid, pin)]
    part = imprint([*halved(cq, plate, x), *whole], owners=[0, 0, 1, 2])
    assert shared(part, "face", 0, 1)
    areas = {contact.models: contact.area for contact in find_contacts(part)}
    lid_on_pin = math.pi / 4
    assert areas == pytest.approx({(0, 1): 4 - lid_on_pin, (0, 2): math.pi, (1, 2): lid_on_pin}, rel=1e-9)
    assert_shares_exactly(part)
    again = imprint([s.kernel.shape for s in part.solids], owners=part.owners, models=part.models)
    assert [len(solid.faces) for solid in again.solids] == [len(solid.faces) for solid in part.solids]
    for kind in ("vertex", "edge", "face"):
        for i, j in itertools.combinations(range(4), 2):
            assert shared(again, kind, i, j) == shared(part, kind, i, j)


def test_a_model_whose_solids_share_faces_already_is_read_as_it_is(cq, load, tmp_path):
    from cadsweep.cad.shapes import compound

    first = load(several(cq, box(cq, (0, 0, 0)), box(cq, (1, 0.5, 0)), box(cq, (0, 0, 1), (0.5, 0.5, 1))))
    cq.Shape.cast(compound([s.kernel.shape for s in first.solids])).exportBrep(str(tmp_path / "joined.brep"))
    part = load(tmp_path / "joined.brep")
    assert [len(solid.faces) for solid in part.solids] == [len(solid.faces) for solid in first.solids]
    assert [len(shared(part, "face", i, j)) for i, j in ((0, 1), (0, 2), (1, 2))] == [1, 1, 0]
    assert_shares_exactly(part)


def test_a_wall_of_bricks_shares_every_bed_and_joint(cq, load):
    wall = [box(cq, (i + 0.5 * (j % 2), 0, 0.5 * j), (1, 1, 0.5)) for i in range(4) for j in range(3)]
    seen = []
    part = load(several(cq, *wall), on_progress=seen.append)
    from cadsweep.cad import find_contacts

    contacts = find_contacts(part)
    # 3 joints in each of 3 courses, and between two courses 7 half beds
    assert sum(contact.kind == "face" for contact in contacts) == 3 * 3 + 2 * 7
    assert sum(contact.area for contact in contacts) == pytest.approx(9 * 0.5 + 14 * 0.5)
    assert seen == sorted(seen)
    assert 0 <= seen[0] < seen[-1] <= 1


@pytest.mark.parametrize("step", [1e-5, 1e-3])
def test_outlines_that_nearly_coincide_are_noted_and_touch_makes_them_coincide(cq, load, step):
    whole = several(cq, box(cq, (0, 0, 0)), box(cq, (1, step, 0)), box(cq, (0, 0, 1), (2, 1, 1)))
    (note,) = load(whole).notes
    assert f"edges of {step:.2g} are left at (1, " in note
    assert f"touch={1.1 * step:.2g} " in note
    part = load(whole, touch=1.1 * step)
    assert part.notes == ()
    assert [len(solid.faces) for solid in part.solids] == [6, 6, 7]
    assert_shares_exactly(part)


def test_a_short_edge_that_a_solid_had_is_its_own_affair(cq, load):
    bevelled = cq.Workplane().box(1, 1, 1, centered=False).edges("|Z and <X and <Y").chamfer(1e-3)
    assert not any("is left" in note for note in load(several(cq, bevelled, box(cq, (1, 0, 0)))).notes)


def turned(shape):
    """Off the axes, so that no coordinate is a round number."""
    return shape.rotate((0, 0, 0), (1, 2, 3), 33).translate((5, 7, 11))


def test_blocks_that_touch_in_whole_faces_share_what_the_general_fuse_finds(cq, load, monkeypatch):
    from cadsweep.cad import find_contacts
    from cadsweep.cad.imprinting import fusing

    wedge = cq.Workplane("XZ", (0, 1, 0)).polyline([(3, 0), (4, 0), (3, 1)]).close().extrude(1)
    blocks = [box(cq, (i, 0, k)) for i in range(3) for k in range(2)]
    whole = several(cq, *(turned(shape) for shape in (*blocks, wedge)))
    made = []
    quick = fusing.share_whole_faces
    monkeypatch.setattr(fusing, "share_whole_faces", lambda *given: made.append(quick(*given)) or made[-1])
    shared_part = load(whole)
    assert made != [None]
    assert_shares_exactly(shared_part)
    monkeypatch.setattr(fusing, "share_whole_faces", lambda *_: None)
    fused = load(whole)
    found, expected = find_contacts(shared_part), find_contacts(fused)
    assert [(c.models, len(c.faces), c.n_edges, c.n_vertices) for c in found] == [
        (c.models, len(c.faces), c.n_edges, c.n_vertices) for c in expected
    ]
    assert [c.area for c in found] == pytest.approx([c.area for c in expected])
    assert [s.volume for s in shared_part.solids] == pytest.approx([1.0] * 6 + [0.5])
    for one, other in zip(shared_part.solids, fused.solids, strict=True):
        assert sorted(face.key for face in one.faces) == sorted(face.key for face in other.faces)


@pytest.mark.parametrize("gap", [0.0, 1e-4])
def test_blocks_with_the_same_corners_and_other_faces_are_not_taken_for_whole_faces(cq, load, gap):
    # Two wedges on a cube: the corners of both together are the cube's, its face is divided.
    wedges = [
        cq.Workplane("XY", (0, 0, 1 + gap)).polyline(corners).close().extrude(1)
        for corners in ([(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)])
    ]
    part = load(several(cq, box(cq, (0, 0, 0)), *wedges))
    assert [len(shared(part, "face", 0, k)) for k in (1, 2)] == ([1, 1] if gap == 0 else [0, 0])
    assert len(shared(part, "face", 1, 2)) == 1
    assert len(part.solids[0].faces) == (7 if gap == 0 else 6)
    assert_shares_exactly(part)
