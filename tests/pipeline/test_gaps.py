"""Models whose faces miss each other: valid to OpenCASCADE, and known only as well as their gaps allow."""

from dataclasses import replace

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.brep import volume_doubt
from cadsweep.cad import cut_ring
from cadsweep.quality import check_mesh

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


def plate():
    return cq.Workplane().box(3, 2, 1)


def blade():
    """A thin profile of two splines, slightly tapered."""
    nose, tail = (0.0, 0.0), (10.0, 0.3)
    lower, upper = [nose, (4.0, -0.15), tail], [tail, (4.0, 0.6), nose]
    section = cq.Workplane().spline(lower).spline(upper).close()
    return section.extrude(6, taper=0.2)


def disc():
    return cq.Workplane().circle(4).extrude(0.5)


def sewn(model, shift, seed=0):
    """A solid sewn of the model's faces, each moved by `shift` of its size in a direction of its own."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing

    rng = np.random.default_rng(seed)
    solid = model.val()
    length = shift * solid.BoundingBox().DiagonalLength
    sewing = BRepBuilderAPI_Sewing(3.0 * length)
    for face in solid.Faces():
        way = rng.normal(size=3)
        sewing.Add(face.moved(cq.Location(cq.Vector(*(length * way / np.linalg.norm(way))))).wrapped)
    sewing.Perform()
    shell = cq.Shape.cast(sewing.SewedShape())
    assert isinstance(shell, cq.Shell)
    return cq.Shape.cast(BRepBuilderAPI_MakeSolid(shell.wrapped).Solid())


@pytest.mark.parametrize(
    ("model", "shift"), [(plate, 5e-4), (blade, 1e-5), (blade, 2e-4), (disc, 1e-5), (disc, 1e-4), (disc, 5e-4)]
)
def test_a_solid_with_gaps_is_meshed_at_every_size(model, shift):
    part = cs.load(sewn(model(), shift))
    solid = part.solids[0]
    assert max(edge.gap for edge in solid.edges) > 0.1 * shift * solid.size
    for layers, size in ((3, 0.2), (5, 0.1)):
        mesh = cs.sweep_mesh(part, size=size * solid.size, layers=layers, allow_coarse=True)
        assert mesh.info["quality"].valid
        said = any("miss each other" in note for note in mesh.info["notes"])
        assert said == (volume_doubt(solid) > 1e-4 * solid.volume)


@pytest.mark.parametrize("model", [plate, disc])
def test_the_doubt_of_a_volume_contains_that_of_the_model_before_its_faces_were_moved(model):
    whole = cs.load(model()).solids[0]
    assert volume_doubt(whole) < 1e-6 * whole.volume
    for seed in range(3):
        moved = cs.load(sewn(model(), 1e-4, seed)).solids[0]
        # moving the faces changes what is meant by their gaps' order, too
        own = 1e-4 * whole.size * sum(face.area for face in whole.faces)
        assert abs(moved.volume - whole.volume) <= volume_doubt(moved) + own
        assert volume_doubt(moved) <= 4 * own


def test_a_tight_model_is_allowed_nothing_more():
    mesh = cs.sweep_mesh(plate(), size=0.5)
    (reference,) = mesh.origin.references.values()
    assert reference.volume_doubt <= 1e-12
    assert max(reference.area_doubts.values()) <= 1e-12
    assert check_mesh(mesh, cad=reference).valid
    off = replace(reference, volume=reference.volume * (1 + 1e-5))
    assert "the volume is" in " ".join(check_mesh(mesh, cad=off).problems)


def test_a_ring_with_gaps_is_cut_open():
    """A torus between two planes, one of which is off its edges: the section knows nothing of the gap."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing

    ring = cq.Workplane(obj=cq.Solid.makeTorus(20, 6)).intersect(cq.Workplane().box(80, 80, 8)).val()
    sewing = BRepBuilderAPI_Sewing(2e-2)
    for face in ring.Faces():
        sewing.Add(face.moved(cq.Location(cq.Vector(0, 0, 5e-3 * (face.Center().z > 3)))).wrapped)
    sewing.Perform()
    solid = cs.load(cq.Shape.cast(BRepBuilderAPI_MakeSolid(cq.Shape.cast(sewing.SewedShape()).wrapped).Solid()))
    opened = cut_ring(solid)
    change = abs(opened.solids[0].volume / solid.solids[0].volume - 1)
    assert change > 1e-6
    assert change < volume_doubt(solid.solids[0]) / solid.solids[0].volume


def test_a_gap_is_measured_where_it_is():
    # One of the six faces lifted off: the four edges around it have the gap, on that face or on the other.
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_Sewing

    box = plate().val()
    top = max(box.Faces(), key=lambda face: face.Center().z)
    sewing = BRepBuilderAPI_Sewing(1e-2)
    for face in box.Faces():
        sewing.Add((face.moved(cq.Location(cq.Vector(0, 0, 1e-3))) if face.isSame(top) else face).wrapped)
    sewing.Perform()
    shell = cq.Shape.cast(sewing.SewedShape())
    solid = cs.load(cq.Shape.cast(BRepBuilderAPI_MakeSolid(shell.wrapped).Solid())).solids[0]
    around = [edge for edge in solid.edges if abs(edge.midpoint[2] - 0.5) < 2e-3]
    assert len(around) == 4
    for edge in solid.edges:
        assert edge.gap <= 1.001e-3
        if edge not in around and abs(edge.tangents[0][2]) < 0.5:
            assert edge.gap < 1e-9
    assert volume_doubt(solid) <= 1.001e-3 * sum(face.area for face in solid.faces)
