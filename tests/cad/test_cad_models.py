"""What is made of models that are not one clean solid in handy units: mended with a note, or refused by name."""

import numpy as np
import pytest

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

from OCP.BRep import BRep_Builder  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid  # noqa: E402
from OCP.TopoDS import TopoDS, TopoDS_Shell, TopoDS_Solid  # noqa: E402

from cadsweep.cad import cut_ring, load, select_faces  # noqa: E402
from cadsweep.cad.heal.validate import signed_volume  # noqa: E402
from cadsweep.errors import CadError, CadSweepError, InputError  # noqa: E402


def box():
    return cq.Workplane().box(1, 2, 3)


def half_torus():
    return cq.Workplane().circle(2).revolve(180, (5, 0, 0), (5, 1, 0)).val()


def mesh_volume(part):
    return part.solids[0].volume * part.scale**3


def test_loose_faces_are_sewn_and_said_so():
    part = load(cq.Compound.makeCompound(box().val().Faces()))
    assert part.solids[0].volume == pytest.approx(6.0)
    assert any("sewn" in note for note in part.notes)


def test_solids_without_faces_are_left_out_and_said_so():
    empty = TopoDS_Solid()
    BRep_Builder().MakeSolid(empty)
    part = load(cq.Compound.makeCompound([box().val(), cq.Shape(empty)]))
    assert mesh_volume(part) == pytest.approx(6.0)
    assert any("no faces" in note and "left out" in note for note in part.notes)


@pytest.mark.parametrize("turn", ["solid", "shell"])
def test_an_inside_out_solid_is_turned(turn):
    wrapped = box().val().wrapped
    if turn == "solid":
        shape = wrapped.Reversed()
    else:
        shape = BRepBuilderAPI_MakeSolid(TopoDS.Shell_s(box().val().Shells()[0].wrapped.Reversed())).Solid()
    part = load(shape)
    assert part.solids[0].volume == pytest.approx(6.0)
    assert any("inside out" in note for note in part.notes)
    for face in part.solids[0].faces:
        assert face.normal @ face.center > 0  # the box is about the origin


def open_solid():
    return BRepBuilderAPI_MakeSolid(cq.Shell.makeShell(box().val().Faces()[:5]).wrapped).Solid()


def bodies_that_share_an_edge():
    small = cq.Workplane().box(1, 1, 1)
    lid = cq.Workplane().box(3, 3, 1).translate((0, 0, 1))
    return small.union(small.translate((1, 1, 0))).union(lid)


@pytest.mark.parametrize(
    ("shape", "reason"),
    [
        (open_solid, "only one face ends at"),
        (lambda: cq.Compound.makeCompound(box().val().Faces()[:5]), "do not close"),
        (bodies_that_share_an_edge, "more than two faces meet at"),
        (lambda: cq.Workplane().box(4, 4, 1).faces(">Z").workplane().center(1, 0).hole(2), "more than two faces"),
        (lambda: cq.Workplane().polyline([(0, 0), (2, 2), (2, 0), (0, 2)]).close().extrude(1), "self intersecting"),
        (lambda: cq.Workplane().polyline([(0, 0), (3, 3), (3, 0), (0, 2)]).close().extrude(1), "self intersecting"),
        (lambda: cq.Workplane().rect(1, 1), "only wires"),
        (lambda: box().val().moved(cq.Location((float("nan"), 0, 0))), "not a finite number"),
        (lambda: box().val().moved(cq.Location((1e300, 0, 0))), "not a finite number"),
    ],
)
def test_refusals_name_what_and_where(shape, reason):
    with pytest.raises(CadError, match=reason):
        load(shape())


@pytest.mark.parametrize("source", [None, 5, object(), "part.stl", "no_such_file.step", cq.Workplane()])
def test_what_is_no_model_is_refused(source):
    with pytest.raises(CadSweepError):
        load(source)


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9])
def test_size_is_normalised_and_restored(scale):
    part = load(half_torus().scale(scale))
    assert np.log2(part.scale) == round(np.log2(part.scale))
    assert 1.0 <= part.solids[0].size <= 1e4
    assert mesh_volume(part) == pytest.approx(20 * np.pi**2 * scale**3, rel=1e-9)
    vertices = part.to_model(part.solids[0].vertices)
    assert np.abs(vertices).max() == pytest.approx(10 * scale + 2 * scale, rel=0.2)


