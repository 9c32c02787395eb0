"""Cells that end half way up the rounding of a floor or of a boss, where they meet it at 45 degrees."""

import pytest

pytest.importorskip("cadquery")

import cadquery as cq
import numpy as np

from cadsweep import load
from cadsweep.cad.edit.boxes import around_features
from cadsweep.cad.edit.circles import find_outlines
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.half_way import half_way
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad

FLAT = 1e-4
RADIUS = 4.0


def pocket(corner=None):
    """A block with a pocket, round or with round corners, whose floor is rounded."""
    outline = cq.Workplane(origin=(0, 0, 5))
    tool = outline.circle(20).extrude(20) if corner is None else outline.rect(44, 30).extrude(20)
    tool = tool if corner is None else tool.edges("|Z").fillet(corner)
    return cq.Workplane().box(60, 60, 40).cut(tool.faces("<Z").edges().fillet(RADIUS))


def boss():
    """A plate with a boss that is rounded into it."""
    plate = cq.Workplane().box(70, 50, 24).faces(">Z").workplane().circle(14).extrude(15)
    return plate.edges(cq.selectors.BoxSelector((-15, -15, 11), (15, 15, 13))).fillet(RADIUS)


def bored(block, height):
    return block.cut(cq.Workplane("XZ", origin=(0, 40, height)).circle(5).extrude(80))


SHAPES = {"round": pocket, "round corners": lambda: pocket(6.0), "ball": lambda: pocket(RADIUS), "boss": boss}


@pytest.mark.parametrize("name", SHAPES)
def test_an_outline_moves_to_where_its_rounding_stands_at_45_degrees(name):
    part = load(SHAPES[name]())
    solid = part.solids[0]
    rims = [rim for rim in find_outlines(solid, FLAT) if rim.normal[2] > 0.5]
    moved = [half_way(solid, rim, FLAT) for rim in rims]
    (rim,) = [rim for rim in moved if rim is not None]
    if rim.edges:
        at = np.linspace(0.05, 0.95, 7)
        points = np.concatenate([piece.curve.evaluate(at) for piece, _ in rim.edges])
        ends = np.array([piece.curve.evaluate(np.array([0.0, 1.0])) for piece, _ in rim.edges])
        assert np.allclose(ends[:, 1], np.roll(ends[:, 0], -1, axis=0), atol=1e-9 * solid.size)
    else:
        angles = np.linspace(0.0, 2.0 * np.pi, 12)
        around = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(12)])
        points = rim.center + rim.radius * around
    bare = [face for face in solid.faces if face.kind in {"cylinder", "torus", "sphere"}]
    for point in points:
        feet = [(face, face.surface.project(point[None])) for face in bare]
        on = [(f, uv) for f, uv in feet if np.linalg.norm(f.surface.evaluate(uv)[0] - point) < 1e-7 * solid.size]
        leans = [float(face.surface.normals(uv)[0] @ rim.normal) for face, uv in on]
        assert any(abs(lean - np.sqrt(0.5)) < 1e-6 for lean in leans)
    # What is lower lies on the plane that the rounding ends in.
    assert min(rim.inner, rim.outer) == pytest.approx(-(1.0 - np.sqrt(0.5)) * RADIUS / part.scale)


def test_a_floor_with_a_sharp_edge_keeps_its_outline():
    solid = load(cq.Workplane().box(30, 30, 20).faces(">Z").workplane().circle(8).cutBlind(-6)).solids[0]
    (rim,) = find_outlines(solid, FLAT)
    assert half_way(solid, rim, FLAT) is rim


@pytest.mark.parametrize(("shape", "height"), [(pocket, -9.0), (boss, -2.0)])
def test_cells_under_a_rounding_agree_and_meet_it_at_no_flat_edge(shape, height):
    part = load(bored(shape(), height))
    (boxes,) = around_features(part.solids[0], FLAT)
    cells = cut_cell(part, 0, boxes.tools)
    assert cells is not None
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(part.solids[0].volume, rel=1e-6)
    rounded = [(cell, face) for cell in cells.solids for face in cell.faces if face.kind == "torus"]
    assert min(cell.edges[e].dihedral for cell, face in rounded for e in face.edges) > np.radians(35)
    ways = [recognise(cell) for cell in cells.solids]
    assert all(ways)
    assert make_plan(cells, ways)
