"""Plane faces between lines and conics: areas and centroids known on paper."""

import math

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.brep import Loop
from cadsweep.cad.geometry.angles import n_touching


def faces_at(shape, z):
    return [f for f in cs.load(shape).solids[0].faces if f.kind == "plane" and abs(f.center[2] - z) < 1e-9]


def test_half_disc():
    half = cq.Workplane().moveTo(-3, 0).lineTo(3, 0).threePointArc((0, 3), (-3, 0)).close().extrude(1)
    (cap,) = faces_at(half, 1.0)
    assert cap.area == pytest.approx(math.pi * 9 / 2, rel=1e-14)
    np.testing.assert_allclose(cap.center, [0, 4 / math.pi, 1], atol=1e-14)


def test_eccentric_hole_far_from_the_origin():
    """A hole of radius r at distance d moves the centroid by -d r^2 pi / (area left)."""
    at = (1000.0, -500.0, 0.0)
    plate = cq.Workplane().box(20, 10, 2).faces(">Z").workplane().center(4, 0).circle(2).cutThruAll().translate(at)
    (cap,) = faces_at(plate, 1.0)
    left = 200 - 4 * math.pi
    assert cap.area == pytest.approx(left, rel=1e-14)
    np.testing.assert_allclose(cap.center - np.array(at), [-4 * 4 * math.pi / left, 0, 1], atol=1e-12)


def test_ellipse_and_volume():
    solid = cs.load(cq.Workplane().ellipse(5, 2).extrude(3)).solids[0]
    caps = [f for f in solid.faces if f.kind == "plane"]
    assert [f.area for f in caps] == pytest.approx([10 * math.pi] * 2, rel=1e-13)
    assert solid.volume == pytest.approx(30 * math.pi, rel=1e-9)


def crescents():
    """A disc whose boss, or whose hole, reaches its rim from inside: the face between them runs out to a point."""
    disc = cq.Workplane().circle(10).extrude(5)
    yield disc.union(cq.Workplane(origin=(4, 0, 5)).circle(6).extrude(6))
    flat = cq.Workplane().circle(8).extrude(30).union(cq.Workplane(origin=(0, 0, 30)).circle(11).extrude(10))
    yield flat.cut(cq.Workplane(origin=(18, 0, 35)).box(20, 40, 10))


def test_loops_that_touch_in_a_vertex_are_one_border():
    for shape in crescents():
        (solid,) = cs.load(shape).solids
        touching = [face for face in solid.faces if len(face.loops) == 2]
        assert [face.euler for face in touching] == [1], "an open crescent is a disc, not a ring"
        # Bodies without a tunnel are balls.
        assert len(solid.vertices) - len(solid.edges) + sum(face.euler for face in solid.faces) == 2


def test_each_vertex_in_which_loops_touch_counts():
    """A hole that reaches the rim in two places parts its face in two, which have no hole either."""
    ends = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [1, 4], [4, 1], [1, 2], [2, 1], [5, 6], [6, 5]])
    square, once, twice, apart = (
        Loop(edges=edges, forward=(True,) * len(edges), angles=(0.0,) * len(edges))
        for edges in ((0, 1, 2, 3), (4, 5), (6, 7), (8, 9))
    )
    assert [n_touching([square, *holes], ends) for holes in ([], [apart], [once], [twice], [once, twice])] == [
        0, 0, 1, 2, 3,
    ]  # fmt: skip
