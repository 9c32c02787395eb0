"""Names that users give are found on the faces they mean, through every way into the library."""

import re

import pytest

from cadsweep.cad.names.unique import declare, join_part, make_plain_names, plain
from cadsweep.errors import InputError

PLAIN = re.compile(r"[A-Za-z0-9_]+")


@pytest.mark.parametrize(
    "name", ["inlet", "in let", "Größe", "入口", "a-b", "~x", "", "1", "é", "__a__", "a/b\\c", "\x00"]
)
def test_plain_names_are_plain(name):
    assert PLAIN.fullmatch(plain(name))
    assert plain(plain(name)) == plain(name)


def test_names_in_other_scripts_can_still_be_read():
    assert [plain(name) for name in ("Größe", "Крышка 2", "ακτή", "底座1")] == ["Grosse", "Kryshka_2", "akti", "DiZuo1"]


def test_a_name_that_needs_no_change_keeps_it():
    plain_names, notes = make_plain_names(["wall a", "1", "wall_a"])
    assert plain_names == {"wall a": "wall_a_2", "1": "n1", "wall_a": "wall_a"}
    assert notes == ["name 'wall a' is written as 'wall_a_2'", "name '1' is written as 'n1'"]


def test_plain_names_stay_apart_also_without_case():
    plain_names, notes = make_plain_names(["in let", "in-let", "IN_LET", "other"])
    assert len({n.casefold() for n in plain_names.values()}) == 4
    assert plain_names["other"] == "other"
    assert plain_names["IN_LET"] == "IN_LET"
    assert len(notes) == 2


def test_overlapping_names_are_all_kept_the_smallest_first():
    declared = declare([("wall", [0, 1, 2]), ("inlet", [1]), ("wall", [3])])
    assert declared.by_entity == {0: ("wall",), 1: ("inlet", "wall"), 2: ("wall",), 3: ("wall",)}
    assert any("'inlet' and 'wall' share 1 face" in note for note in declared.notes)


def test_two_names_for_one_face_are_both_kept():
    declared = declare([("a", [0]), ("b b", [0])])
    assert declared.by_entity == {0: ("a", "b_b")}
    assert declared.originals == {"a": "a", "b_b": "b b"}


def test_part_prefixes():
    assert join_part("pipe", "inlet") == "pipe_inlet"
    assert join_part("pipe", "~inlet") == "inlet"
    assert join_part(None, "inlet") == "inlet"
    assert join_part("0c7b6a5e-1111-2222-3333-444455556666", "inlet") == "inlet"  # made up by CadQuery


@pytest.fixture
def cq():
    return pytest.importorskip("cadquery")


def named(part):
    return {face.name: tuple(round(float(c), 6) for c in face.center) for face in part.solids[0].faces if face.name}


@pytest.mark.cad
def test_tags_are_followed_through_later_cuts(cq):
    from cadsweep.cad import load, select_faces

    work = cq.Workplane().box(10, 10, 4)
    work.faces(">Z").tag("top")
    work.faces("<X").tag("in let")
    part = load(work.faces(">Z").workplane().hole(2))
    assert named(part) == {"top": (0, 0, 2), "in_let": (-5, 0, 0)}
    assert part.names == {"top": "top", "in_let": "in let"}
    assert select_faces(part, "in let") == select_faces(part, "in_let") == select_faces(part, "<X")
    with pytest.raises(InputError, match="CadQuery selector, such as") as refusal:
        select_faces(part, ">Q")
    assert len(str(refusal.value)) < 200


@pytest.mark.cad
def test_a_tag_on_a_face_that_is_gone_is_said_to_be_lost(cq):
    from cadsweep.cad import load

    work = cq.Workplane().box(10, 10, 4)
    work.faces(">Z").tag("top")
    part = load(work.faces(">Z").workplane().rect(20, 20).cutBlind(-1))
    assert named(part) == {}
    assert any("'top' is on no face" in note for note in part.notes)