def folded_sheet():
    sheet = box().faces(">Z").val().wrapped
    shell, folded, builder = TopoDS_Shell(), TopoDS_Solid(), BRep_Builder()
    builder.MakeShell(shell)
    builder.Add(shell, sheet)
    builder.Add(shell, sheet.Reversed())
    builder.MakeSolid(folded)
    builder.Add(folded, shell)
    return cq.Solid(folded)


def test_a_folded_sheet_is_flat():
    with pytest.raises(CadError, match="no volume"):
        signed_volume(folded_sheet().wrapped)


@pytest.mark.parametrize("size", [(1e4, 1e-2, 1e-2), (1e4, 1e4, 1e-3)])
def test_needles_and_sheets_are_not_flat(size):
    aslant = cq.Workplane().box(*size).rotate((0, 0, 0), (1, 2, 3), 37).translate((7, 8, 9))
    part = load(aslant)
    assert part.solids[0].volume * part.scale**3 == pytest.approx(np.prod(size), rel=1e-6)


def test_parts_in_range_are_left_alone():
    part = load(box())
    assert part.scale == 1.0
    assert not part.offset.any()


def test_far_parts_are_shifted_and_restored():
    part = load(half_torus().moved(cq.Location((1e7, -1e7, 0))))
    assert np.abs(part.solids[0].vertices).max() < 100
    near = load(half_torus())
    assert np.allclose(part.to_model(part.solids[0].vertices), near.solids[0].vertices + [1e7, -1e7, 0], atol=1e-7)


def test_the_solid_behind_a_selection_is_taken():
    assert load(box().faces(">Z")).solids[0].volume == pytest.approx(6.0)


def test_selectors_and_ids():
    part = load(box())
    (top,) = select_faces(part, ">Z")
    assert part.solids[0].faces[top].normal == pytest.approx([0, 0, 1])
    assert select_faces(part, str(top)) == select_faces(part, top) == select_faces(part, f"face {top}") == (top,)
    assert select_faces(part, "faces:>Z") == (top,)
    assert len(select_faces(part, "|Z")) == 2
    assert len(select_faces(part, "#Z")) == 4


def test_pieces_of_a_divided_face_share_its_key():
    part = load(cq.Workplane().cylinder(2, 1))
    pieces = [face for face in part.solids[0].faces if face.kind == "cylinder"]
    assert len(pieces) == 2
    assert pieces[0].key == pieces[1].key != ""
    assert [select_faces(part, f"face {face.id}") for face in pieces] == [(face.id,) for face in pieces]


@pytest.mark.parametrize("selector", ["inlett", 99, "99", ">Q", "", True])
def test_a_face_that_is_not_there_lists_those_that_are(selector):
    with pytest.raises(InputError):
        select_faces(load(box()), selector)
    with pytest.raises(InputError, match=r"face 0 \(plane"):
        select_faces(load(box()), "nowhere")


def rings():
    oval = cq.Workplane("XZ").center(15, 0).ellipse(4, 2).revolve(360, (-15, 0, 0), (-15, 1, 0))
    return {
        "washer": cq.Workplane().circle(3).circle(2).extrude(1),
        "torus": cq.Workplane(cq.Solid.makeTorus(5, 2)),
        "oval": oval,
        "tilted": oval.rotate((0, 0, 0), (1, 1, 0), 33).translate((3, 4, 5)),
        "hollow": cq.Workplane(cq.Solid.makeTorus(5, 2)).cut(cq.Workplane(cq.Solid.makeTorus(5, 1))),
    }


