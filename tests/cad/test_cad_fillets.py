"""Roundings of cap edges: divided half way, joined to the cap, and still the same solid with the same ids and names."""

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs
from cadsweep import cad, recognition
from cadsweep.pipeline.attempts import open_and_find

pytestmark = pytest.mark.cad


def rounded_box():
    """A box with a rounded top edge."""
    return cq.Workplane().box(20, 16, 10).edges(">Z").fillet(2)


def pillow():
    """A box with all edges rounded."""
    return cq.Workplane().box(20, 16, 12).edges().fillet(2)


def disc_with_hole():
    """A disc with rounded rims around a hole with rounded rims."""
    return cq.Workplane().circle(10).circle(4).extrude(5).edges(">Z").fillet(1)


def divided(part):
    """The part with its roundings divided, and the caps that asked for it."""
    sweep = next(s for s in recognition.find_sweeps(part.solids[0]) if recognition.find_roundings(s))
    roundings = recognition.find_roundings(sweep)
    return cad.divide_roundings(part, roundings), roundings


@pytest.mark.parametrize("model", [rounded_box, pillow, disc_with_hole])
def test_ids_areas_and_volume_stay(model):
    part = cs.load(model())
    result, roundings = divided(part)
    old, new = part.solids[0], result.solids[0]
    assert [face.key for face in new.faces] == [face.key for face in old.faces]
    assert np.isclose(sum(f.area for f in new.faces), sum(f.area for f in old.faces), rtol=1e-9)
    assert np.isclose(new.volume, old.volume, rtol=1e-9)
    grown = {plane for plane, _ in roundings}
    for before, after in zip(old.faces, new.faces, strict=True):
        if after.id in grown:
            assert after.area > before.area
        else:
            assert after.area < before.area * (1 + 1e-9)
    # Every edge has two faces that know it, and Euler's formula holds: so the loops are whole.
    uses = np.bincount([e for face in new.faces for e in face.edges], minlength=len(new.edges))
    assert (uses == 2).all()


@pytest.mark.parametrize("model", [rounded_box, pillow, disc_with_hole])
def test_grown_cap_is_the_surface_of_its_members(model):
    part = cs.load(model())
    result, roundings = divided(part)
    old, new = part.solids[0], result.solids[0]
    for plane, _ in roundings:
        cap = new.faces[plane]
        normal = old.faces[plane].normal
        outer = np.concatenate([cap.surface.edge_uv(e, np.linspace(0, 1, 9)) for e in cap.loops[0].edges])
        uv = outer.mean(axis=0) + 0.9 * (outer - outer.mean(axis=0))
        points, normals = cap.surface.evaluate(uv), cap.surface.normals(uv)
        near = np.min([np.abs(face.surface.distance(points)) for face in old.faces], axis=0)
        assert near.max() < 1e-9 * new.size
        # Nowhere does it lean more than half way, and there, at the rim, it is half way.
        assert (normals @ normal).min() > np.cos(np.pi / 4) - 1e-6
        smooth = [e for e in cap.edges if abs(new.edges[e].dihedral - np.pi) < 1e-6]
        assert smooth
        rim = np.concatenate([cap.surface.edge_uv(e, np.linspace(0, 1, 9)) for e in smooth])
        assert np.allclose(cap.surface.normals(rim) @ normal, np.cos(np.pi / 4), atol=1e-6)
        assert np.allclose(cap.surface.evaluate(cap.surface.project(points)), points, atol=1e-9 * new.size)
        # The derivatives are those of the points.
        step = 1e-5 * new.size
        for axis, along in enumerate(cap.surface.derivatives(uv)):
            off = step * np.eye(2)[axis]
            slope = (cap.surface.evaluate(uv + off) - cap.surface.evaluate(uv - off)) / (2 * step)
            assert np.median(np.linalg.norm(slope - along, axis=1)) < 1e-3


@pytest.mark.parametrize("model", [rounded_box, pillow, disc_with_hole])
def test_meshed_better_than_undivided(model):
    part = cs.load(model())
    opened, _ = open_and_find(part, None, None)
    assert opened is not part
    mesh = cs.sweep_mesh(part)
    report = mesh.info["quality"]
    assert report.valid
    assert report.min_scaled_jacobian > 0.2
    assert np.isclose(report.volume, mesh.info["cad_volume"], rtol=0.01)


def test_layers_that_are_thicker_at_a_tangent_cap_are_better_than_even_ones():
    part = cs.load(rounded_box())
    # Two layers or more in the half of the rounding that is 2 pi / 4 long.
    plain = {"size": 0.6, "without": ["way: design"]}
    graded, even = (cs.sweep_mesh(part, bias=bias, **plain).info["quality"] for bias in (None, 1.0))
    assert graded.min_scaled_jacobian > even.min_scaled_jacobian


def test_named_rounding_keeps_its_name_on_both_halves():
    model = rounded_box()
    assembly = cq.Assembly()
    assembly.add(model, name="box")
    for j, face in enumerate(model.faces("%CYLINDER").vals()):
        assembly.addSubshape(face, name=f"round_{j}")
    mesh = cs.sweep_mesh(assembly)
    faces = {name: quads for name, quads in mesh.boundaries.items() if "round" in name}
    assert len(faces) == 4
    for quads in faces.values():
        heights = mesh.points[quads][..., 2]
        # The fillet begins at 3; half way its height is 3 + 2 sin 45 degrees.
        assert heights.min() < 3.01
        assert heights.max() > 3 + 2 * np.sin(np.pi / 4) + 0.1


def test_shallow_chamfer_belongs_to_the_cap():
    shallow = cs.load(cq.Workplane().box(20, 16, 10).edges(">Z").chamfer(0.5, 3))
    (solid,) = shallow.solids
    best = recognition.find_sweeps(solid)[0]
    assert {len(best.source), len(best.target)} == {1, 5}
    steep = cs.load(cq.Workplane().box(20, 16, 10).edges(">Z").chamfer(3, 0.5))
    best = recognition.find_sweeps(steep.solids[0])[0]
    assert {len(best.source), len(best.target)} == {1}


def test_hollow_rounding_is_left_alone():
    # A groove with round corners at its bottom: the rounding bulges inwards.
    part = cs.load(
        cq.Workplane().box(20, 20, 6).faces(">Z").workplane().rect(12, 12).cutThruAll().edges("|Z").fillet(1)
    )
    assert open_and_find(part, None, None)[0] is part