def assembly(cq):
    work = cq.Workplane().box(10, 10, 4)
    whole = cq.Assembly(name="machine")
    whole.add(work, name="pipe", loc=cq.Location((1, 2, 3)), material=cq.Material("steel"))
    whole.pipe.addSubshape(work.faces("<Z").val(), name="bottom", color=cq.Color("red"))
    whole.pipe.addSubshape(work.faces("<Y").val(), name="~wall")
    return whole


@pytest.mark.cad
def test_names_of_an_assembly(cq):
    from cadsweep.cad import load

    part = load(assembly(cq))
    assert named(part) == {"pipe_bottom": (1, 2, 1), "wall": (1, -3, 3)}
    assert part.solids[0].name == "pipe"
    assert part.solids[0].material == "steel"


@pytest.mark.cad
def test_names_of_an_assembly_survive_a_step_file(cq, tmp_path):
    from cadsweep.cad import load

    assembly(cq).export(str(tmp_path / "machine.step"))
    assert named(load(tmp_path / "machine.step")) == named(load(assembly(cq)))


@pytest.fixture
def three_parts(cq):
    whole = cq.Assembly(name="machine")
    plate, pin = cq.Workplane().box(10, 10, 4), cq.Workplane().circle(1).extrude(3)
    whole.add(plate, name="base plate")
    whole.add(pin, name="pin", loc=cq.Location((0, 0, 2)))
    whole.add(cq.Assembly(pin, name="pin"), name="pin 2", loc=cq.Location((3, 0, 2)))
    whole.children[0].addSubshape(plate.faces("<Z").val(), name="bottom")
    whole.children[1].addSubshape(pin.faces(">Z").val(), name="head")
    return whole


@pytest.mark.cad
@pytest.mark.parametrize("form", ["object", "file"])
def test_one_solid_of_an_assembly_is_chosen_by_name_or_number(three_parts, tmp_path, form):
    from cadsweep.cad import load

    source = three_parts
    if form == "file":
        source = tmp_path / "machine.step"
        three_parts.export(str(source))
    plate = load(source, part="base plate")
    assert named(plate) == {"base_plate_bottom": (0, 0, -2)}
    assert plate.solids[0].volume * plate.scale**3 == pytest.approx(400)
    assert len(load(source, part="base_plate").solids[0].faces) == len(load(source, part=0).solids[0].faces) == 6
    assert named(load(source, part="pin")) == {"pin_head": (0, 0, 5)}
    assert not any("lost" in note or "on no" in note for note in plate.notes)


@pytest.mark.cad
def test_a_solid_that_is_not_there_is_refused_with_a_list_of_those_that_are(three_parts):
    from cadsweep.cad import load

    assert len(load(three_parts).solids) == 3
    with pytest.raises(InputError, match=r"no solid 'lid': there are 0 'base plate'.*, 2 "):
        load(three_parts, part="lid")
    with pytest.raises(InputError, match="no solid 3"):
        load(three_parts, part=3)


@pytest.mark.cad
def test_a_name_of_several_solids_asks_for_a_number(cq):
    from cadsweep.cad import load

    two = cq.Workplane().pushPoints([(0, 0), (9, 0)]).box(1, 2, 3)
    whole = cq.Assembly(two, name="feet")
    with pytest.raises(InputError, match=r"'feet' names 2 solids: there are 0 'feet' .*1 'feet'.*number"):
        load(whole, part="feet")
    assert load(whole, part="1").solids[0].vertices[:, 0].min() > 1


def colors(part):
    (solid,) = part.solids
    found = {tuple(round(float(c) * part.scale, 6) for c in face.center): face.color for face in solid.faces}
    return solid.color, {place: color for place, color in found.items() if color}


