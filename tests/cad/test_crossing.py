"""A solid that runs into itself is known by its faces, where OpenCASCADE's own check passes it."""

import numpy as np
import pytest

cq = pytest.importorskip("cadquery")

import cadsweep as cs  # noqa: E402
from cadsweep.cad import cut_ring, find_crossing, find_touching, load  # noqa: E402
from cadsweep.options import SweepOptions  # noqa: E402
from cadsweep.pipeline import candidates, routes  # noqa: E402
from cadsweep.pipeline.remedies import proposing  # noqa: E402

pytestmark = pytest.mark.cad


def ring(*, shift=0.0):
    """A ring whose section, a bow of two arcs 1 apart, is pinched where its arcs are shifted by more."""
    section = (
        cq.Workplane("XZ")
        .moveTo(20, 0)
        .threePointArc((24, 5), (20, 10))
        .lineTo(21, 10)
        .threePointArc((25 - shift, 5), (21, 0))
        .close()
    )
    return section.revolve(360, (0, 0), (0, 1))


@pytest.mark.parametrize("shape", [ring, lambda: cq.Workplane().box(1, 2, 3), lambda: cq.Workplane().sphere(2)])
def test_a_sound_solid_has_no_crossing(shape):
    assert find_crossing(load(shape()).solids[0]) is None


def test_the_caps_of_a_ring_that_was_cut_open_may_coincide():
    (solid,) = cut_ring(load(ring())).solids
    caps = [face.id for face in solid.faces if face.kind == "plane" and abs(face.normal[2]) < 0.5]
    assert find_crossing(solid) == tuple(caps)
    assert find_crossing(solid, coincident=caps) is None


def test_a_solid_that_runs_into_itself_is_refused_with_the_faces_that_cross():
    crossed = ring(shift=2.0)
    assert crossed.val().isValid()  # by OpenCASCADE's word
    (solid,) = load(crossed).solids
    first, second = find_crossing(solid)
    assert {solid.faces[first].kind, solid.faces[second].kind} == {"torus"}
    with pytest.raises(cs.CadError, match="cross each other"):
        cs.sweep_mesh(crossed, size=1.0)


@pytest.mark.parametrize(
    ("pair", "said"), [((0, 0), "{0}, which crosses itself"), ((0, 1), "{0} and {1}, which cross each other")]
)
def test_a_face_that_crosses_itself_is_named_once(pair, said, monkeypatch):
    (sweep, *_) = cs.find_sweeps(cq.Workplane().box(1, 2, 3))
    monkeypatch.setattr(candidates.cad, "find_crossing", lambda solid, coincident: pair)
    labels = [sweep.solid.faces[f].label() for f in (0, 1)]
    assert said.format(*labels) in str(candidates.explained(sweep, cs.CadSweepError("no mesh")))


def test_a_loft_that_swings_through_its_own_cap_is_refused_with_both_faces():
    bottle = cq.Workplane()
    for radius, step in ((8, 10), (10, 15), (4, 7), (4.5, 0)):
        bottle = bottle.circle(radius).workplane(offset=step) if step else bottle.circle(radius)
    with pytest.raises(cs.CadError, match=r"(?s)runs into itself.*revolution .* and .*plane .* cross each other"):
        cs.sweep_mesh(bottle.loft(), decompose=False)


def bored_twice(*, wall):
    """A block with a bore of radius 5 along y, and one of radius 2 along x above it."""
    along, across = cq.Workplane("XZ", (0, 20, 0)).circle(5), cq.Workplane("YZ", (-20, 0, 7 + wall)).circle(2)
    return cq.Workplane().box(40, 40, 30).cut(along.extrude(40)).cut(across.extrude(40))


def test_faces_that_touch_are_named_with_the_place():
    (solid,) = load(bored_twice(wall=0.0)).solids
    first, second, place = find_touching(solid)
    assert place == pytest.approx([0, 0, 5], abs=0.01)  # along tangent faces, to the root of what they touch to
    said = str(candidates.touching_of(solid, cs.NotSweepableError("no sweep")))
    assert all(solid.faces[f].label() in said for f in (first, second))


def test_no_cuts_are_looked_for_where_faces_touch(monkeypatch):
    def search(*_args):
        pytest.fail("a search for cuts that cannot find any")

    monkeypatch.setitem(routes.WAYS, routes.CELLS, search)
    with pytest.raises(cs.CadError, match="touch at"):
        cs.sweep_mesh(bored_twice(wall=0.0))


@pytest.mark.parametrize("wall", [0.1, -1.0])
def test_faces_that_keep_apart_or_cross_do_not_touch(wall):
    (solid,) = load(bored_twice(wall=wall)).solids
    assert find_touching(solid) is None
    assert candidates.touching_of(solid, cs.NotSweepableError("no sweep")) is None


def test_faces_whose_nearest_points_opencascade_does_not_find_are_passed_over():
    """Of the rounding and the keyway's floor it throws."""
    sleeve = cq.Workplane().circle(14).extrude(40).circle(7).cutThruAll()
    sleeve = sleeve.faces("<Z").edges(cq.selectors.RadiusNthSelector(-1)).fillet(2)
    keyway = cq.Workplane(cq.Plane((12, 0, 20), (0, 0, 1), (1, 0, 0))).slot2D(36, 2).extrude(9)
    assert find_touching(load(sleeve.cut(keyway)).solids[0]) is None


def test_bores_that_meet_in_a_point_are_told_by_their_faces():
    block = cq.Workplane().box(20, 20, 10, centered=(True, True, False))
    bores = [cq.Workplane("XY", (x, 0, z)).circle(3).extrude(5) for x, z in ((-3, 5), (3, 0))]
    solid = load(block.cut(bores[0]).cut(bores[1])).solids[0]
    first, second, place = find_touching(solid)
    assert place.tolist() == pytest.approx([0.0, 0.0, 5.0], abs=1e-9)
    at = {v for v, own in enumerate(solid.vertices) if np.allclose(own, place)}
    meeting = {face.id for face in solid.faces if at & corners(solid, face)}
    assert {first, second} <= meeting
    assert not any({first, second} == set(edge.faces) for edge in solid.edges)
    assert "touch at (0, 0, 5)" in str(candidates.touching_of(solid, cs.NotSweepableError("no sweep")))


def corners(solid, face):
    return {v for e in face.edges for v in (solid.edges[e].start, solid.edges[e].end)}


@pytest.mark.parametrize(("above", "is_pointed"), [(0.0, True), (0.5, False)])
def test_a_face_that_runs_out_to_a_point_is_told_with_the_place(above, is_pointed):
    """The wall of a blind hole, where the round end of a slot goes out of it along its floor."""
    slot = cq.Workplane("YZ", (-20, 0, 0)).center(4, above + 6).slot2D(12, 4, 90).extrude(40)
    block = cq.Workplane().box(40, 40, 30).cut(cq.Workplane().circle(6).extrude(15)).cut(slot)
    refused = cs.NotSweepableError("no sweep", where="a face")
    said = str(proposing(load(block), SweepOptions(), refused, routes._mesh_plainly))
    assert "no sweep" in said
    assert ("runs out to a point at" in said) == is_pointed
    # On the floor, and on the hole's wall above the slot's middle line.
    assert (f"{20**0.5:.4g}, 4, 0" in said.replace("-", "")) == is_pointed
