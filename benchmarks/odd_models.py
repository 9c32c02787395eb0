"""Valid solids as nobody would draw them: seams in bad places, mixed tolerances, splines for planes, units, tiny faces.

Every model is one of a few plain parts, with one oddity; all of it follows from its number.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import cadquery as cq
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_NurbsConvert, BRepBuilderAPI_Transform
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_TrimmedCurve
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.ShapeFix import ShapeFix_ShapeTolerance
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Compound


def plate(dice: random.Random) -> cq.Workplane:
    """A plate with holes."""
    at = [(x, y) for x in (-15, 0, 15) for y in (-8, 8) if dice.random() < 0.7]
    part = cq.Workplane().box(50, 30, dice.uniform(2, 8))
    return part.faces(">Z").workplane().pushPoints(at).hole(dice.uniform(2, 6)) if at else part


def bracket(dice: random.Random) -> cq.Workplane:
    """An L with a hole in each arm."""
    t = dice.uniform(2, 5)
    part = cq.Workplane("XZ").polyline([(0, 0), (30, 0), (30, t), (t, t), (t, 25), (0, 25)]).close().extrude(20)
    part = part.faces("<Z").workplane(centerOption="CenterOfMass").center(4, 0).hole(5)
    return part.faces("<X").workplane(centerOption="CenterOfMass").center(0, 3).hole(4)


def shaft(dice: random.Random) -> cq.Workplane:
    """A stepped shaft; each step has its seam elsewhere."""
    part, z = None, 0.0
    for _ in range(dice.randint(2, 4)):
        length = dice.uniform(4, 15)
        turned = cq.Plane((0, 0, z), (math.cos(a := dice.uniform(0, 6)), math.sin(a), 0), (0, 0, 1))
        step = cq.Workplane(turned).circle(dice.uniform(3, 10)).extrude(length)
        part, z = step if part is None else part.union(step), z + length
    return part


def block(dice: random.Random) -> cq.Workplane:
    """A block with a pocket and a blind hole from the side."""
    part = cq.Workplane().box(30, 24, 16).faces(">Z").workplane().rect(14, 10).cutBlind(-dice.uniform(3, 8))
    return part.faces(">X").workplane(centerOption="CenterOfMass").center(0, -4).hole(4, dice.uniform(3, 6))


def flange(dice: random.Random) -> cq.Workplane:
    """A pipe with a flange and bolt holes."""
    part = cq.Workplane().circle(20).extrude(4).faces(">Z").workplane().circle(10).extrude(dice.uniform(5, 20))
    part = part.faces(">Z").workplane().hole(dice.uniform(8, 16))
    return part.faces("<Z").workplane().polarArray(15, 0, 360, dice.randint(3, 6)).hole(3)


def elbow(dice: random.Random) -> cq.Workplane:
    """A bent pipe."""
    ring = cq.Workplane().circle(4).circle(dice.uniform(2, 3))
    return ring.revolve(dice.uniform(60, 200), (-15, 0, 0), (-15, 1, 0))


def cam(dice: random.Random) -> cq.Workplane:
    """A plate with one closed spline for its wall, and a bore."""
    r, k, n = dice.uniform(1, 4), dice.choice([2, 3, 5]), 16
    turns = [2 * math.pi * j / n for j in range(n)]
    outline = [((15 + r * math.cos(k * t)) * math.cos(t), (15 + r * math.cos(k * t)) * math.sin(t)) for t in turns]
    wall = cq.Workplane().spline(outline, periodic=True).close().extrude(dice.uniform(3, 12))
    return wall.faces(">Z").workplane(origin=(0, 0, 0)).circle(dice.uniform(2, 6)).cutThruAll()


def ring(dice: random.Random) -> cq.Workplane:
    """A torus between two planes: all its faces are closed, some both ways."""
    return cq.Workplane(obj=cq.Solid.makeTorus(20, 6)).intersect(cq.Workplane().box(80, 80, dice.uniform(4, 11)))


def egg(dice: random.Random) -> cq.Workplane:
    """A body of revolution without an edge, its poles on the axis."""
    half = cq.Workplane("XZ").moveTo(0, -8)
    half = half.spline([(6, -3), (7, 3), (0, dice.uniform(9, 13))], includeCurrent=True, tangents=[(1, 0), (-1, 0)])
    return half.close().revolve(360, (0, 0, 0), (0, 1, 0))


def eccentric(dice: random.Random) -> cq.Workplane:
    """A disc with a boss that touches its rim from inside."""
    r = dice.uniform(3, 7)
    return cq.Workplane().circle(10).extrude(5).union(cq.Workplane(origin=(10 - r, 0, 5)).circle(r).extrude(6))


def tee(dice: random.Random) -> cq.Workplane:
    """A shaft with a branch as thick as itself, or nearly, at or beside its seam."""
    branch = cq.Workplane("XZ").center(0, 20).circle(dice.choice([4, 6, 8, 7.99])).extrude(20)
    return cq.Workplane().circle(8).extrude(40).union(branch.rotate((0, 0, 0), (0, 0, 1), dice.choice([0, 90, 180])))


def cone(dice: random.Random) -> cq.Workplane:
    """A cone to its apex, bored across."""
    body = cq.Workplane(obj=cq.Solid.makeCone(12, dice.choice([0, 4, 8]), 20))
    return body.cut(cq.Workplane("XZ").center(0, 6).circle(dice.uniform(1, 3)).extrude(40, both=True))


PLAIN = (plate, bracket, shaft, block, flange, elbow, cam, ring, egg, eccentric, tee, cone)


def as_it_is(shape: Any, dice: random.Random) -> Any:
    """Nothing odd."""
    return shape


def on_splines(shape: Any, dice: random.Random) -> Any:
    """Every plane and cylinder as a B-spline."""
    return BRepBuilderAPI_NurbsConvert(shape, True).Shape()


def loose(shape: Any, dice: random.Random) -> Any:
    """Mixed tolerances on faces, edges and vertices."""
    fix = ShapeFix_ShapeTolerance()
    for sub in cq.Shape.cast(shape).Edges():
        fix.SetTolerance(sub.wrapped, 10 ** dice.uniform(-7, -3), TopAbs_ShapeEnum.TopAbs_EDGE)
    for sub in cq.Shape.cast(shape).Vertices():
        fix.SetTolerance(sub.wrapped, 10 ** dice.uniform(-3, -2.5), TopAbs_ShapeEnum.TopAbs_VERTEX)
    return shape


def off_faces(shape: Any, dice: random.Random) -> Any:
    """Curves of edges that lie off the faces, by up to 0.005, which their tolerances say."""
    shape, builder, by = BRepBuilderAPI_Copy(shape).Shape(), BRep_Builder(), 10 ** dice.uniform(-5, -2.3)
    for edge in cq.Shape.cast(shape).Edges():
        curve = None if BRep_Tool.Degenerated_s(edge.wrapped) else BRep_Tool.Curve_s(edge.wrapped, 0.0, 1.0)
        if curve is None or dice.random() < 0.5:
            continue
        spline = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(curve, *edge._bounds()))
        spline.IncreaseDegree(max(3, spline.Degree()))
        way = gp_Vec(*(dice.uniform(-1, 1) for _ in range(3))).Normalized().Multiplied(by)
        for k in range(2, spline.NbPoles()):
            spline.SetPole(k, spline.Pole(k).Translated(way))
        builder.UpdateEdge(edge.wrapped, spline, TopLoc_Location(), 2 * by)
        builder.Range(edge.wrapped, spline.FirstParameter(), spline.LastParameter(), True)
        builder.SameParameter(edge.wrapped, False)
    BRepLib.SameParameter_s(shape, 1e-7, True)
    return shape


def _moved(shape: Any, how: gp_Trsf) -> Any:
    return BRepBuilderAPI_Transform(shape, how, True).Shape()


def mirrored(shape: Any, dice: random.Random) -> Any:
    """Mirrored, and turned."""
    how, turn = gp_Trsf(), gp_Trsf()
    how.SetMirror(gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(*(dice.uniform(-1, 1) for _ in range(3)))))
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(1, 2, 0.5)), dice.uniform(0, 6))
    return _moved(shape, how.Multiplied(turn))


def _scaled(factor: float) -> Callable[[Any, random.Random], Any]:
    def scaled(shape: Any, dice: random.Random) -> Any:
        how = gp_Trsf()
        how.SetScale(gp_Pnt(0, 0, 0), factor * dice.uniform(0.5, 2))
        return _moved(shape, how)

    return scaled


def far_away(shape: Any, dice: random.Random) -> Any:
    """A kilometre from the origin."""
    how = gp_Trsf()
    how.SetTranslation(gp_Vec(1e6, -3e5, 7e5))
    return _moved(shape, how)


def nested(shape: Any, dice: random.Random) -> Any:
    """Compounds in compounds, each placed."""
    for _ in range(4):
        outer, builder, how = TopoDS_Compound(), BRep_Builder(), gp_Trsf()
        builder.MakeCompound(outer)
        how.SetRotation(gp_Ax1(gp_Pnt(3, 0, 0), gp_Dir(0, 1, 1)), dice.uniform(0, 6))
        builder.Add(outer, shape.Located(TopLoc_Location(how)) if shape.Location().IsIdentity() else shape)
        shape = outer
    return shape


def divided(shape: Any, dice: random.Random) -> Any:
    """Faces cut by planes that mean nothing: two halves side by side, glued to one solid again, edges kept."""
    whole = cq.Workplane(obj=cq.Shape.cast(shape))
    box = whole.val().BoundingBox()
    x = dice.uniform(box.xmin + 0.2 * box.xlen, box.xmax - 0.2 * box.xlen)
    big = 4 * box.DiagonalLength
    left = cq.Workplane().box(big, big, big).translate((x - big / 2, 0, 0))
    return whole.intersect(left, clean=False).union(whole.cut(left, clean=False), clean=False).val().wrapped


def tiny_faces(shape: Any, dice: random.Random) -> Any:
    """Hundreds to thousands of narrow faces: a knurled wheel in place of the part."""
    n = dice.choice([300, 1000, 2000])
    corners = [
        ((10 + 0.01 * (k % 2)) * math.cos(2 * math.pi * k / n), (10 + 0.01 * (k % 2)) * math.sin(2 * math.pi * k / n))
        for k in range(n)
    ]
    return cq.Workplane().polyline(corners).close().extrude(5).val().wrapped


def engraved(shape: Any, dice: random.Random) -> Any:
    """Rows of shallow dents, far smaller than the part."""
    dents = cq.Workplane().rarray(1.2, 1.2, dice.randint(3, 8), dice.randint(3, 6)).rect(0.4, 0.4).extrude(0.1)
    box = cq.Shape.cast(shape).BoundingBox()
    return cq.Workplane(obj=cq.Shape.cast(shape)).union(dents.translate((4, -6, box.zmax - 0.02))).val().wrapped


ODD = {
    "as it is": as_it_is,
    "on splines": on_splines,
    "loose": loose,
    "mirrored": mirrored,
    "a kilometre": _scaled(2e4),
    "a micrometre": _scaled(2e-5),
    "inches": _scaled(25.4),
    "far away": far_away,
    "nested": nested,
    "divided": divided,
    "tiny faces": tiny_faces,
    "engraved": engraved,
    "off its faces": off_faces,
}


def odd_model(number: int) -> tuple[str, Any]:
    """Model `number`: what it is, and its shape."""
    dice = random.Random(number)
    plain = PLAIN[number // len(ODD) % len(PLAIN)]
    oddity, change = list(ODD.items())[number % len(ODD)]
    shape = plain(dice).val().wrapped
    return f"{number} {plain.__name__} {oddity}", change(shape, dice)
