"""Faces that a file has on splines are read as the planes, cylinders, cones, spheres and tori that they are."""

import numpy as np
import pytest

cq = pytest.importorskip("cadquery")

from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert  # noqa: E402
from OCP.GeomAbs import GeomAbs_Shape  # noqa: E402
from OCP.ShapeCustom import ShapeCustom, ShapeCustom_RestrictionParameters  # noqa: E402

import cadsweep as cs  # noqa: E402
from cadsweep.cad import load  # noqa: E402
from cadsweep.cad.geometry.elementary_fit import fit_elementary  # noqa: E402

pytestmark = pytest.mark.cad


def on_splines(shape):
    """The same shape, all its faces and edges rational splines."""
    return cq.Shape.cast(BRepBuilderAPI_NurbsConvert(shape.val().wrapped, True).Shape())


def approximated(shape, tolerance):
    """The same shape to a tolerance, on splines without weights, as older exchange formats write it."""
    how, smooth = ShapeCustom_RestrictionParameters(), GeomAbs_Shape.GeomAbs_C1
    splines = on_splines(shape).wrapped
    return cq.Shape.cast(
        ShapeCustom.BSplineRestriction_s(splines, tolerance, tolerance, 8, 60, smooth, smooth, True, True, how)
    )


def stepped():
    """A counterbored block: it takes a stack, which asks for planes."""
    block = cq.Workplane().box(60, 40, 20).edges("|Z").fillet(5)
    return block.faces(">Z").workplane().cboreHole(10, 20, 6)


def drilled(radius):
    return cq.Workplane("YZ").circle(radius).extrude(60, both=True)


def vase():
    """A revolved spline, with a blind hole that a stack or a cut needs its planes and radii for."""
    wall = cq.Workplane("XZ").lineTo(20, 0).spline([(26, 15), (15, 35), (18, 50)], includeCurrent=True).lineTo(0, 50)
    return wall.close().revolve(360, (0, 0), (0, 1)).faces(">Z").workplane().hole(10, 20)


