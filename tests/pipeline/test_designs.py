"""Solids meshed by their designs: on the model's own faces, each under its name."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.blends.borders import BORDERS
from cadsweep.blends.sheets import SHEET
from cadsweep.errors import CadError, SurfaceMeshError
from cadsweep.options import SweepOptions
from cadsweep.pipeline import designs, expand, write_factors
from cadsweep.pipeline.run import Run
from cadsweep.quality import quad_areas

pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad

DESIGN = "way: design"


def bracket():
    """An L of legs 20, 4 thick and 12 wide, its inner corner rounded by 3, with a hole in its foot."""
    shape = cq.Workplane().polyline([(0, 0), (20, 0), (20, 4), (4, 4), (4, 20), (0, 20)]).close().extrude(12)
    shape = shape.edges("|Z").edges(cq.NearestToPointSelector((4, 4, 6))).fillet(3)
    return shape.faces("<Y").workplane(centerOption="CenterOfMass").hole(4)


def lever():
    """An arm between two bosses, thicker than it, with rounded feet that meet in mitres over the arm's sharp edges."""
    both = [(-20, 0), (20, 0)]
    shape = (
        cq.Workplane().box(40, 8, 4).union(cq.Workplane().workplane(offset=-6).pushPoints(both).circle(7).extrude(12))
    )
    shape = shape.cut(cq.Workplane().workplane(offset=-6).pushPoints(both).circle(3).extrude(12))
    feet = [e for e in shape.edges().vals() if e.geomType() == "CIRCLE" and abs(e.Center().z) == pytest.approx(2)]
    feet += [e for e in shape.edges("|Z").vals() if abs(e.Center().z) < 1e-6 and abs(e.Center().y) == pytest.approx(4)]
    return cq.Workplane(shape.val().fillet(0.8, feet))


