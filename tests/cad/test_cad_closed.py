"""Closed sweeps along any curve, cut open: the same solid with two caps in one place, or nothing."""

import math

import numpy as np
import pytest

cq = pytest.importorskip("cadquery")

from OCP.BRep import BRep_Builder, BRep_Tool  # noqa: E402
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert  # noqa: E402
from OCP.BRepTools import BRepTools  # noqa: E402
from OCP.Geom import Geom_BSplineSurface  # noqa: E402
from OCP.gp import gp_Vec2d  # noqa: E402
from OCP.TopAbs import TopAbs_Orientation  # noqa: E402

import cadsweep as cs  # noqa: E402
from cadsweep.cad import cut_closed, load  # noqa: E402
from cadsweep.cad.heal.divide import divide_closed, is_divided  # noqa: E402
from cadsweep.cad.heal.shared_surfaces import change_surface  # noqa: E402
from cadsweep.cad.heal.tracing import Traced  # noqa: E402
from cadsweep.cad.heal.turns import gather_turns  # noqa: E402
from cadsweep.cad.heal.validate import faults, is_closed  # noqa: E402
from cadsweep.cad.shapes import EDGE, FACE, explore, subshapes  # noqa: E402
from cadsweep.recognition.find import search_sweeps  # noqa: E402

pytestmark = pytest.mark.cad


def racetrack(half=4.0, radius=6.0):
    return (
        cq.Workplane()
        .moveTo(0, -radius)
        .lineTo(half, -radius)
        .threePointArc((half + radius, 0), (half, radius))
        .lineTo(-half, radius)
        .threePointArc((-half - radius, 0), (-half, -radius))
        .close()
    )


def loop():
    """A smooth closed curve that starts at (8, 0, 0) along y."""
    turns = np.linspace(0, 2 * math.pi, 9)[:-1]
    points = [cq.Vector(8 * math.cos(t), 5 * math.sin(t), 0) for t in turns]
    return cq.Workplane(cq.Edge.makeSpline(points, periodic=True))


RINGS = {
    "hollow racetrack": lambda: cq.Workplane("YZ", origin=(0, -6, 0)).circle(2).circle(1.2).sweep(racetrack()),
    "thin band": lambda: cq.Workplane("YZ", origin=(0, -6, 0)).rect(0.1, 3).sweep(racetrack()),
    "a slot nearly closed": lambda: cq.Workplane("YZ", origin=(0, -1.1, 0)).rect(2, 2).sweep(racetrack(6, 1.1)),
    "spline": lambda: cq.Workplane("XZ", origin=(8, 0, 0)).rect(2, 1).sweep(loop()),
    "round on a spline": lambda: cq.Workplane("XZ", origin=(8, 0, 0)).circle(1).sweep(loop()),
    "tilted and far away": lambda: RINGS["thin band"]().rotate((0, 0, 0), (1, 2, 3), 40).translate((500, 0, -300)),
}


@pytest.mark.parametrize("name", RINGS)
def test_a_closed_sweep_is_cut_to_two_coincident_caps(name):
    ring = load(RINGS[name]())
    (before,) = ring.solids
    opened = next(cut_closed(ring))
    (solid,) = opened.solids
    assert solid.volume == pytest.approx(before.volume, rel=1e-6)
    assert {face.key for face in solid.faces if face.key} == {face.key for face in before.faces}
    first, second = ([solid.faces[f] for f in side] for side in solid.opened)
    assert sum(face.area for face in first) == pytest.approx(sum(face.area for face in second), rel=1e-9)
    for face in first:
        twin = min(second, key=lambda other: float(np.linalg.norm(other.center - face.center)))
        assert twin.center == pytest.approx(face.center, abs=1e-6 * solid.size)
        assert twin.normal == pytest.approx(-face.normal, abs=1e-6)
        assert not set(face.edges) & set(twin.edges)
    uses = np.bincount([e for face in solid.faces for e in face.edges], minlength=len(solid.edges))
    assert (uses == 2).all()


