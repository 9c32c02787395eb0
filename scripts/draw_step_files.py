"""Draw the STEP files of ``models/`` that README and the documentation use in their commands.

    python scripts/draw_step_files.py [FOLDER]

The files are kept with the code, so that every command of the documentation runs from a checkout as it stands;
``tests/docs`` draws them anew and compares.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import cadquery as cq


def elbow() -> cq.Assembly:
    """A pipe with straight ends: three spans, faces and edges with names."""
    outer, bore, bend, leg = 10.0, 7.5, 30.0, 20.0
    middle = cq.Workplane("XZ").lineTo(0, leg).radiusArc((bend, leg + bend), bend).lineTo(bend + leg, leg + bend)
    pipe = cq.Workplane().circle(outer).circle(bore).sweep(middle)
    part = cq.Assembly(pipe, name="elbow")
    inlet, outlet = pipe.faces("<Z").val(), pipe.faces(">X").val()
    part.addSubshape(inlet, name="~inlet").addSubshape(outlet, name="~outlet")
    for face in pipe.faces().vals():
        if not (face.isSame(inlet) or face.isSame(outlet)):
            radius = max(edge.radius() for edge in face.Edges() if edge.geomType() == "CIRCLE" and edge.IsClosed())
            part.addSubshape(face, name="~wall" if radius > (outer + bore) / 2 else "~bore")
    return part.addSubshape(max(inlet.Edges(), key=lambda edge: edge.Length()), name="~rim")


def bracket() -> cq.Assembly:
    """An angle with a hole in each leg and a turned pocket: no single sweep."""
    angle = cq.Workplane("XZ").polyline([(0, 0), (40, 0), (40, 8), (8, 8), (8, 30), (0, 30)]).close().extrude(-30)
    angle = angle.cut(cq.Workplane("XY", (26, 15, 4)).transformed((0, 0, 30)).rect(12, 8).extrude(10))
    angle = angle.cut(cq.Workplane("YZ", (0, 15, 20)).transformed((0, 0, 20)).rect(10, 8).extrude(4))
    return cq.Assembly(angle, name="bracket")


def block() -> cq.Assembly:
    """A machined block with a pocket, a boss, and a bore: a stack of columns."""
    body = cq.Workplane().box(60, 40, 20).faces(">Z").workplane().center(-12, 0).rect(24, 24).cutBlind(-8)
    body = body.faces(">Z").workplane(origin=(18, 0, 10)).circle(8).extrude(6)
    body = body.faces(">Z").workplane(origin=(18, 0, 16)).circle(4).cutThruAll()
    part = cq.Assembly(body, name="block")
    return part.addSubshape(body.faces("<Z").val(), name="~base").addSubshape(body.faces(">Z").val(), name="~seat")


def flanges() -> cq.Assembly:
    """Two flanges and the gasket between them."""
    disc = cq.Workplane().circle(40).circle(15).extrude(12)
    holes = cq.Workplane().polarArray(28, 0, 360, 4).circle(4).extrude(100)
    gasket = cq.Workplane().circle(22).circle(15).extrude(2)
    raised = disc.cut(holes)
    part = cq.Assembly(name="flanges")
    part.add(raised, name="lower", color=cq.Color("steelblue"))
    part.add(gasket, name="gasket", loc=cq.Location((0, 0, 12)), color=cq.Color("orange"))
    return part.add(raised, name="upper", loc=cq.Location((0, 0, 14)), color=cq.Color("steelblue"))


def machine() -> cq.Assembly:
    """A stepped shaft in a bearing, on a foot."""
    shaft = cq.Workplane("YZ").circle(10).extrude(60).faces(">X").workplane().circle(7).extrude(25)
    bearing = cq.Workplane("YZ", (15, 0, 0)).circle(20).circle(10).extrude(20)
    foot = cq.Workplane("XY", (25, 0, -34)).box(40, 60, 8).edges("|Z").fillet(6)
    part = cq.Assembly(name="machine")
    part.add(shaft, name="shaft").add(bearing, name="bearing")
    return part.add(foot, name="foot")


def lever() -> cq.Assembly:
    """A round bar with a ball on its end: no hexahedra of it by sweeping."""
    bar = cq.Workplane().circle(5).extrude(60).union(cq.Workplane().sphere(9).translate((0, 0, 64)))
    part = cq.Assembly(bar, name="lever")
    return part.addSubshape(bar.faces("<Z").val(), name="~root")


DRAWINGS: dict[str, Callable[[], cq.Assembly]] = {
    drawing.__name__: drawing for drawing in (elbow, bracket, block, flanges, lever, machine)
}


def main(folder: Path) -> int:
    """Write every file into a folder."""
    for name, drawing in DRAWINGS.items():
        drawing().export(str(folder / f"{name}.step"))
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "models"))