@pytest.mark.parametrize(
    ("shape", "size", "least", "volume"),
    [(bracket, 1.0, 0.6, 0.002), (lever, 1.5, 0.4, 0.03)],
    ids=["bracket", "lever"],
)
def test_a_mesh_of_the_design_lies_on_the_model_and_is_better(shape, size, least, volume):
    model = shape()
    mesh = cs.sweep_mesh(model, size=size)
    report = mesh.info["quality"]
    assert DESIGN in mesh.info["rows"]
    assert any("by its design" in note for note in mesh.info["notes"])
    assert report.valid
    assert report.min_scaled_jacobian > least
    assert report.volume == pytest.approx(model.val().Volume(), rel=volume)
    # Every node of the boundary is on the model, by OpenCASCADE's own word.
    nodes = np.unique(np.concatenate([quads.ravel() for quads in mesh.boundaries.values()]))
    skin = cq.Compound.makeCompound(model.faces().vals())
    away = [skin.distance(cq.Vertex.makeVertex(*point)) for point in mesh.points[nodes[:: len(nodes) // 40]]]
    assert max(away) < 1e-5


def test_a_blend_has_the_quads_whose_middles_are_on_it_and_switched_off_it_is_a_sweep_of_the_model():
    shape = bracket()
    rounding = shape.faces(cq.NearestToPointSelector((5, 5, 6))).val()
    part = cs.load(shape)
    face = next(
        f
        for f in part.solids[0].faces
        if f.kind == "cylinder" and f.area * part.scale**2 == pytest.approx(rounding.Area())
    )
    mesh = cs.sweep_mesh(shape, size=1.0, names={"rounding": f"face {face.id}", "floor": "<Y"})
    quads = mesh.boundaries["rounding"]
    middles = mesh.points[quads].mean(axis=1)
    # Around (7, 7), radius 3: a chord of a quad is a little nearer to the middle.
    radii = np.linalg.norm(middles[:, :2] - 7.0, axis=1)
    assert (abs(radii - 3.0) < 0.1).all()
    assert (middles[:, :2] < 7.0).all()
    others = np.concatenate([own for name, own in mesh.boundaries.items() if name != "rounding"])
    beyond = mesh.points[others].mean(axis=1)
    inside = (abs(np.linalg.norm(beyond[:, :2] - 7.0, axis=1) - 3.0) < 1e-3) & (beyond[:, :2] < 6.99).all(axis=1)
    assert not (inside & (beyond[:, 2] > 0.1) & (beyond[:, 2] < 11.9)).any()
    assert np.ptp(mesh.points[mesh.boundaries["floor"]][..., 1]) < 1e-9
    plain = cs.sweep_mesh(shape, size=1.0, without=[DESIGN])
    assert DESIGN not in plain.info["rows"]
    assert plain.info["quality"].min_scaled_jacobian < mesh.info["quality"].min_scaled_jacobian


@pytest.mark.parametrize("size", [1.2, 0.9])
def test_lines_of_the_mesh_follow_borders_of_blends_so_that_these_have_their_areas(size):
    model = cq.Workplane().box(20, 16, 12).edges().fillet(3)
    part = cs.load(model)
    names = {f"f{face.id}": f"face {face.id}" for face in part.solids[0].faces}
    areas = np.array([face.area for face in part.solids[0].faces]) * part.scale**2

    def made(**options):
        mesh = cs.sweep_mesh(model, size=size, names=names, **options)
        own = [quad_areas(mesh.points, mesh.boundaries[name]).sum() for name in names]
        return mesh, abs(np.array(own) / areas - 1.0).max()

    followed, off = made()
    jagged, off_jagged = made(without=[BORDERS])
    assert BORDERS in followed.info["rows"]
    assert BORDERS not in jagged.info["rows"]
    assert np.array_equal(followed.hexes, jagged.hexes)
    assert off < 0.05 < off_jagged
    alike = cs.sweep_mesh(model.translate((1, 2, 3)), like=followed)
    assert alike.origin.design.choice.borders == followed.origin.design.choice.borders != ()
    worst = jagged.info["quality"].min_scaled_jacobian
    assert followed.info["quality"].min_scaled_jacobian > min(0.4, worst) - 0.02


def test_a_carried_mesh_is_refined_and_raised_to_order_2_on_the_model():
    mesh = cs.sweep_mesh(bracket(), size=2.0)
    assert DESIGN in mesh.info["rows"]
    fine = cs.refine(mesh, 1)
    assert fine.info["quality"].valid
    assert fine.n_hexes == 8 * mesh.n_hexes
    volume = bracket().val().Volume()
    assert abs(fine.info["quality"].volume / volume - 1) < abs(mesh.info["quality"].volume / volume - 1) / 2
    curved = cs.sweep_mesh(bracket(), size=2.0, order=2)
    assert DESIGN in curved.info["rows"]
    assert curved.info["quality"].valid
    assert abs(curved.info["quality"].volume / volume - 1) < 1e-3


def rounded_box():
    return cq.Workplane().box(20, 16, 12).edges().fillet(4)


def test_a_sheet_under_a_smooth_skin_keeps_its_hexahedra_from_being_flat_however_fine_they_are():
    worst = {}
    for share in (2, 4):
        mesh = cs.sweep_mesh(rounded_box(), size=4 / share)
        assert SHEET in mesh.info["rows"]
        # No more is lost than chords lose that are 1.3 times as long as was asked for.
        angle = 2 * np.arcsin(1.3 / 2 / share)
        lost = 1 - np.sin(angle) / angle
        edges, corners = np.pi * 4**2 * (12 + 8 + 4), 4 / 3 * np.pi * 4**3
        assert 0 < rounded_box().val().Volume() - mesh.info["quality"].volume < lost * (edges + 2 * corners)
        worst[share] = mesh.info["quality"].min_scaled_jacobian
    plain = cs.sweep_mesh(rounded_box(), size=1, without=[SHEET])
    assert min(worst.values()) > 0.45 > plain.info["quality"].min_scaled_jacobian
    curved = cs.sweep_mesh(rounded_box(), size=2, order=2)
    assert curved.info["quality"].valid
    assert SHEET in curved.info["rows"]


def test_wishes_about_faces_are_left_to_the_design_where_the_model_has_no_mesh_of_its_own():
    mesh = cs.sweep_mesh(bracket(), size=1.0, sizes={"<Z": 0.8})
    assert DESIGN not in mesh.info["rows"]


def ribbed():
    """A cast angle with a rib, its inner edges rounded by 3: no sweep, no columns, no cuts."""
    shape = cq.Workplane().polyline([(0, 0), (60, 0), (60, 8), (8, 8), (8, 50), (0, 50)]).close().extrude(25, both=True)
    rib = cq.Workplane().polyline([(8, 8), (38, 8), (8, 38)]).close().extrude(4, both=True)
    shape = shape.union(rib)
    near = [e for e in shape.edges("%LINE").vals() if 8 < max(e.Center().x, e.Center().y) < 40]
    inside = [e for e in near if min(e.Center().x, e.Center().y) < 8 + 1e-6 and abs(e.Center().z) < 24]
    shape = cq.Workplane(shape.val().fillet(3, inside))
    return shape.faces("<Y").workplane(centerOption="CenterOfMass").pushPoints([(-16, -14), (-16, 14)]).hole(9)


def on_plane(mesh, axis, value):
    """Segments of the mesh's boundary in a plane, and their lengths."""
    quads = np.concatenate([own for own in mesh.boundaries.values() if len(own)])
    own = quads[(abs(mesh.points[quads][:, :, axis] - value) < 1e-6).all(axis=1)]
    ends = np.stack([own, np.roll(own, -1, axis=1)], axis=2).reshape(-1, 2)
    return own, np.linalg.norm(np.subtract(*mesh.points[ends.T]), axis=1)


def test_what_is_asked_of_faces_and_edges_of_the_model_holds_on_its_design():
    model = ribbed()
    plain = cs.sweep_mesh(model, size=4.0)
    assert DESIGN in plain.info["rows"]
    fine = cs.sweep_mesh(model, size=4.0, sizes={"<Z": 1.5})
    assert np.median(on_plane(fine, 2, -25.0)[1]) < 2.0 < np.median(on_plane(plain, 2, -25.0)[1])
    counted = cs.sweep_mesh(model, size=4.0, counts={"edges:|Z and >X and <Y": 17})
    edge = (abs(counted.points[:, 0] - 60) < 1e-6) & (abs(counted.points[:, 1]) < 1e-6)
    assert np.count_nonzero(edge) == 18
    near = cs.sweep_mesh(model, size=4.0, local_sizes=[{"at": (60, 0, -25), "radius": 3, "size": 0.8}])
    assert near.n_hexes > plain.n_hexes
    layered = cs.sweep_mesh(model, size=4.0, wall_layers={"<Y": {"first": 0.2, "growth": 1.3, "n": 3}})
    bottom = np.unique(on_plane(layered, 1, 0.0)[0])
    around = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]])
    ends = np.unique(np.sort(layered.hexes[:, around].reshape(-1, 2), axis=1), axis=0)
    leaving = ends[np.isin(ends, bottom).sum(axis=1) == 1]
    assert np.median(np.linalg.norm(np.subtract(*layered.points[leaving.T]), axis=1)) == pytest.approx(0.2, rel=0.05)
    for mesh in (fine, counted, near, layered):
        assert DESIGN in mesh.info["rows"]
        assert mesh.info["quality"].valid


