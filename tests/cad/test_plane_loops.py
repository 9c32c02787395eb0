"""Outlines that touch nothing give the cells that OpenCASCADE makes of them, without its fuse and its face builder."""

import cadquery as cq
import numpy as np
import pytest
from OCP.Geom import Geom_Plane
from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt

import cadsweep as cs
from cadsweep.cad.edit import arrangement, plane_loops
from cadsweep.cad.extract.shared import read_edge_curves
from cadsweep.cad.geometry.plane_curves import PlaneCurves, near_pairs
from cadsweep.cad.shapes import EDGE, subshapes
from cadsweep.pipeline.columns.stacking import find_stacks

PLANE = Geom_Plane(gp_Pln(gp_Ax3(gp_Pnt(1, 2, 3), gp_Dir(1, 2, 2))))
AXES = np.eye(2, 3)


def drawn():
    work = cq.Workplane(cq.Plane((1, 2, 3), normal=(1, 2, 2)))
    wave = [(-3, 0), (-1, 2.5), (2, 1), (3, -2), (0, -3)]
    return {
        "frame": work.rect(40, 20),
        "ring": work.center(-8, 1).circle(6),
        "ellipse": work.center(-8, 1).ellipse(4, 2, 30),
        "island": work.center(-8, 1).slot2D(2, 0.5),
        "wave": work.center(8, 0).spline(wave, periodic=True).wire(),
        "in the wave": work.center(8, 0).polygon(6, 1),
        "outside": work.center(40, 0).circle(3),
    }


def lines_of(*outlines):
    return [edge for outline in outlines for wire in outline.wires().vals() for edge in subshapes(wire.wrapped, EDGE)]


def curves_of(edges):
    return [curve for curve, _ in read_edge_curves(edges)]


def branching_lines():
    """Two rectangles with a common side."""
    work = cq.Workplane(cq.Plane((1, 2, 3), normal=(1, 2, 2))).center(-8, 8)
    one, other = (cq.Face.makeFromWires(work.center(x, 0).rect(3, 1).wires().val()) for x in (0, 3))
    return subshapes(one.fuse(other).wrapped, EDGE)


def cells_as_sets(cells):
    return {frozenset(frozenset(wire) for wire in cell.wires) for cell in cells}


@pytest.mark.parametrize("branching", [False, True])
def test_cells_are_opencascades(branching, monkeypatch):
    outlines = drawn()
    edges = lines_of(*outlines.values())
    if branching:
        edges += branching_lines()
    curves = curves_of(edges)
    cells = plane_loops.find_cells(edges, curves, PLANE)
    assert len(cells) == len(outlines) + 2 * branching
    monkeypatch.setattr(plane_loops, "_simple_loops", lambda *_: {})
    theirs = plane_loops.find_cells(edges, curves, PLANE)
    assert cells_as_sets(cells) == cells_as_sets(theirs)
    axes, origin = plane_loops.plane_frame(PLANE)
    flat = PlaneCurves(curves, axes, origin)
    for cell in cells:
        uses = [use for wire in cell.wires for use in wire]
        senses = np.array([1.0 if left else -1.0 for _, left in uses])
        place = (cell.place - origin) @ axes.T
        turns = flat.turns(place[None], np.zeros(len(uses), dtype=int), np.array([j for j, _ in uses]), senses)
        assert turns.tolist() == [1.0], "the place of a cell lies in it, and in none of its holes"


def test_a_circle_turns_once_round_its_inside():
    curves = curves_of(lines_of(cq.Workplane().circle(2), cq.Workplane().circle(1)))
    flat = PlaneCurves(curves, AXES, np.zeros(3))
    points = np.array([[0.0, 0.0], [1.5, 0.0], [1.0 - 1e-9, 0.0], [0.0, 2.0 + 1e-9], [0.0, 1.0]])
    both = np.tile(np.arange(2), len(points))
    turns = flat.turns(points, np.repeat(np.arange(len(points)), 2), both, np.ones(len(both)))
    np.testing.assert_array_equal(np.abs(turns), [2.0, 1.0, 2.0, 0.0, np.nan])


@pytest.mark.parametrize("gap", [1e-3, 1e-5])
def test_curves_closer_than_the_reach_touch(gap):
    wave = [(0, 0), (3, 2), (6, -1), (9, 0)]
    spline = cq.Edge.makeSpline([cq.Vector(*p) for p in wave])
    top = max(spline.positionAt(t).y for t in np.linspace(0, 1, 20001))
    others = [
        cq.Edge.makeLine(cq.Vector(-1, top + gap), cq.Vector(10, top + gap)),
        cq.Edge.makeCircle(1, cq.Vector(-1 - gap, 0)),
        cq.Edge.makeLine(cq.Vector(4, -9), cq.Vector(4, 9)),
    ]
    curves = curves_of([edge.wrapped for edge in (spline, *others)])
    flat = PlaneCurves(curves, AXES, np.zeros(3))
    pairs = np.array([(0, 1), (0, 2), (0, 3)])
    assert flat.touching(pairs, 0.4 * gap).tolist() == [False, False, True]
    assert flat.touching(pairs, 1.1 * gap).tolist() == [True, True, True]


def test_near_boxes_are_those_that_meet():
    rng = np.random.default_rng(3)
    low = rng.uniform(0, 10, (2, 60, 2))
    one, other = (np.stack([own, own + rng.uniform(0, 2, own.shape)], axis=1) for own in low)
    apart = np.maximum(one[:, None, 0] - other[None, :, 1], other[None, :, 0] - one[:, None, 1]).max(axis=2)
    found = near_pairs(one, other, 0.3)
    assert set(map(tuple, found.tolist())) == set(zip(*np.nonzero(apart <= 0.3), strict=True))


def plate():
    """Bosses and pockets apart, a bored boss, and on the far side a pocket that goes under two of them."""
    work = cq.Workplane().box(40, 20, 4).faces(">Z").workplane()
    work = work.pushPoints([(-14, 0), (-6, 0)]).circle(2.5).extrude(2)
    work = work.faces(">Z").workplane().pushPoints([(-14, 0)]).hole(2)
    work = work.faces("<Z").workplane(origin=(10, 0, -2)).rect(8, 8).cutBlind(-1)
    work = work.faces(">Z[-2]").workplane(origin=(10, 0, 2)).rect(4, 4).cutBlind(-1)
    return work.faces("<Z").workplane(origin=(-6, 5, -2)).circle(4).cutBlind(-1)


def test_what_touches_nothing_needs_no_fuse(monkeypatch):
    part = cs.load(plate())
    fused = []
    divide = arrangement._fused
    monkeypatch.setattr(arrangement, "_fused", lambda lines, reach: fused.append(len(lines)) or divide(lines, reach))
    stack = find_stacks(part)[0]
    # Two halves each of the boss and of the pocket that crosses under its edge; in other directions there is no stack.
    assert fused == [4]
    monkeypatch.setattr(arrangement, "lines_apart", lambda solid, sides, over, *_: np.zeros(len(over), dtype=bool))
    whole = find_stacks(part)[0]

    def described(own):
        faces = own.arrangement.prism.faces
        areas = [round(faces[f].area, 6) for f in own.arrangement.bottoms]
        return sorted(zip(areas, map(sorted, own.arrangement.caps), strict=True))

    assert described(stack) == described(whole)
