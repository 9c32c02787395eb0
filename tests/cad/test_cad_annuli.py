"""Plane faces around a hole are divided, so that walls can be swept across."""

import pytest

cq = pytest.importorskip("cadquery")

import cadsweep as cs  # noqa: E402
from cadsweep.cad import divide_annuli, load  # noqa: E402

TUBE = cq.Workplane().circle(10).circle(6).extrude(20)


def test_the_ends_of_a_tube_become_two_faces_each_and_keep_their_ids():
    part = load(TUBE)
    divided = divide_annuli(part)
    old, new = part.solids[0], divided.solids[0]
    assert len(new.faces) == len(old.faces) + 2
    assert [(a.key, a.kind) for a in old.faces] == [(b.key, b.kind) for b in new.faces[: len(old.faces)]]
    assert new.volume == pytest.approx(old.volume, rel=1e-12)
    ends = [face for face in new.faces if face.kind == "plane"]
    assert sum(face.area for face in ends) == pytest.approx(sum(f.area for f in old.faces if f.kind == "plane"))
    assert all(len(face.loops) == 1 for face in ends)


def test_nothing_to_divide_is_none():
    assert divide_annuli(load(cq.Workplane().box(1, 2, 3))) is None
    assert (
        divide_annuli(load(cq.Workplane().rect(40, 40).extrude(2).faces(">Z").workplane().rarray(10, 10, 2, 2).hole(3)))
        is None
    )


def test_loops_that_touch_leave_nothing_to_divide():
    """A boss that touches the rim of a disc from inside: the face around it runs out to nothing there."""
    disc = cq.Workplane().circle(10).extrude(5)
    assert divide_annuli(load(disc.union(cq.Workplane(origin=(5, 0, 5)).circle(5).extrude(6)))) is None


def test_a_tube_is_swept_across_its_wall_where_the_user_says_so():
    along = cs.find_sweeps(TUBE)[0]
    assert {along.solid.faces[f].kind for f in along.source} == {"plane"}
    part = load(TUBE)
    outside = [face.id for face in part.solids[0].faces if face.kind == "cylinder" and abs(face.center[1]) > 5]
    mesh = cs.sweep_mesh(part, source=outside[0], layers=3)
    (sweep,) = mesh.info["sweeps"]
    assert sweep["layers"] == 3
    assert sorted(sweep["source"]) == outside
    report = mesh.quality()
    assert report.valid
    assert report.min_scaled_jacobian > 0.9


def test_names_of_a_divided_end_hold_on_both_halves():
    tube = cq.Assembly(TUBE, name="tube")
    tube.addSubshape(TUBE.faces(">Z").val(), name="~rim")
    part = load(tube)
    outside = [face.id for face in part.solids[0].faces if face.kind == "cylinder" and abs(face.center[1]) > 5]
    mesh = cs.sweep_mesh(tube, source=outside[0], layers=3)
    assert mesh.quality().areas["rim"] == pytest.approx(3.141592653589793 * (100 - 36), rel=0.01)


def test_a_tube_has_three_directions():
    along, *others = cs.find_sweeps(TUBE)
    assert {along.solid.faces[f].kind for f in along.source} == {"plane"}
    kinds = [{sweep.solid.faces[f].kind for f in sweep.source} for sweep in others]
    assert sorted(kinds, key=str) == [{"cylinder"}, {"plane"}]
    assert [sum("around the axis" in note for note in sweep.notes) for sweep in others if sweep.notes].count(1) == 1
