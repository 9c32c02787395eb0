"""Shapes of every kind that a loader meets, built with CadQuery."""

from math import acos, tau

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_ConicalSurface, Geom_ToroidalSurface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

TILTED = gp_Ax3(gp_Pnt(1, 2, 3), gp_Dir(1, 2, 2))


def capped(surface, low, high):
    """A solid between two circles of a surface of revolution, at two values of v."""
    wall = cq.Face(BRepBuilderAPI_MakeFace(surface, 0, tau, low, high, 1e-7).Face())
    rims = [edge for edge in wall.Edges() if edge.IsClosed()]
    caps = [cq.Face.makeFromWires(cq.Wire.assembleEdges([rim])) for rim in rims]
    return cq.Workplane(cq.Solid.makeSolid(cq.Shell.makeShell([wall, *caps])).fix())


def zoo():
    """Name to Workplane."""
    w = cq.Workplane
    bow = [(0, 0), (1, 2), (0, 4)]
    return {
        "box": w().box(1, 2, 3),
        "cylinder": w().cylinder(2, 1),
        "half_torus": w().circle(2).revolve(180, (5, 0, 0), (5, 1, 0)),
        "plate_with_holes": w().box(4, 4, 1).faces(">Z").workplane().rarray(1.5, 1.5, 2, 2).hole(1),
        "tube": w().circle(2).circle(1).extrude(3),
        "loft": w().rect(1, 1).workplane(offset=3).rect(2, 1).loft(),
        "round_loft": w().circle(1).workplane(offset=3).ellipse(2, 1).loft(),
        "twist": w().rect(1, 2).twistExtrude(4, 60),
        "round_twist": w().center(1, 0).circle(0.4).twistExtrude(4, 60),
        "fillets": w().box(4, 4, 2).edges("|Z").fillet(0.5).faces(">Z").edges().fillet(0.2),
        "spline_sweep": w().circle(0.5).sweep(w("XZ").spline(bow)),
        "cone": w(cq.Solid.makeCone(1, 0, 2)),
        "frustum": w(cq.Solid.makeCone(1, 0.5, 2)),
        "mirrored_frustum": w(cq.Solid.makeCone(1, 0.5, 2)).mirror("XY"),
        "beyond_an_apex": capped(Geom_ConicalSurface(TILTED, 0.5, 2.0), -12.0, -8.0),
        "below_an_apex": capped(Geom_ConicalSurface(TILTED, 0.5, 0.0), -5.0, -2.0),
        "beyond_an_axis": capped(Geom_ToroidalSurface(TILTED, 8.0, 54.0), acos(-8 / 54) + 0.1, acos(-8 / 54) + 0.3),
        "hyperbola": w(cq.Solid.makeCone(1, 0.5, 2)).cut(w().box(2, 2, 8).translate((1.3, 0, 0))),
        "parabola": w(cq.Solid.makeCone(2, 0, 2)).cut(
            w().box(9, 9, 9).translate((0, 0, -3.8)).rotate((0, 0, 0), (0, 1, 0), 45)
        ),
        "sphere": w().sphere(1),
        "torus": w(cq.Solid.makeTorus(3, 1)),
        "oval_ring": w("XZ").center(15, 0).ellipse(4, 2).revolve(360, (-15, 0, 0), (-15, 1, 0)),
        "dome": w().sphere(1, angle1=0),
        "wedge": w().rect(2, 1, centered=False).revolve(90, (0, 0, 0), (0, 1, 0)),
        "closed_spline": w().spline([(0, 0), (2, 0), (2, 1), (0, 2)], periodic=True).close().extrude(2),
        "revolved_spline": w("XZ")
        .moveTo(1, 0)
        .lineTo(2, 0)
        .spline([(2.5, 1), (1.5, 2)], includeCurrent=True)
        .lineTo(1, 2)
        .close()
        .revolve(120, (0, 0, 0), (0, 1, 0)),
        "crossing_holes": w().box(4, 4, 4).faces(">Z").workplane().hole(1).faces(">X").workplane().hole(1),
        "bent_pipe": w().circle(0.5).circle(0.4).sweep(w("XZ").lineTo(0, 2).radiusArc((2, 4), 2).lineTo(4, 4)),
        "wedge_with_hole": w("XZ")
        .polyline([(0, 0), (30, 0), (30, 12), (0, 4)])
        .close()
        .extrude(20)
        .faces("<Z")
        .workplane(centerOption="CenterOfBoundBox")
        .hole(6),
        "slot": w().slot2D(4, 1).extrude(1),
        "cup": w().box(4, 4, 4).faces(">Z").shell(0.2),
        "ellipse": w().ellipse(2, 1).extrude(1),
    }
