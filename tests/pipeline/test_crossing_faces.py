"""What two boundaries that cross say of the CAD faces under them."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.blends.patches import PatchSurface
from cadsweep.pipeline.refusing import _is_folded, _nodes

pytestmark = pytest.mark.cad


def half_pipe():
    """The larger wall of a bored block, a half of it, and its radius in working units."""
    part = cs.load(cq.Workplane().box(8, 8, 6).faces(">Z").workplane().hole(4))
    solid = part.solids[0]
    return next(face for face in solid.faces if face.kind == "cylinder"), 2.0 / part.scale


def on_pipe(face, radius, angles, heights):
    """Corners (4, 3) of a quad on it, between two angles from its middle and two heights."""
    to = face.center * [1, 1, 0]
    first = np.arctan2(to[1], to[0])
    turns, levels = first + np.array(angles)[[0, 1, 1, 0]], np.array(heights)[[0, 0, 1, 1]]
    return np.column_stack([radius * np.cos(turns), radius * np.sin(turns), levels])


def test_quads_that_lie_over_each_other_on_one_face_do_not_say_that_it_crosses_itself():
    face, radius = half_pipe()
    quads = {name: on_pipe(face, radius, angles, (-0.1, 0.1)) for name, angles in (
        ("one", (-0.8, -0.1)), ("over it", (-0.5, 0.3)), ("beside it", (0.2, 0.9)))}  # fmt: skip
    assert _is_folded(face, np.stack([quads["one"], quads["over it"]]))
    assert not _is_folded(face, np.stack([quads["one"], quads["beside it"]]))


def test_facets_between_corners_lie_on_the_face_also_where_it_is_several_that_are_one():
    solid = cs.load(cq.Workplane().box(12, 8, 6).edges(">X and >Y").fillet(2)).solids[0]
    top, end, bend = (
        next(face for face in solid.faces if test(face))
        for test in (
            lambda face: face.normal[1] > 0.99 and face.kind == "plane",
            lambda face: face.normal[0] > 0.99 and face.kind == "plane",
            lambda face: face.kind == "cylinder",
        )
    )
    surface = PatchSurface(solid, [top.id, end.id, bend.id])
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    radius = 2.0 / solid.units.scale
    over = np.array([  # from the one plane to the other, over the bend
        [high[0] - 1.5 * radius, high[1], low[2]], [high[0], high[1] - 1.5 * radius, low[2]],
        [high[0], high[1] - 1.5 * radius, high[2]], [high[0] - 1.5 * radius, high[1], high[2]],
    ])  # fmt: skip
    found = _nodes(replace(top, surface=surface), over)
    assert surface.distance(found).max() < 1e-9
    assert (bend.surface.distance(found) < 1e-9).any()
