"""Castings: parts that no sweep, no columns and no cuts fill, as a fitted grid is for."""

from __future__ import annotations

import cadquery as cq


def knob() -> cq.Workplane:
    """A ball on a tapered stem on a flange, blended, with a flat and a blind bore from below."""
    ball = cq.Workplane().sphere(9).translate((0, 0, 22))
    stem = cq.Workplane().circle(8).workplane(offset=20).circle(5).loft()
    body = cq.Workplane().circle(11).extrude(4).union(stem).union(ball)
    body = body.cut(cq.Workplane().box(20, 20, 20).translate((0, 17, 24)))
    return body.cut(cq.Workplane().circle(3).extrude(12)).edges("<Z").chamfer(0.6)


def bracket() -> cq.Workplane:
    """An angle with a gusset, blended all over, with holes in both arms."""
    profile = [(0, 0), (40, 0), (40, 8), (8, 8), (8, 35), (0, 35)]
    angle = cq.Workplane("XZ").polyline(profile).close().extrude(-30)
    gusset = cq.Workplane("XZ", origin=(0, 12, 0)).polyline([(6, 6), (28, 6), (6, 26)]).close().extrude(-6)
    body = angle.union(gusset).edges().fillet(1.0)
    body = body.cut(cq.Workplane(origin=(33, 15, 0)).circle(4).extrude(10))
    return body.cut(cq.Workplane("YZ", origin=(-1, 7, 26)).pushPoints([(0, 0), (16, 0)]).circle(2.5).extrude(12))


def manifold() -> cq.Workplane:
    """A block with bores along all axes that meet inside, a slanted one, and round bosses around the ports."""
    body = cq.Workplane().box(50, 36, 30)
    body = body.union(cq.Workplane("YZ", origin=(25, 0, 0)).circle(11).extrude(6))
    body = body.union(cq.Workplane("XZ", origin=(5, 18, 0)).circle(10).extrude(-5))
    body = body.cut(cq.Workplane("YZ", origin=(-10, 0, 0)).circle(6).extrude(60))
    body = body.cut(cq.Workplane("XZ", origin=(5, 0, 0)).circle(5).extrude(-40))
    return body.cut(cq.Workplane().transformed(rotate=(0, 30, 0), offset=(-20, -4, 0)).circle(4).extrude(40))


def cover() -> cq.Workplane:
    """A gearbox cover: a shell with crossed ribs inside, a boss with a bore, and drafted walls with blended corners."""
    body = cq.Workplane().rect(70, 50).extrude(18, taper=5).edges("not(#Z or |X or |Y)").fillet(6)
    inside = cq.Workplane().rect(60, 40).extrude(13, taper=5)
    ribs = cq.Workplane().rect(70, 4).extrude(13).union(cq.Workplane().rect(4, 50).extrude(13))
    body = body.cut(inside.cut(ribs).cut(cq.Workplane().circle(10).extrude(13)))
    body = body.union(cq.Workplane(origin=(0, 0, 17)).circle(10).extrude(6))
    return body.cut(cq.Workplane().circle(5).extrude(30))


def pump_housing() -> cq.Workplane:
    """A round chamber with an outlet at its side and an inlet in its middle, on a foot, blended where they meet."""
    chamber = cq.Workplane("XZ").circle(22).extrude(20)
    foot = cq.Workplane(origin=(0, -10, -30)).box(44, 30, 8)
    web = cq.Workplane(origin=(0, -10, -22)).box(20, 12, 16)
    outlet = cq.Workplane(origin=(13, -10, 0)).circle(8).extrude(32)
    inlet = cq.Workplane("XZ", origin=(0, -20, 0)).circle(11).extrude(10)
    body = chamber.union(outlet).union(inlet).union(web).union(foot)
    body = body.cut(cq.Workplane("XZ", origin=(0, 1, 0)).circle(16).extrude(16))
    body = body.cut(cq.Workplane("XZ").circle(6).extrude(40)).cut(
        cq.Workplane(origin=(11, -9, 0)).circle(4).extrude(40)
    )
    holes = cq.Workplane(origin=(0, -10, -40)).rect(34, 20, forConstruction=True).vertices().circle(2.5).extrude(20)
    return body.cut(holes)
