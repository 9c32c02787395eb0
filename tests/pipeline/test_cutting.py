"""Cells as solids: written, read again, meshed as an assembly; cuts that the user asks for."""

import json

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq
from click.testing import CliRunner

import cadsweep as cs
from cadsweep.cells import HEX_FACES as QUADS
from cadsweep.cli.group import cadsweep
from cadsweep.errors import CadError, NotSweepableError
from cadsweep.pipeline.columns.column_cells import columns_of
from cadsweep.pipeline.complexes import decomposing

pytestmark = pytest.mark.cad


def boxes_cross():
    """Three bars that cross in one place."""
    return cq.Workplane().box(30, 8, 8).union(cq.Workplane().box(8, 30, 8)).union(cq.Workplane().box(8, 8, 30))


def test_a_users_cut_that_leads_nowhere_is_made_in_the_cells_of_the_part_as_it_is(monkeypatch):
    real, seen = decomposing.plan_cells, []

    def plan(part, *args, **kwargs):
        seen.append(len(part.solids))
        if len(seen) == 1:
            raise NotSweepableError("no cuts were found")
        return real(part, *args, **kwargs)

    monkeypatch.setattr(decomposing, "plan_cells", plan)
    mesh = cs.sweep_mesh(boxes_cross(), cuts=["plane x=1"], size=2.0)
    assert seen[:2] == [2, 1]
    quads = np.concatenate([mesh.hexes[:, face] for face in QUADS])
    assert (np.abs(mesh.points[quads][:, :, 0] - 1.0).max(axis=1) < 1e-9).any()


def test_cells_are_pieces_of_the_part_that_touch():
    part = cs.load(boxes_cross())
    cells = cs.decompose(part)
    assert len(cells.solids) > 1
    assert set(cells.owners) == {0}
    assert len(cells.cuts) >= 1
    assert sum(solid.volume for solid in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-9)
    keys, times = np.unique(np.concatenate([solid.face_keys for solid in cells.solids]), return_counts=True)
    assert set(times) == {1, 2}
    shared = set(keys[times == 2].tolist())
    for solid in cells.solids:
        for face, key in zip(solid.faces, solid.face_keys.tolist(), strict=True):
            assert (face.key == "") == (key in shared)


def test_cells_of_a_stack_are_its_columns():
    part = cs.load(cq.Workplane().box(8, 8, 3).faces(">Z").workplane().rect(5, 5).cutBlind(-1).union(
        cq.Workplane().box(2, 2, 5)
    ))  # fmt: skip
    stack = cs.find_sweeps(part)[0]
    cells = cs.decompose(part)
    # The rim, the floor of the pocket, and the post through it with what sticks out below.
    assert len(cells.solids) == stack.n_columns == 3
    assert sum(solid.volume for solid in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-12)
    assert [cut.kind for cut in cells.cuts] == ["columns"]
    for solid in cells.solids:
        assert all(abs(face.normal @ stack.direction) in {0.0, 1.0} for face in solid.faces)


def test_columns_that_are_no_solids_are_told():
    """Under the top of a round boss, under both halves of the rounding about it, and the plate around: four columns."""
    plate = cq.Workplane().box(20, 20, 4).faces(">Z").workplane()
    part = cs.load(plate.circle(4).extrude(6).faces(">Z").edges().fillet(1))
    with pytest.raises(CadError, match=r"(?s)4 columns across \(0, 0, 1\) .* walls run tangent into face"):
        columns_of(part)


def test_a_part_that_sweeps_comes_back_as_it_is():
    part = cs.load(cq.Workplane().box(1, 2, 3))
    assert cs.decompose(part) is part


def test_written_cells_mesh_as_an_assembly(tmp_path):
    source, pieces = tmp_path / "cross.step", tmp_path / "pieces.step"
    cq.exporters.export(boxes_cross(), str(source))
    done = CliRunner().invoke(cadsweep, ["cut", str(source), "-o", str(pieces), "--json"])
    assert done.exit_code == 0, done.output
    data = json.loads(done.stdout)
    volume = 8**3 + 6 * 11 * 8**2
    assert sum(cell["volume"] for cell in data["cells"]) == pytest.approx(volume, rel=1e-9)
    # The outlines of the caps go through all of the part.
    assert [(cut["kind"], cut["place"]) for cut in data["cuts"]] == [("columns", None)]
    again = cs.load(pieces)
    assert len(again.solids) == len(data["cells"])
    mesh = cs.sweep_mesh(again, size=4.0)
    assert mesh.info["quality"].valid
    assert mesh.interfaces
    assert mesh.info["quality"].volume == pytest.approx(volume, rel=1e-9)


def test_a_plane_of_the_user_cuts_where_it_says():
    block = cq.Workplane().box(10, 10, 10).translate((1000.0, 0, 0))
    mesh = cs.sweep_mesh(block, cuts=["plane x=1002"], size=2.0)
    assert mesh.info["quality"].valid
    assert np.any(np.isclose(mesh.points[:, 0], 1002.0))
    assert list(mesh.parts) == ["part"]
    assert not mesh.interfaces


