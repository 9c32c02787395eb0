"""Curves that end a little apart in one vertex, as some programs write them."""

import cadquery as cq
import pytest
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Dir2d, gp_Pnt2d
from OCP.TopoDS import TopoDS

from cadsweep.cad.heal.gaps import cover_gaps
from cadsweep.cad.heal.tracing import Traced
from cadsweep.cad.shapes import VERTEX, subshapes

pytestmark = pytest.mark.cad

MINOR, GAP = 0.3, 5e-6


def elbow_with_seam_off():
    """A quarter of a torus, the seam of which lies beside itself in the parameters of its face."""
    solid = cq.Workplane().center(1, 0).circle(MINOR).revolve(90, (-1, 0, 0), (-1, 1, 0)).val()
    (torus,) = solid.faces("%TORUS").Faces()
    (seam,) = (edge for edge in torus.Edges() if BRep_Tool.IsClosed_s(edge.wrapped, torus.wrapped))
    first, last = BRep_Tool.Range_s(seam.wrapped)
    lines = []
    for edge in (seam.wrapped, TopoDS.Edge_s(seam.wrapped.Reversed())):
        line = BRep_Tool.CurveOnSurface_s(edge, torus.wrapped, first, last)
        start, end = line.Value(first), line.Value(last)
        begin = gp_Pnt2d(start.X(), start.Y() + GAP / MINOR)
        lines.append(Geom2d_Line(begin, gp_Dir2d(end.X() - start.X(), end.Y() - start.Y())))
    BRep_Builder().UpdateEdge(seam.wrapped, *lines, torus.wrapped, 1e-7)
    return solid


def tolerances(shape):
    """Those of all vertices."""
    return [BRep_Tool.Tolerance_s(vertex) for vertex in subshapes(shape, VERTEX)]


def test_vertices_cover_the_gaps_at_them_in_a_copy():
    solid = elbow_with_seam_off()
    traced = Traced(solid.wrapped)
    assert cover_gaps(traced, 2.0 * GAP)
    assert max(tolerances(solid.wrapped)) < GAP
    for before, after in zip(subshapes(solid.wrapped, VERTEX), subshapes(traced.shape, VERTEX), strict=True):
        assert GAP < BRep_Tool.Tolerance_s(after) < 1.2 * GAP
        assert BRep_Tool.Pnt_s(before).Distance(BRep_Tool.Pnt_s(after)) == 0.0
    assert not cover_gaps(traced, 2.0 * GAP), "they are covered now"


def test_a_face_that_has_no_curve_for_an_edge_is_left_to_others():
    solid = cq.Workplane().circle(5).extrude(10).val()
    (side,) = solid.faces("%CYLINDER").Faces()
    rim = side.edges("%CIRCLE").Edges()[0]
    BRep_Builder().UpdateEdge(rim.wrapped, None, side.wrapped, 1e-7)
    assert BRep_Tool.CurveOnSurface_s(rim.wrapped, side.wrapped, 0.0, 1.0) is None
    assert not cover_gaps(Traced(solid.wrapped), 1.0)


def test_a_wider_gap_stays_what_it_is():
    solid = elbow_with_seam_off()
    traced = Traced(solid.wrapped)
    assert not cover_gaps(traced, 0.5 * GAP)
    assert traced.shape.IsSame(solid.wrapped)
