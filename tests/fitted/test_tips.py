"""Tips that no quad fits into: faces end before them, every node stays on the model, and it is told how far."""

import re

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import NotSweepableError
from cadsweep.fitted import end_before, find_tips
from cadsweep.pipeline.fitted_grids import ENDING
from cadsweep.quality import measure_hexes

SIZE = 1.5


def plate():
    """A plate whose outline has a straight edge and an arc that leave a corner side by side, at 5 degrees."""
    return cq.Workplane().lineTo(20, 0).lineTo(20, 12.96).threePointArc((14, 5.69), (0, 0)).close().extrude(6)


def angles_of(solid):
    found = {}
    for face in solid.faces:
        for loop in face.loops:
            for directed, angle in zip(loop.directed, loop.angles, strict=True):
                place = solid.first_vertex(directed), face.id
                found[place] = found.get(place, 0.0) + angle
    return found


@pytest.fixture(scope="module")
def tipped():
    """The solid, its tips, and the size."""
    solid = cs.load(plate()).solids[0]
    size = SIZE / 22 * solid.size
    return solid, find_tips(solid, angles_of(solid), size), size


def test_both_ends_of_a_thin_corner_are_tips_and_no_other_vertex_is(tipped):
    solid, tips, _ = tipped
    at = solid.vertices[[tip.vertex for tip in tips]]
    corner = np.linalg.norm(solid.vertices - solid.vertices[tips[0].vertex], axis=1)
    assert len(tips) == 2
    assert np.ptp(at, axis=0)[:2] == pytest.approx(0.0)  # above each other
    assert (corner > 0).sum() == len(solid.vertices) - 1


def test_a_face_ends_on_one_edge_where_the_other_is_far_enough(tipped):
    solid, tips, size = tipped
    for tip in tips:
        assert len(tip.fractions) == 2
        apart = sorted(
            float(np.linalg.norm(solid.edges[e].curve.nearest(tip.place[None])[0] - tip.place)) for e in tip.fractions
        )
        assert apart[0] < 1e-9
        assert 0.1 * size < apart[1] < 0.3 * size


def test_a_place_where_a_tip_ends_is_on_every_face_that_had_the_vertex(tipped):
    solid, tips, _ = tipped
    ended = end_before(solid, tips)
    for tip in tips:
        here = {f for e in solid.edges if tip.vertex in (e.start, e.end) for f in e.faces}
        assert all(ended.faces[f].surface.distance(tip.place[None])[0] < 1e-9 for f in here)
        assert (ended.vertices[tip.vertex] == tip.place).all()
        away = tip.place[None] + 0.01
        for f in tip.others:
            assert ended.faces[f].surface.distance(away) <= solid.faces[f].surface.distance(away) + 1e-12


def test_the_mesh_is_valid_and_says_how_far_it_ends_before_the_tip():
    mesh = cs.sweep_mesh(plate(), fitted=True, size=SIZE)
    assert measure_hexes(mesh.points, mesh.hexes).scaled_jacobian.min() >= 0.1
    assert ENDING in mesh.record.rows
    (note,) = [note for note in mesh.record.notes if "tips" in note]
    told = float(re.search(r"up to ([\d.]+) before", note)[1])
    nearest = np.linalg.norm(mesh.points - [0, 0, 0], axis=1).min()
    assert nearest == pytest.approx(told, rel=0.01)


@pytest.mark.parametrize("options", [{"without": [ENDING]}, {"tolerance": 0.5}])
def test_no_face_ends_before_its_tip_where_that_is_not_wanted(options):
    with pytest.raises(NotSweepableError):  # a quad that reaches into the tip is flat
        cs.sweep_mesh(plate(), fitted=True, size=SIZE, **options)