SHAPES = {
    "revolved spline with a hole": vase,
    "mirrored quarter of a revolved spline": lambda: (
        vase().intersect(cq.Workplane().box(99, 99, 200, (False, False, True))).mirror("XZ")
    ),
    "counterbored block": stepped,
    "ball": lambda: cq.Workplane().sphere(7),
    "ball with a bore along its poles": lambda: (
        cq.Workplane().sphere(7).cut(cq.Workplane().circle(2).extrude(9, both=True))
    ),
    "eighth of a ball": lambda: cq.Workplane().sphere(7).intersect(cq.Workplane().box(9, 9, 9, centered=False)),
    "ring": lambda: cq.Workplane(cq.Solid.makeTorus(20, 5)).rotate((0, 0, 0), (1, 2, 0), 50),
    "cone to a point": lambda: cq.Workplane(cq.Solid.makeCone(5, 0, 7)),
    "cone with a cross hole": lambda: cq.Workplane(cq.Solid.makeCone(10, 5, 30, (0, 0, -15))).cut(drilled(2)),
    "box with rounded edges": lambda: cq.Workplane().box(4, 5, 6).edges().fillet(0.7),
    "mirrored sleeve": lambda: cq.Workplane("XZ").circle(9).circle(5).extrude(30).mirror("YZ"),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_spline_face_is_read_as_what_it_is(name):
    shape = SHAPES[name]()
    (expected,), (found,) = load(shape).solids, load(on_splines(shape)).solids
    kinds, areas = zip(*sorted((face.kind, face.area) for face in found.faces), strict=True)
    own_kinds, own_areas = zip(*sorted((face.kind, face.area) for face in expected.faces), strict=True)
    assert kinds == own_kinds
    assert areas == pytest.approx(own_areas, rel=1e-6)
    assert found.volume == pytest.approx(expected.volume, rel=1e-7)
    outward = sum(float(face.normal @ face.center) * face.area for face in found.faces if face.kind == "plane")
    same = sum(float(face.normal @ face.center) * face.area for face in expected.faces if face.kind == "plane")
    assert outward == pytest.approx(same, abs=1e-6)


def test_in_a_file_of_splines_alone_those_that_are_elementary_are_read_so_beside_a_free_form_face():
    """In one that has planes besides, a flat spline was drawn as a spline: its parameters go with those of others."""
    outline = [(30, 0), (25, 15), (8, 20), (-12, 18), (-28, 8), (-25, -12), (-5, -20), (18, -16)]
    plate = cq.Workplane().spline(outline, periodic=True).close().extrude(8)
    plate = plate.faces(">Z").workplane(origin=(0, 0, 8)).circle(6).extrude(6)
    kinds = {face.kind for face in load(on_splines(plate)).solids[0].faces}
    assert kinds == {"plane", "cylinder", "bspline"}
    mesh = cs.sweep_mesh(on_splines(plate))
    assert mesh.record.way == "columns"
    loft = cq.Workplane().rect(20, 16).workplane(offset=10).circle(6).loft()
    assert not any("read as th" in note for note in load(loft).notes)


def test_edges_that_are_of_no_solid_are_in_nobodys_way():
    loose = cq.Edge.makeLine(cq.Vector(99, 0, 0), cq.Vector(99, 1, 0))
    part = load(cq.Compound.makeCompound([on_splines(stepped()), loose]))
    assert {face.kind for face in part.solids[0].faces} == {face.kind for face in load(stepped()).solids[0].faces}


def test_splines_that_only_come_near_are_read_to_their_tolerance():
    expected, found = load(stepped()).solids[0], load(approximated(stepped(), 1e-5)).solids[0]
    assert sorted(face.kind for face in found.faces) == sorted(face.kind for face in expected.faces)
    assert found.volume == pytest.approx(expected.volume, rel=1e-5)


def test_what_needs_planes_and_radii_meshes_from_splines():
    """The mesh is that of the part itself, and so are its names."""
    block = on_splines(stepped())
    lid = next(face for face in block.Faces() if face.Center().z == pytest.approx(10.0))
    lid.label = "lid"
    mesh, own = cs.sweep_mesh([block, lid], size=4.0), cs.sweep_mesh(stepped(), size=4.0)
    assert mesh.n_hexes == own.n_hexes
    assert mesh.info["quality"].min_scaled_jacobian == pytest.approx(own.info["quality"].min_scaled_jacobian, abs=1e-3)
    assert "lid" in mesh.boundaries


def turned_away(points, normals, rng):
    """Points and normals moved rigidly."""
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return points @ turn.T + rng.normal(size=3), normals @ turn.T


def around(kind):
    """Points and normals of a patch, and what its sizes are."""
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0.3, 1.2, 6), np.linspace(-0.4, 0.9, 6)))
    zero, out = np.zeros_like(u), np.column_stack([np.cos(u), np.sin(u), np.zeros_like(u)])
    up = np.array([0.0, 0.0, 1.0])
    if kind == "plane":
        return np.column_stack([u, v, zero]), np.tile(up, (len(u), 1)), ()
    if kind == "cylinder":
        return 3.0 * out + v[:, None] * up, out, (3.0,)
    if kind == "cone":
        along = 2.0 + v[:, None]
        return along * (np.sin(0.5) * out + np.cos(0.5) * up), np.cos(0.5) * out - np.sin(0.5) * up, (0.5,)
    normals = np.cos(v)[:, None] * out + np.sin(v)[:, None] * up
    return (4.0 * normals, normals, (4.0,)) if kind == "sphere" else (5.0 * out + 2.0 * normals, normals, (5.0, 2.0))


@pytest.mark.parametrize("kind", ["plane", "cylinder", "cone", "sphere", "torus"])
def test_points_and_normals_tell_the_surface(kind):
    rng = np.random.default_rng(5)
    points, normals, sizes = around(kind)
    points, normals = turned_away(points, normals, rng)
    found = fit_elementary(points, normals, 1e-9)
    assert found.kind == kind
    assert found.sizes == pytest.approx(sizes, rel=1e-8)
    assert fit_elementary(points + 1e-3 * rng.normal(size=points.shape), normals, 1e-6) is None