@pytest.mark.parametrize("name", rings())
def test_a_full_ring_is_cut_to_two_coincident_caps(name):
    ring = load(rings()[name])
    cut = cut_ring(ring)
    solid = cut.solids[0]
    assert solid.volume == pytest.approx(ring.solids[0].volume, rel=1e-7)
    first, second = (face for face in solid.faces if not face.key)
    assert first.center == pytest.approx(second.center, abs=1e-9)
    assert first.normal == pytest.approx(-second.normal, abs=1e-9)
    assert not set(first.edges) & set(second.edges)
    uses = np.bincount([e for face in solid.faces for e in face.edges], minlength=len(solid.edges))
    assert (uses == 2).all()


@pytest.mark.parametrize(
    "shape",
    [
        box,
        half_torus,
        lambda: cq.Workplane().cylinder(2, 1),
        lambda: cq.Workplane().sphere(1),
        lambda: cq.Workplane().circle(3).circle(2).extrude(1).cut(cq.Workplane().center(2.5, 0).circle(0.2).extrude(1)),
    ],
)
def test_what_is_no_ring_is_not_cut(shape):
    assert cut_ring(load(shape())) is None


def slivers():
    plate = cq.Workplane().box(4, 4, 1)
    return {
        "short side": cq.Workplane().polyline([(0, 0), (4, 0), (4.00005, 0.00003), (4, 3), (0, 3)]).close().extrude(2),
        "ledge": plate.union(plate.translate((0, 0.00005, 1)), clean=False),
        "tiny chamfer": cq.Workplane().box(4, 4, 2).edges("|Z and >X and >Y").chamfer(0.0001),
        "ring": countersunk(0.0002),
    }


def countersunk(missed):
    """A block with a square hole and a countersink that is wider than the hole by a little."""
    block = cq.Workplane().box(4, 3, 2).faces(">Z").workplane().rect(0.3, 0.4).cutThruAll()
    wide = cq.Workplane("XY", (0, 0, 0.9)).rect(0.3 + missed, 0.4 + missed)
    return block.cut(wide.workplane(offset=0.1).rect(0.5 + missed, 0.6 + missed).loft())


def test_a_ring_wider_than_a_sliver_stays():
    part = load(countersunk(0.02))
    assert len(part.solids[0].faces) == 15
    assert not any("slivers" in note for note in part.notes)


@pytest.mark.parametrize("name", slivers())
def test_slivers_are_merged_and_said_so(name):
    part = load(slivers()[name])
    solid = part.solids[0]
    assert min(edge.length for edge in solid.edges) > 0.1
    assert solid.volume == pytest.approx(slivers()[name].val().Volume(), rel=1e-4)
    assert any("slivers merged" in note for note in part.notes)


def test_a_slit_is_not_closed():
    """Its floor and its ends are narrow, but without them its sides would lie on each other."""
    block = cq.Workplane().box(20, 20, 20).faces(">Z").workplane().rect(1e-3, 8).cutBlind(-5)
    part = load(block)
    assert len(part.solids[0].faces) == 11
    assert not any("slivers" in note for note in part.notes)


def test_a_step_between_two_floors_is_no_sliver():
    # The corner of one boss stands on the other, 0.01 above it: without that edge both tops would share a vertex.
    plate = cq.Workplane().box(60, 60, 10)
    one = cq.Workplane("XY", (-5, -5, 4)).rect(20, 20).extrude(6)
    other = cq.Workplane("XY", (5, 5, 4)).rect(20, 20).extrude(6.01)
    part = load(plate.union(one).union(other))
    assert not any("slivers" in note for note in part.notes)
    assert min(edge.length for edge in part.solids[0].edges) * part.scale == pytest.approx(0.01)


@pytest.mark.parametrize(
    "shape",
    [
        lambda: cq.Workplane().box(1000, 1000, 0.01),
        lambda: cq.Workplane().circle(1e-3).extrude(100),
        lambda: cq.Workplane().box(100, 100, 20).edges("|Z").fillet(0.5),
    ],
    ids=["sheet", "wire", "small fillets"],
)
def test_thin_parts_and_small_features_are_no_slivers(shape):
    part = load(shape())
    assert part.solids[0].volume == pytest.approx(shape().val().Volume(), rel=1e-12)
    assert not any("sliver" in note for note in part.notes)