def test_a_face_of_the_user_is_extended():
    cells = cs.decompose(step(), cuts=["<Z[-2]"])
    assert sorted(solid.volume for solid in cells.solids) == pytest.approx([250.0, 500.0])


def step():
    """Two blocks, 250 on 500."""
    return cq.Workplane().box(10, 10, 10).cut(cq.Workplane().box(5, 10, 5).translate((2.5, 0, 2.5)))


@pytest.mark.parametrize(
    ("cut", "volumes", "reason"),
    [
        (cq.Plane.XY(), [250, 500], "asked for: 'plane 0.0,0.0,1.0,0.0'"),
        (cq.Plane((0, 0, 0), (0, 1, 0), (1, 0, 0)), [250, 500], "asked for: 'plane 1.0,0.0,0.0,0.0'"),
        (cq.Plane((7, 7, -1), (1, 0, 0), (0, 0, 1)), [350, 400], None),
        (cq.Face.makePlane(40, 40, (0, 0, 0), (1, 0, 0)), [250, 500], "asked for: a shape (Face)"),
        (step().faces("<Z[-2]").val(), [250, 500], "asked for: a shape (Face)"),  # one of the part itself
        (cq.Workplane().box(20, 20, 9).translate((0, 0, -5.5)), [350, 400], None),
    ],
)
def test_planes_faces_and_solids_of_cadquery_cut(cut, volumes, reason):
    cells = cs.decompose(step(), cuts=[cut])
    assert sorted(solid.volume for solid in cells.solids) == pytest.approx(volumes)
    if reason:
        assert [made.reason for made in cells.cuts] == [reason]
    mesh = cs.sweep_mesh(step(), cuts=[cut], size=5.0)
    assert mesh.info["quality"].valid
    assert mesh.info["quality"].volume == pytest.approx(750.0)


@pytest.mark.parametrize(
    ("cuts", "says"),
    [
        ("plane z=0", r"write cuts=\[...\] around 'plane z=0'"),
        (cq.Plane.XY(), r"write cuts=\[...\]"),
        (cq.Workplane().box(1, 1, 1).val(), r"write cuts=\[...\] around a shape \(Solid\)"),
        ([cq.Edge.makeLine((0, 0, 0), (1, 0, 0))], r"a shape \(Edge\) has no face"),
        ([3], r"cut a shape \(int\): cadsweep cannot load"),
        ([cq.Plane((0, 0, 50))], "'plane 0.0,0.0,1.0,50.0' parts no solid"),
    ],
)
def test_what_cannot_cut_is_refused_in_words(cuts, says):
    with pytest.raises(cs.InputError, match=says):
        cs.sweep_mesh(step(), cuts=cuts)


@pytest.mark.parametrize(
    ("cut", "says"),
    [
        ("plane z=99", "parts no solid"),
        ("plane q", "write 'plane z=3'"),
        ("face 99", "face 99"),
        ("nowhere.step", "no such file"),
    ],
)
def test_cuts_that_are_none_are_refused(cut, says):
    with pytest.raises(cs.InputError, match=says):
        cs.sweep_mesh(cq.Workplane().box(1, 1, 1), cuts=[cut])


def pockets_from_two_sides():
    """Neither a sweep nor columns: pockets in the top and in a side, apart from each other."""
    block = cq.Workplane().box(60, 40, 30)
    block = block.faces(">Z").workplane(origin=(-12, 0, 0)).rect(20, 12).cutBlind(-10)
    return block.faces(">Y").workplane(origin=(15, 0, 0)).circle(4).cutBlind(-20)


def test_faces_of_cells_are_known_by_their_numbers_in_the_part():
    part = cs.load(pockets_from_two_sides())
    cells = cs.decompose(part, cuts=["plane x=4"])
    faces = part.solids[0].faces
    area = dict.fromkeys(range(len(faces)), 0.0)
    for face in (face for solid in cells.solids for face in solid.faces):
        assert (face.known < 0) == (face.key == "")
        assert face.label().startswith("a cut" if face.known < 0 else f"face {face.known} ")
        if face.known >= 0:
            area[face.known] += face.area
    assert list(area.values()) == pytest.approx([face.area for face in faces])


def test_a_refusal_after_a_cut_names_the_faces_of_the_part_and_outlines_the_cell():
    part = cs.load(pockets_from_two_sides())
    with pytest.raises(cs.NotSweepableError) as refused:
        cs.sweep_mesh(part, cuts=["plane y=19"], decompose=False)
    named = [part.solids[0].faces[f].label().split(" (")[0] for f in refused.value.faces]
    assert named[0] + " " in str(refused.value)
    ends = np.concatenate(refused.value.left)
    # The cell on one side of the plane, and no more of the part.
    assert ends.min(axis=0) == pytest.approx([-30, -20, -15])
    assert ends.max(axis=0) == pytest.approx([30, 19, 15])
