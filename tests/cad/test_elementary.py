"""Faces that a file has on turned or extruded curves are read as the cylinders, cones and so on that they are."""

import math

import pytest

cq = pytest.importorskip("cadquery")

from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_Sewing  # noqa: E402
from OCP.Geom import Geom_Circle, Geom_Line, Geom_SurfaceOfLinearExtrusion  # noqa: E402
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt  # noqa: E402
from OCP.ShapeCustom import ShapeCustom  # noqa: E402

import cadsweep as cs  # noqa: E402
from cadsweep.cad import load  # noqa: E402

pytestmark = pytest.mark.cad


def turned(shape):
    """The same shape, all its round faces surfaces of revolution."""
    return cq.Shape.cast(ShapeCustom.ConvertToRevolution_s(shape.val().wrapped))


def drilled(radius, *, plane="YZ"):
    return cq.Workplane(plane).circle(radius).extrude(60, both=True)


SHAPES = {
    "ball": lambda: cq.Workplane().sphere(7),
    "half a ball, turned over": lambda: cq.Workplane().sphere(7, angle1=-90, angle2=0).rotate((0, 0, 0), (1, 2, 0), 50),
    "cone with a cross hole": lambda: cq.Workplane(cq.Solid.makeCone(10, 5, 30, (0, 0, -15))).cut(drilled(2)),
    "funnel": lambda: cq.Workplane(cq.Solid.makeCone(10, 6, 20)).cut(cq.Workplane(cq.Solid.makeCone(6, 3, 20))),
    "quarter of a ring": lambda: cq.Workplane(cq.Solid.makeTorus(20, 5)).intersect(
        cq.Workplane().box(40, 40, 20, centered=(False, False, True))
    ),
    "sleeve with a hole": lambda: cq.Workplane().circle(9).circle(5).extrude(20, both=True).cut(drilled(3)),
    "mirrored": lambda: cq.Workplane("XZ").circle(9).extrude(30).cut(drilled(3, plane="XY")).mirror("YZ"),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_turned_face_is_read_as_what_it_is(name):
    shape = SHAPES[name]()
    (expected,), (found,) = load(shape).solids, load(turned(shape)).solids
    assert sorted((face.kind, round(face.area, 6)) for face in found.faces) == sorted(
        (face.kind, round(face.area, 6)) for face in expected.faces
    )
    assert found.volume == pytest.approx(expected.volume, rel=1e-9)
    assert "revolution" not in {face.kind for face in found.faces}
    outward = sum(float(face.normal @ face.center) * face.area for face in found.faces if face.kind == "plane")
    same = sum(float(face.normal @ face.center) * face.area for face in expected.faces if face.kind == "plane")
    assert outward == pytest.approx(same, abs=1e-6)


def test_what_needs_axes_is_meshed_from_turned_faces():
    mesh = cs.sweep_mesh(turned(cq.Workplane().sphere(7)), size=1.0)
    assert mesh.info["quality"].min_scaled_jacobian > 0.4
    assert mesh.info["quality"].volume == pytest.approx(4 / 3 * math.pi * 7**3, rel=0.02)


def test_extruded_lines_and_circles_are_planes_and_cylinders():
    """Half a rod: its sides are extruded along its axis."""
    way, sewing = gp_Dir(0, 0, 1), BRepBuilderAPI_Sewing()
    circle = Geom_Circle(gp_Ax2(gp_Pnt(0, 0, 0), way, gp_Dir(1, 0, 0)), 5.0)
    round_side = Geom_SurfaceOfLinearExtrusion(circle, way)
    flat_side = Geom_SurfaceOfLinearExtrusion(Geom_Line(gp_Pnt(-5, 0, 0), gp_Dir(1, 0, 0)), way)
    sewing.Add(BRepBuilderAPI_MakeFace(round_side, 0.0, math.pi, 0.0, 12.0, 1e-7).Face())
    sewing.Add(BRepBuilderAPI_MakeFace(flat_side, 0.0, 10.0, 0.0, 12.0, 1e-7).Face())
    for z in (0.0, 12.0):
        half = cq.Workplane(origin=(0, 0, z)).moveTo(5, 0).threePointArc((0, 5), (-5, 0)).close()
        sewing.Add(cq.Face.makeFromWires(half.val()).wrapped)
    sewing.Perform()
    solid = cq.Solid.makeSolid(cq.Shell(sewing.SewedShape())).fix()
    assert {face.geomType() for face in solid.Faces()} == {"PLANE", "EXTRUSION"}
    (found,) = load(solid).solids
    assert sorted(face.kind for face in found.faces) == ["cylinder", "plane", "plane", "plane"]
    assert found.volume == pytest.approx(0.5 * math.pi * 25 * 12, rel=1e-9)