@pytest.mark.cad
@pytest.mark.parametrize("form", ["object", "file"])
def test_colours_of_a_part_and_its_faces(cq, tmp_path, form):
    from cadsweep.cad import load

    work = cq.Workplane().box(2, 4, 6)
    source = cq.Assembly(work, name="block", color=cq.Color(0.2, 0.4, 0.6))
    source.addSubshape(work.faces(">X").val(), name="hot", color=cq.Color("red"))
    source.addSubshape(work.faces(">Y").val(), color=cq.Color(0, 1, 0, 0.6))
    source.addSubshape(work.faces(">Z").val(), color=cq.Color(0.2, 0.4, 0.6))  # the part's own: says nothing of it
    if form == "file":
        source.export(str(tmp_path / "block.step"))
        source = tmp_path / "block.step"
    # 0.2, 0.4, 0.6 of 255 are 51, 102, 153.
    assert colors(load(source)) == ("#336699", {(1, 0, 0): "#ff0000", (0, 2, 0): "#00ff0099"})


@pytest.mark.cad
def test_a_part_has_the_colour_of_its_assembly_unless_it_has_its_own(cq, tmp_path):
    from cadsweep.cad import load

    whole = cq.Assembly(name="whole", color=cq.Color(0, 0, 1))
    whole.add(cq.Workplane().box(1, 1, 1), name="plain")
    whole.add(cq.Workplane().box(2, 1, 1), name="own", loc=cq.Location((5, 0, 0)), color=cq.Color(1, 1, 0))
    assert colors(load(whole, part="plain")) == ("#0000ff", {})
    assert colors(load(whole, part="own")) == ("#ffff00", {})


@pytest.mark.cad
def test_a_colour_that_all_faces_have_is_the_parts(cq):
    from cadsweep.cad import load

    work = cq.Workplane().box(1, 2, 3)
    whole = cq.Assembly(work, name="block")
    for face in work.faces().vals():
        whole.addSubshape(face, color=cq.Color(1, 1, 0))
    assert colors(load(whole)) == ("#ffff00", {})


@pytest.mark.cad
def test_names_beyond_ascii_survive_a_step_file_of_cadquery(cq, tmp_path):
    """CadQuery writes the bytes of a name as letters: ü becomes two of them."""
    from cadsweep.cad import load

    work = cq.Workplane().box(1, 2, 3)
    whole = cq.Assembly(work, name="Gehäuse 入口", material=cq.Material("Stahl weiß"))
    whole.addSubshape(work.faces(">X").val(), name="Größe 入口")
    whole.addSubshape(work.faces("<X").val(), name="Große")
    whole.export(str(tmp_path / "case.step"))
    for source in (whole, tmp_path / "case.step"):
        part = load(source)
        faces = {face.name for face in part.solids[0].faces} - {None}
        assert {part.names[name].split("_")[-1] for name in faces} == {"Größe 入口", "Große"}
        assert all(PLAIN.fullmatch(name) for name in faces)
        assert part.solids[0].name == "Gehause_RuKou"
        assert part.solids[0].material == "Stahl_weiss"
        assert any("'Gehäuse 入口' is written as 'Gehause_RuKou'" in note for note in part.notes)


@pytest.mark.cad
def test_edge_names(cq):
    from cadsweep.cad import load

    work = cq.Workplane().box(1, 2, 3)
    work.edges("|Z and >X and >Y").tag("corner")
    solid = load(work).solids[0]
    (edge,) = (e for e in solid.edges if e.name == "corner")
    assert edge.midpoint == pytest.approx([0.5, 1.0, 0.0])


@pytest.mark.cad
def test_a_divided_face_gives_its_name_to_all_pieces(cq):
    from cadsweep.cad import load

    work = cq.Workplane().cylinder(2, 1)
    work.faces("%CYLINDER").tag("wall")
    faces = load(work).solids[0].faces
    assert [face.name for face in faces if face.kind == "cylinder"] == ["wall", "wall"]


def edges_of(part, name):
    return [edge for edge in part.solids[0].edges if edge.name == name]