@pytest.mark.parametrize("name", ["hollow racetrack", "round on a spline"])
def test_what_has_no_other_caps_is_meshed_as_a_ring_that_closes(name):
    mesh = cs.sweep_mesh(RINGS[name](), size=2.0, allow_coarse=True)
    assert mesh.quality().valid
    assert mesh.structure.periodic
    assert not [boundary for boundary in mesh.boundaries if boundary.startswith(("source", "target"))]


@pytest.mark.parametrize(
    "shape",
    [
        lambda: cq.Workplane().box(1, 2, 3),
        lambda: cq.Workplane().sphere(1),
        lambda: cq.Workplane().cylinder(3, 1),
        lambda: cq.Workplane().box(4, 4, 1).cut(cq.Workplane().box(4, 1, 1)),  # two bars side by side
        lambda: cq.Workplane().box(2, 2, 2).faces(">Z").workplane().circle(0.5).extrude(2),
    ],
)
def test_what_does_not_close_is_not_cut(shape):
    assert not list(cut_closed(load(shape())))


def test_a_ring_with_a_lug_is_no_closed_sweep():
    lug = cq.Workplane(origin=(0, -8, 0)).box(1, 3, 1)
    part = cq.Workplane("YZ", origin=(0, -6, 0)).rect(2, 2).sweep(racetrack()).union(lug)
    opened = next(cut_closed(load(part)))
    assert opened.solids[0].volume == pytest.approx(load(part).solids[0].volume, rel=1e-6)
    assert not [sweep for sweep in search_sweeps(opened.solids[0]).sweeps if sweep.closed]


def test_a_ball_from_a_file_is_parted_as_one_from_a_script(tmp_path):
    """Its face has a vertex for an outline and a seam of OpenCASCADE's: halves of it have edges of one range."""
    path = str(tmp_path / "ball.step")
    cq.exporters.export(cq.Workplane().sphere(7), path)
    cells = cs.decompose(path).solids
    assert [cell.volume for cell in cells] == pytest.approx([math.pi * 7**3 / 6] * 8, rel=1e-6)


@pytest.mark.parametrize(
    "solid",
    [
        cq.Workplane().cylinder(3, 1),
        cq.Workplane().sphere(2),
        cq.Workplane().rect(4, 3).extrude(1).faces(">Z").workplane().hole(1),
        cq.Workplane(cq.Solid.makeCone(2, 0, 3)),
    ],
    ids=["cylinder", "sphere", "hole", "cone"],
)
def test_seams_are_found_before_they_are_divided_and_not_after(solid):
    shape = solid.val().wrapped
    assert not is_divided(shape)
    traced = Traced(shape)
    divide_closed(traced)
    assert is_divided(traced.shape)
    assert is_divided(cq.Workplane().box(1, 2, 3).val().wrapped)


def test_a_face_that_two_solids_share_is_not_closed():
    # A compound holds it twice, once from either side, and a cylinder beside it is closed as ever.
    from OCP.BOPAlgo import BOPAlgo_Builder

    builder = BOPAlgo_Builder()
    for x in (0.0, 1.0):
        builder.AddArgument(cq.Workplane().box(1, 1, 1).translate((x, 0, 0)).val().wrapped)
    builder.Perform()
    pair = cq.Shape.cast(builder.Shape())
    assert len(pair.Faces()) == 11, "six faces each, one of them in common"
    assert is_divided(pair.wrapped)
    beside = cq.Workplane().circle(1).extrude(1).translate((5, 0, 0)).val()
    assert not is_divided(cq.Compound.makeCompound([pair, beside]).wrapped)