def test_sharp_edges_within_a_patch_stay_sharp_where_a_mesh_is_refined():
    mesh = cs.sweep_mesh(ribbed(), size=4.0)
    fine = cs.refine(mesh)
    assert fine.info["quality"].valid
    # The rim of the rib's slope, from the one foot's rounding to the other's.
    rim = abs(fine.points[:, :2].sum(axis=1) - 46) + abs(abs(fine.points[:, 2]) - 4) < 1e-6
    coarse = abs(mesh.points[:, :2].sum(axis=1) - 46) + abs(abs(mesh.points[:, 2]) - 4) < 1e-6
    assert np.count_nonzero(rim) >= 2 * np.count_nonzero(coarse) - 2 > 4


def test_a_tolerance_is_kept_on_blends_by_finer_quads_or_a_note_says_by_how_much_it_is_missed():
    mesh = cs.sweep_mesh(lever(), size=2.0, tolerance=0.04)
    missed = [note for note in mesh.info["notes"] if "off its faces" in note]
    assert DESIGN in mesh.info["rows"]
    assert mesh.info["distance"] < 0.5 * cs.sweep_mesh(lever(), size=2.0).info["distance"]
    assert bool(missed) == (mesh.info["distance"] > 0.04)


def wide_bracket(by=0.0):
    """The bracket, its foot longer."""
    shape = cq.Workplane().polyline([(0, 0), (20 + by, 0), (20 + by, 4), (4, 4), (4, 20), (0, 20)]).close().extrude(12)
    shape = shape.edges("|Z").edges(cq.NearestToPointSelector((4, 4, 6))).fillet(3)
    return shape.faces("<Y").workplane(centerOption="CenterOfMass").hole(4)