@pytest.mark.cad
def test_names_of_edges_survive_an_assembly_and_a_step_file(cq, tmp_path):
    from cadsweep.cad import load, select_edges

    work = cq.Workplane().box(10, 10, 4).faces(">Z").workplane().hole(2)
    whole = cq.Assembly(name="machine")
    whole.add(work, name="pipe", loc=cq.Location((1, 2, 3)))
    whole.pipe.addSubshape(work.edges("%CIRCLE and >Z").val(), name="rim")
    whole.export(str(tmp_path / "machine.step"))
    for source in (whole, tmp_path / "machine.step"):
        part = load(source)
        pieces = edges_of(part, "pipe_rim")
        assert len(pieces) == 2  # the circle is divided, and both halves keep the name
        assert {edge.key for edge in pieces} == {pieces[0].key}
        assert all(edge.midpoint[2] == pytest.approx(5) for edge in pieces)
        assert select_edges(part, "rim") == tuple(edge.id for edge in pieces)


@pytest.mark.cad
def test_tags_on_edges_are_followed_through_later_cuts(cq):
    from cadsweep.cad import load

    work = cq.Workplane().box(10, 10, 4)
    work.edges(">Z and >X").tag("shortened")
    work.faces("<Z").wires().tag("foot")
    work.edges("<X and <Z").tag("gone")
    part = load(work.edges("<X and <Z").chamfer(1).edges("|Z and >X and >Y").chamfer(1))
    (edge,) = edges_of(part, "shortened")
    assert edge.length == pytest.approx(9)
    # Of the foot's wire the chamfers leave three edges, two of them shorter.
    assert sorted(edge.length for edge in edges_of(part, "foot")) == pytest.approx([8, 9, 9])
    assert any("'gone' is on no edge" in note for note in part.notes)


@pytest.mark.cad
def test_edges_are_chosen_by_name_id_and_selector(cq):
    from cadsweep.cad import load, select_edges, select_edges_of
    from cadsweep.errors import InputError

    work = cq.Workplane().box(1, 2, 3)
    work.edges("|Z and >X and >Y").tag("corner")
    part = load(work)
    edges = part.solids[0].edges
    (corner,) = select_edges(part, "corner")
    assert select_edges(part, f"edge {corner}") == select_edges(part, corner) == select_edges(part, str(corner))
    assert select_edges(part, "edges:|Z and >X and >Y") == (corner,)
    upright = {edge.id for edge in edges if abs(edge.tangents[0][2]) > 0.99}
    assert set(select_edges(part, "|Z")) == set(select_edges_of(part, "edges:|Z")[1]) == upright
    kind, around = select_edges_of(part, ">Z")
    assert kind == "face"
    assert set(around) == {edge.id for edge in edges if edge.midpoint[2] == pytest.approx(1.5)}
    with pytest.raises(InputError, match=r"(?s)No edge matches 'corners'.*'corner' \(edge \d+\)"):
        select_edges(part, "corners")
    with pytest.raises(InputError, match=r"(?s)face 0 .*named edges 'corner'"):
        select_edges_of(part, "corners")
    for wrong in ("", 12, "edge 12", "faces:>Z", ">Q", True, "|Z and %CIRCLE"):
        with pytest.raises(InputError):
            select_edges(part, wrong)


@pytest.mark.cad
def test_an_edge_name_that_merging_takes_away_is_said_to_be_lost(cq):
    from cadsweep.cad import find_mergeable, load, merge_faces, select_edges
    from cadsweep.errors import InputError

    work = cq.Workplane().box(2, 2, 2).union(cq.Workplane().box(2, 2, 2).translate((2, 0, 0)), clean=False)
    work.edges("|Z").edges(">Y").edges(cq.selectors.NearestToPointSelector((1, 1, 0))).tag("seam")
    work.edges("|Z and >X and >Y").tag("corner")
    part = load(work)
    assert len(edges_of(part, "seam")) == 1
    merged = merge_faces(part, find_mergeable(part))
    assert len(merged.solids[0].faces) == 6
    assert [edge.midpoint[:2].tolist() for edge in edges_of(merged, "corner")] == [[3, 1]]
    with pytest.raises(InputError, match="'seam' is lost"):
        select_edges(merged, "seam")


def test_of_many_changed_names_the_first_are_told():
    written, notes = make_plain_names([f"wall {j}" for j in range(12)])
    assert len(written) == 12
    assert notes[0] == "name 'wall 0' is written as 'wall_0'"
    assert notes[-1] == "7 more names are written otherwise, too"
