"""A cell extruded by data is the solid that OpenCASCADE extrudes of it."""

import cadquery as cq
import numpy as np
import pytest
from OCP.BOPAlgo import BOPAlgo_Builder
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Ax3, gp_Pln, gp_Vec
from OCP.TopAbs import TopAbs_Orientation

from cadsweep.cad.extract.prism import extrude_cells
from cadsweep.cad.extract.shared import read_edge_curves
from cadsweep.cad.extract.solids import extract_solid, read_wires
from cadsweep.cad.geometry.convert import read_surface
from cadsweep.cad.shapes import EDGE, FACE, SOLID, WIRE, compound, index_map, subshapes, typed
from cadsweep.errors import CadError

UP = np.array([0.0, 0.0, 4.0])


def wave():
    upper = cq.Workplane().moveTo(-6, 0).spline([(-2, 3), (3, 1), (6, 2)], includeCurrent=True)
    return upper.lineTo(6, -4).lineTo(-6, -4).close()


def cut_disc():
    return cq.Workplane().moveTo(0, -5).threePointArc((-5, 0), (0, 5)).lineTo(2, 0).close()


def half_ellipse():
    return cq.Workplane().ellipseArc(9, 6, 0, 180, startAtCurrent=False).close()


def as_data(cells, lines):
    """The wires of cells by the numbers of their lines, the lines, and their curves."""
    number = index_map(compound(lines), EDGE)
    wires = [[[(use.number, use.sense) for use in wire] for wire in read_wires(cell, number)] for cell in cells]
    return wires, lines, read_edge_curves(lines)


def extruded(outline, *, hole=False):
    """The cell of an outline as data, and as OpenCASCADE has it."""
    wire = outline.wires().val().wrapped
    inner = cq.Workplane().center(-1, 1).rect(1, 2).wires().val()
    maker = BRepBuilderAPI_MakeFace(gp_Pln(gp_Ax3()), wire, True)  # turns the wire round where it has to
    if hole:
        maker.Add(typed(inner.wrapped.Reversed(), WIRE))
    cell = maker.Face()
    lines = subshapes(cell, EDGE)
    sides = [(0, -1) if line.Orientation() == TopAbs_Orientation.TopAbs_FORWARD else (-1, 0) for line in lines]
    made = extrude_cells(*as_data([cell], lines), sides, read_surface(BRep_Tool.Surface_s(cell)), UP)
    known = extract_solid(subshapes(BRepPrimAPI_MakePrism(cell, gp_Vec(*UP)).Shape(), SOLID)[0])
    return made, known


@pytest.mark.parametrize("hole", [False, True])
@pytest.mark.parametrize("outline", [wave, cut_disc, half_ellipse])
def test_as_opencascade_extrudes(outline, hole):
    made, known = extruded(outline(), hole=hole)
    solid = made.solid
    assert solid.volume == pytest.approx(known.volume, rel=1e-8)
    assert solid.size == pytest.approx(known.size, rel=1e-6)
    partner = {}
    for face in solid.faces:
        other = min(known.faces, key=lambda f: np.linalg.norm(f.center - face.center))
        partner[face.id] = other.id
        assert face.kind == other.kind
        assert face.area == pytest.approx(other.area, rel=1e-8)
        np.testing.assert_allclose(face.center, other.center, atol=1e-6)
        np.testing.assert_allclose(face.normal, other.normal, atol=1e-6)
    assert len(set(partner.values())) == len(known.faces)
    for edge in solid.edges:
        other = min(known.edges, key=lambda e: np.linalg.norm(e.midpoint - edge.midpoint))
        same = float(edge.tangents[0] @ other.tangents[0]) > 0
        beside = [partner[f] for f in edge.faces]
        assert tuple(beside if same else beside[::-1]) == other.faces, "who runs it forward lies on its left"
        assert edge.dihedral == pytest.approx(other.dihedral, abs=1e-7)
        assert edge.length == pytest.approx(other.length, rel=1e-9)
        ends = solid.vertices[[edge.start, edge.end]]
        np.testing.assert_allclose(edge.curve.evaluate(np.array([0.0, 1.0])), ends, atol=1e-9)


@pytest.mark.parametrize("outline", [wave, cut_disc, half_ellipse])
def test_faces_hold_their_loops(outline):
    """Loops are closed, angles those of the corners, and edges on the surfaces, which face out of the solid."""
    made, _ = extruded(outline(), hole=True)
    solid, at = made.solid, np.linspace(0.0, 1.0, 5)
    for face in solid.faces:
        for loop in face.loops:
            for one, following in zip(loop.directed, loop.directed[1:] + loop.directed[:1], strict=True):
                assert solid.last_vertex(one) == solid.first_vertex(following)
        for e in face.edges:
            uv = face.surface.edge_uv(e, at)
            points = solid.edges[e].curve.evaluate(at)
            np.testing.assert_allclose(face.surface.evaluate(uv), points, atol=1e-8)
            own = [forward for loop in face.loops for one, forward in loop.directed if one == e]
            inward = np.cross(face.surface.normals(uv), solid.edges[e].curve.tangents(at)) * (1.0 if own[0] else -1.0)
            other = solid.faces[next(f for f in solid.edges[e].faces if f != face.id)]
            outward = other.surface.normals(other.surface.edge_uv(e, at))
            if solid.edges[e].dihedral < np.pi - 1e-6:
                assert (np.einsum("md,md->m", inward, outward) < 0).all(), "at a convex edge faces fall off each other"
    bottom, top = (solid.faces[f] for f in (made.bottoms[0], made.tops[0]))
    assert sorted(bottom.loops[0].angles) == pytest.approx(sorted(top.loops[0].angles), abs=1e-12)


def test_cells_that_touch_in_a_corner_are_refused():
    squares = [BRepBuilderAPI_MakeFace(gp_Pln(gp_Ax3()), x, x + 2, x, x + 2).Face() for x in (0, 2)]
    builder = BOPAlgo_Builder()
    for face in squares:
        builder.AddArgument(face)
    builder.Perform()
    cells = subshapes(builder.Shape(), FACE)
    lines = [subshapes(cell, EDGE) for cell in cells]
    sides = [
        (k, -1) if line.Orientation() == TopAbs_Orientation.TopAbs_FORWARD else (-1, k)
        for k, own in enumerate(lines)
        for line in own
    ]
    with pytest.raises(CadError, match=r"touches itself at \(2, 2, 0\)"):
        extrude_cells(*as_data(cells, lines[0] + lines[1]), sides, read_surface(BRep_Tool.Surface_s(cells[0])), UP)