def test_another_part_is_meshed_like_a_mesh_by_the_design(tmp_path):
    factors = tmp_path / "bracket.sweep.npz"
    made = write_factors(bracket(), factors, size=2.0)
    assert DESIGN in made.info["rows"]
    np.testing.assert_array_equal(expand(factors).points, made.points)
    for like in (made, factors):
        other = cs.sweep_mesh(wide_bracket(2.0), like=like)
        assert np.array_equal(other.hexes, made.hexes)
        assert set(other.boundaries) == set(made.boundaries)
        assert other.info["quality"].valid
        assert np.ptp(other.points[:, 0]) == pytest.approx(22)
        np.testing.assert_allclose(cs.sweep_mesh(wide_bracket(), like=like).points, made.points, atol=1e-6)
    with pytest.raises(CadError, match="do not correspond"):
        cs.sweep_mesh(cq.Workplane().box(20, 20, 12), like=made)


def test_a_derivative_of_a_mesh_by_the_design_is_that_of_its_nodes():
    found = cs.sensitivity(wide_bracket, {"by": 1.0}, wrt="by", size=2.0)
    assert DESIGN in found.mesh.info["rows"]
    end = found.mesh.points[:, 0] > 20.99
    np.testing.assert_allclose(found.derivative[end, 0], 1.0, atol=1e-6)
    np.testing.assert_allclose(found.derivative[found.mesh.points[:, 0] < 1e-9], 0.0, atol=1e-6)


def test_faces_that_answer_each_other_do_so_on_the_model():
    mesh = cs.sweep_mesh(ribbed(), size=4.0, periodic={"<Z": ">Z"})
    (pairs,) = mesh.periodic.values()
    assert DESIGN in mesh.info["rows"]
    apart = mesh.points[pairs[:, 1]] - mesh.points[pairs[:, 0]]
    np.testing.assert_allclose(apart, np.tile([0.0, 0.0, 50.0], (len(pairs), 1)), atol=1e-9)


def test_a_design_that_cannot_be_carried_is_not_meshed(monkeypatch):
    def refuse(*args):
        raise SurfaceMeshError("the design has an edge that the model has not")

    monkeypatch.setattr(designs, "check_edges", refuse)
    with pytest.raises(SurfaceMeshError, match="that the model has not"):
        designs.mesh_design(cs.load(bracket()), SweepOptions(), Run(on_progress=lambda *args: None), pytest.fail)