def test_rims_a_turn_apart_in_the_parameters_are_brought_within_one():
    """Some programs write them so: every point is right, but whatever divides the face takes its middle for its end."""
    profile = cq.Workplane("XZ").lineTo(3, 0).spline([(4, 2), (3, 4)], includeCurrent=True).lineTo(0, 4).close()
    vase = profile.revolve(360, (0, 0), (0, 1)).val()
    (face,) = (f for f in subshapes(vase.wrapped, FACE) if BRep_Tool.Surface_s(f).IsUPeriodic())
    volume = vase.Volume()
    builder, back = BRep_Builder(), gp_Vec2d(-2 * math.pi, 0)
    seams = []
    for use in explore(face, EDGE):
        curve = BRep_Tool.CurveOnSurface_s(use, face, 0.0, 1.0)
        if BRep_Tool.IsClosed_s(use, face):
            seams.append((use, curve))
        elif curve.Value(0.0).Y() > 1.0:
            builder.UpdateEdge(use, curve.Translated(back), face, 1e-7)
    seams.sort(key=lambda own: own[0].Orientation() == TopAbs_Orientation.TopAbs_REVERSED)
    moved = [curve if curve.Value(0.0).X() > 1.0 else curve.Translated(back) for _, curve in seams]
    builder.UpdateEdge(seams[0][0], *moved, face, 1e-7)
    assert np.ptp(BRepTools.UVBounds_s(face)[:2]) == pytest.approx(4 * math.pi)
    traced = Traced(vase.wrapped)
    gather_turns(traced)
    (within,) = (f for f in subshapes(traced.shape, FACE) if BRep_Tool.Surface_s(f).IsUPeriodic())
    assert BRepTools.UVBounds_s(within)[:2] == pytest.approx((0.0, 2 * math.pi))
    assert not faults(traced.shape)
    assert cq.Shape.cast(traced.shape).Volume() == pytest.approx(volume)


@pytest.mark.parametrize("knot", [2, 3])
def test_a_spline_of_one_turn_that_begins_elsewhere_than_its_face_is_divided(knot):
    """As an old program wrote the fillets of a capacitor: of what is beyond the end, dividing made other points."""
    turned = cq.Workplane("XZ").lineTo(9, 0).threePointArc((12, 6), (8, 20)).lineTo(0, 20).close()
    solid = turned.revolve(360, (0, 0, 0), (0, 1, 0)).val()
    splines = BRepBuilderAPI_NurbsConvert(solid.wrapped, True).Shape()
    n_moved = 0
    for face in subshapes(splines, FACE):
        surface = BRep_Tool.Surface_s(face)
        if isinstance(surface, Geom_BSplineSurface) and surface.IsUPeriodic():
            moved = surface.Copy()
            moved.SetUOrigin(knot)
            change_surface(face, moved)
            n_moved += 1
    assert n_moved
    traced = Traced(splines)
    gather_turns(traced)
    for face in subshapes(traced.shape, FACE):
        surface = BRep_Tool.Surface_s(face)
        if surface.IsUPeriodic():
            assert surface.Bounds()[:2] == pytest.approx(BRepTools.UVBounds_s(face)[:2], abs=1e-6)
    part = load(cq.Workplane(cq.Shape.cast(splines)))
    assert part.solids[0].volume * part.scale**3 == pytest.approx(solid.Volume(), rel=1e-6)


@pytest.mark.parametrize("through_file", [False, True])
def test_a_seam_that_goes_on_at_another_angle_half_way_is_left_as_it_is(tmp_path, through_file):
    """Two cylinders about one line, their seams half a turn apart, made one: one of them is open for a third."""
    arms = [cq.Workplane("YZ").circle(8).extrude(40).rotate((0, 0, 0), (0, 0, 1), turn) for turn in (0, 180, 90)]
    tee = arms[0].union(arms[1]).union(arms[2])
    traced = Traced(tee.val().wrapped)
    widest = max(np.ptp(BRepTools.UVBounds_s(face)[:2]) for face in subshapes(traced.shape, FACE))
    assert widest > 2 * math.pi + 1.0
    gather_turns(traced)
    assert traced.shape.IsSame(tee.val().wrapped)
    cq.exporters.export(tee, str(tmp_path / "tee.step"))
    part = load(tmp_path / "tee.step" if through_file else tee)
    assert part.solids[0].volume * part.scale**3 == pytest.approx(tee.val().Volume(), rel=1e-6)


def test_a_solid_without_one_of_its_faces_is_not_closed():
    box = cq.Workplane().box(1, 2, 3).val()
    assert is_closed(box.wrapped)
    assert not is_closed(cq.Shell.makeShell(box.Faces()[1:]).wrapped)
