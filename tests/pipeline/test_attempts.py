"""The table of what is tried to come to a sweep: its order, and what a refusal tells of it."""

import pytest

import cadsweep as cs
from cadsweep.pipeline import attempts
from cadsweep.pipeline.attempts import ATTEMPTS, Attempt, open_and_find
from cadsweep.pipeline.changes import Opened

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


@pytest.fixture(scope="module")
def tetrahedron():
    points = [cq.Vector(*p) for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))]
    corners = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    faces = [cq.Face.makeFromWires(cq.Wire.makePolygon([points[i] for i in three], close=True)) for three in corners]
    return cs.load(cq.Solid.makeSolid(cq.Shell.makeShell(faces)))


def test_every_attempt_has_a_name_of_its_own_and_the_part_as_it_is_comes_first():
    names = [attempt.name for attempt in ATTEMPTS]
    assert len(set(names)) == len(names)
    assert names[0] == "as it is"
    assert all(name.startswith("with ") for name in names[1:])


def test_a_refusal_tells_of_every_attempt(tetrahedron, monkeypatch):
    def refuse(so_far):
        assert so_far.found is None
        raise cs.NotSweepableError("that does not help", reasons=["a reason of its own"])

    row = Attempt(name="with a wish", when=lambda so_far: so_far.found is None, make=refuse)
    monkeypatch.setattr(attempts, "ATTEMPTS", (*ATTEMPTS, row))
    with pytest.raises(cs.NotSweepableError) as caught:
        open_and_find(tetrahedron, None, None)
    (solid,) = tetrahedron.solids
    assert [r.startswith(f.label()) for r, f in zip(caught.value.reasons, solid.faces, strict=False)] == [True] * 4
    assert caught.value.reasons[4:] == ("with a wish: that does not help",)


def test_the_best_of_what_was_made_counts_and_a_row_that_settles_ends_the_search(monkeypatch):
    part = cs.load(cq.Workplane().box(1, 2, 3))
    _, sweeps = open_and_find(part, None, None)
    assert len(sweeps) > 1
    worse = Opened(part, sweeps[::-1])
    asked = []

    def row(name, found, *, settles=False):
        return Attempt(name=name, when=lambda s: asked.append(name) is None, make=lambda s: found, settles=settles)

    rows = (row("poor", worse), row("good", Opened(part, sweeps)), row("none", None), row("poor again", worse))
    monkeypatch.setattr(attempts, "ATTEMPTS", rows)
    assert open_and_find(part, None, None)[1] is sweeps or worse.score == sweeps[0].score
    assert asked == ["poor", "good", "none", "poor again"]
    asked.clear()
    monkeypatch.setattr(attempts, "ATTEMPTS", (row("first", worse, settles=True), *rows))
    assert open_and_find(part, None, None)[1] is worse.sweeps
    assert asked == ["first"]


def test_what_the_user_named_is_taken_as_it_is():
    part = cs.load(cq.Workplane().box(4, 3, 1))
    for face in part.solids[0].faces:
        opened, sweeps = open_and_find(part, face.id, None)
        assert opened is part
        assert sweeps[0].source == (face.id,)


def test_a_shelled_vase_is_swept_across_its_wall_though_it_has_a_poor_sweep_along_its_axis():
    """From its inside to its outside, along the rim, which is divided for that."""
    outline = cq.Workplane("XZ").lineTo(20, 0).spline([(30, 25), (18, 50), (24, 70)], includeCurrent=True)
    vase = outline.lineTo(0, 70).close().revolve(360, (0, 0, 0), (0, 1, 0)).faces(">Z").shell(-2)
    mesh = cs.sweep_mesh(vase)
    assert mesh.record.way == "sweep"
    assert "sweep: with plane faces around a hole divided" in mesh.record.rows
    assert mesh.info["quality"].min_scaled_jacobian > 0.5
