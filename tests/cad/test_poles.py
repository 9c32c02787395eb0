"""Turned faces that readers of STEP leave with too few edges, or with too many.

Of domes whose arcs end on the axis but are not centred on it they keep the rim alone.
"""

from math import pi

import cadquery as cq
import pytest
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepTools import BRepTools
from OCP.GC import GC_MakeArcOfCircle
from OCP.Geom import Geom_SurfaceOfRevolution
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Ax1, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Wire

import cadsweep as cs
from cadsweep.cad.heal.poles import close_poles
from cadsweep.cad.heal.tracing import Traced
from cadsweep.cad.heal.validate import faults
from cadsweep.cad.shapes import EDGE, FACE, subshapes

FORWARD, REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED

pytestmark = pytest.mark.cad


def dome(*, middle, is_up=True, radius=30.0):
    """A solid dome: half an arc from the floor to the axis through (`middle`, `middle`), turned around it."""
    up = 1.0 if is_up else -1.0
    outline = cq.Workplane("XZ").moveTo(0, 0).lineTo(radius, 0)
    outline = outline.threePointArc((middle, up * middle), (0, up * radius)).close()
    return outline.revolve(360, (0, 0, 0), (0, 1, 0))


@pytest.mark.parametrize("middle", [21.0, 21.2, 21.22, 21.5])
@pytest.mark.parametrize("is_up", [True, False])
@pytest.mark.parametrize("is_hollow", [True, False])
def test_a_dome_is_read_with_its_pole(tmp_path, middle, is_up, is_hollow):
    part = dome(middle=middle, is_up=is_up)
    if is_hollow:
        part = cq.Workplane().circle(40).extrude(80, both=True).cut(part)
    cq.exporters.export(part, str(tmp_path / "dome.step"))
    found = cs.load(tmp_path / "dome.step")
    (solid,) = found.solids
    assert not faults(solid.kernel.shape)
    assert solid.volume * found.scale**3 == pytest.approx(part.val().Volume(), rel=1e-6)
    assert {face.key for face in solid.faces} == {f"face {j}" for j in range(len(part.faces().vals()))}


def test_a_shell_of_two_domes_is_meshed_from_a_file(tmp_path):
    part = dome(middle=21.2).cut(dome(middle=19.1, radius=27.0))
    cq.exporters.export(part, str(tmp_path / "shell.step"))
    found = cs.load(tmp_path / "shell.step")
    assert any(note.startswith("turned faces closed at their axis") for note in found.notes)
    mesh = cs.sweep_mesh(tmp_path / "shell.step", size=3.0)
    assert mesh.info["quality"].min_scaled_jacobian > 0.3


def around_twice():
    """A turned face between two rims whose outline goes around twice, from rim to rim by edges of no length."""
    arc = GC_MakeArcOfCircle(gp_Pnt(3, 0, 0), gp_Pnt(3.7, 0, 0.3), gp_Pnt(4, 0, 1)).Value()
    surface = Geom_SurfaceOfRevolution(arc, gp_Ax1())
    low, high = surface.Bounds()[2:]
    builder, face, wire = BRep_Builder(), TopoDS_Face(), TopoDS_Wire()
    builder.MakeFace(face, surface, 1e-7)
    builder.MakeWire(wire)
    ends = {v: BRepBuilderAPI_MakeVertex(surface.Value(0.0, v)).Vertex() for v in (low, high)}

    def edge(curve, pcurves, span, vertices):
        made = TopoDS_Edge()
        builder.MakeEdge(made, *([] if curve is None else [curve, 1e-7]))
        builder.UpdateEdge(made, *pcurves, face, 1e-7)
        builder.Range(made, *span)
        builder.Degenerated(made, curve is None)
        for vertex, way in zip(vertices, (FORWARD, REVERSED), strict=True):
            builder.Add(made, vertex.Oriented(way))
        return made

    def level(v, start, *, is_rim):
        pcurve = Geom2d_Line(gp_Pnt2d(start, v), gp_Dir2d(1, 0))
        return edge(surface.VIso(v) if is_rim else None, [pcurve], (0.0, 2.0 * pi), (ends[v], ends[v]))

    meridians = [Geom2d_Line(gp_Pnt2d(u, 0), gp_Dir2d(0, 1)) for u in (2.0 * pi, -2.0 * pi)]
    seam = edge(surface.UIso(0.0), meridians, (low, high), (ends[low], ends[high]))
    outline = [
        (level(low, 0.0, is_rim=True), FORWARD),
        (seam, FORWARD),
        (level(high, 0.0, is_rim=False), REVERSED),
        (level(high, -2.0 * pi, is_rim=True), REVERSED),
        (seam, REVERSED),
        (level(low, -2.0 * pi, is_rim=False), FORWARD),
    ]
    for made, way in outline:
        builder.Add(wire, made.Oriented(way))
    wire.Closed(True)
    builder.Add(face, wire)
    return face


def test_a_face_that_goes_around_twice_as_read_goes_around_once():
    traced = Traced(around_twice())
    u0, u1, *_ = BRepTools.UVBounds_s(traced.shape)
    assert u1 - u0 == pytest.approx(4.0 * pi)
    (note,) = close_poles(traced)
    assert "twice" in note
    (face,) = subshapes(traced.shape, FACE)
    u0, u1, *_ = BRepTools.UVBounds_s(face)
    assert u1 - u0 == pytest.approx(2.0 * pi)
    assert BRepCheck_Analyzer(face).IsValid()
    assert len(subshapes(face, EDGE)) == 3
    assert not close_poles(traced)
