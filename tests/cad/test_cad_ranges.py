"""Edges whose parameter curves have another range than their curve in space: valid, and written by several kernels."""

import math

import cadquery as cq
import numpy as np
import pytest
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.Geom import Geom_Plane
from OCP.Geom2d import Geom2d_Conic, Geom2d_TrimmedCurve
from OCP.Geom2dConvert import Geom2dConvert
from OCP.gp import gp_Vec2d
from OCP.TColStd import TColStd_Array1OfReal

import cadsweep as cs
from cadsweep import cad
from cadsweep.cad.shapes import EDGE, space_range, subshapes

from . import cad_zoo


def ranged_anew(shape, *, planes):
    """A copy whose parameter curves come before the curves in space, and have other ranges; those on planes may go."""
    copy = BRepBuilderAPI_Copy(shape).Shape()
    for edge in subshapes(copy, EDGE):
        held = edge.TShape()
        old = list(held.ChangeCurves())
        held.ChangeCurves().Clear()
        for curve in old:
            if curve.IsCurveOnSurface():
                if not planes and isinstance(curve.Surface(), Geom_Plane):
                    continue
                first, last = curve.First(), curve.Last()
                own, begin, end = stretched(curve.PCurve(), first, last)
                curve.PCurve(own)
                if curve.IsCurveOnClosedSurface():
                    curve.PCurve2(stretched(curve.PCurve2(), first, last)[0])
                curve.SetRange(begin, end)
                held.SameRange(False)
                held.SameParameter(False)
            held.ChangeCurves().Prepend(curve)
    return copy


def stretched(curve, first, last):
    """The same curve with another range: conics a turn on, others from 10 to 10 + 3 times their width."""
    if isinstance(curve, Geom2d_Conic) and curve.IsPeriodic():
        return curve, first + 2 * math.pi, last + 2 * math.pi
    spline = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(curve, first, last))
    knots = TColStd_Array1OfReal(1, spline.NbKnots())
    for j in range(1, spline.NbKnots() + 1):
        knots.SetValue(j, 10.0 + 3.0 * (spline.Knot(j) - spline.Knot(1)))
    spline.SetKnots(knots)
    return spline, 10.0, spline.Knot(spline.NbKnots())


ZOO = cad_zoo.zoo()
WITH_PLANES = ("half_torus", "frustum", "plate_with_holes", "slot", "wedge")


@pytest.mark.parametrize(
    ("name", "planes"),
    [(name, False) for name in WITH_PLANES]
    + [
        (name, True)
        for name in (*WITH_PLANES, "cylinder", "hyperbola", "twist", "round_loft", "fillets", "closed_spline")
    ],
)
def test_the_range_of_an_edge_is_that_of_its_curve_in_space(name, planes):
    shape = ZOO[name].val().wrapped
    other = ranged_anew(shape, planes=planes)
    assert planes is False or any(BRep_Tool.Range_s(e)[0] != space_range(e)[0] for e in subshapes(other, EDGE))
    one, two = (cs.load(s).solids[0] for s in (shape, other))
    assert [e.kind for e in one.edges] == [e.kind for e in two.edges]
    assert [e.length for e in one.edges] == pytest.approx([e.length for e in two.edges], rel=1e-6)
    assert [f.area for f in one.faces] == pytest.approx([f.area for f in two.faces], rel=1e-5)
    assert one.volume == pytest.approx(two.volume, rel=1e-5)
    at = np.linspace(0, 1, 7)
    for a, b in zip(one.edges, two.edges, strict=True):
        assert np.abs(a.curve.evaluate(at) - b.curve.evaluate(at)).max() < 1e-5 * one.size


def test_faces_whose_edges_have_several_ranges_are_drawn_whole():
    # Its two spherical faces are halves, which OpenCASCADE's division leaves with such an edge.
    ball = cq.Workplane().sphere(5).cut(cq.Workplane().box(2, 2, 20))
    (solid,) = cad.load(ball).solids
    for face, (points, triangles) in zip(solid.faces, cad.find_facets(solid), strict=True):
        a, b, c = points[triangles].transpose(1, 0, 2)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0
        assert area == pytest.approx(face.area, rel=0.01)


def test_a_face_whose_wire_is_torn_by_a_turn_has_facets():
    """A curve on a cylinder, a turn away from its neighbours: for one of the four edges the mesher makes nothing."""
    for which in range(4):
        (solid,) = cs.load(cq.Workplane().box(20, 20, 10).edges("|Z").fillet(4)).solids
        number = next(face.id for face in solid.faces if face.kind != "plane")
        face = solid.kernel.faces[number]
        edge = subshapes(face, EDGE)[which]
        curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
        BRep_Builder().UpdateEdge(edge, curve.Translated(gp_Vec2d(-2 * math.pi, 0.0)), face, 1e-7)
        assert len(cad.find_facets(solid)[number][1])


def test_a_patch_between_blends_whose_wire_crosses_itself_has_facets(tmp_path):
    """Where blends of a lever's arm and bosses meet is a patch of three sides, off its edges by some tolerance."""
    lever = cq.Workplane().circle(14).extrude(20).union(cq.Workplane().center(60, 0).circle(9).extrude(12))
    lever = lever.union(cq.Workplane().polyline([(0, 10), (60, 6), (60, -6), (0, -10)]).close().extrude(8))
    lever = lever.cut(cq.Workplane().circle(7).extrude(20)).cut(cq.Workplane().center(60, 0).circle(4).extrude(12))
    lever = lever.edges(cq.selectors.BoxSelector((-20, -20, 7.5), (80, 20, 8.5))).fillet(1.5)
    cq.exporters.export(lever, str(tmp_path / "lever.step"))
    (solid,) = cs.load(tmp_path / "lever.step").solids
    for face, (points, triangles) in zip(solid.faces, cad.find_facets(solid), strict=True):
        sides = np.diff(points[triangles], axis=1)
        area = 0.5 * np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
        assert area == pytest.approx(face.area, rel=0.05)
