"""Logical corners of faces."""

import numpy as np

from cadsweep.recognition.corners import read_rectangles, why_no_rectangle

from .recognition_solids import bevelled_bar, box, plate_with_square_holes, polyhedron, prism, regular, sharp_bracket


def test_rectangle_has_one_reading_of_no_cost():
    for face in box().faces:
        (reading,) = read_rectangles(face)
        assert [len(chain) for chain in reading.chains] == [1, 1, 1, 1]
        assert reading.cost < 1e-12


def test_straight_vertex_is_no_corner():
    outline = np.array([[0, 0], [1, 0], [2, 0], [2, 1], [0, 1]])
    (reading,) = read_rectangles(prism(outline).faces[1])
    assert sorted(len(chain) for chain in reading.chains) == [1, 1, 1, 2]


def test_pentagon_keeps_both_choices():
    readings = read_rectangles(bevelled_bar().faces[0])
    assert len(readings) == 2
    assert abs(readings[0].cost - readings[1].cost) < 1e-9


def test_chains_follow_the_loop_and_use_every_edge_once():
    for solid in (bevelled_bar(), sharp_bracket()):
        for face in solid.faces:
            for reading in read_rectangles(face, folded=True):
                edges = [e for chain in reading.chains for e in chain]
                turn = face.loops[0].edges.index(edges[0])
                assert tuple(edges) == face.loops[0].edges[turn:] + face.loops[0].edges[:turn]


def test_l_shape_is_a_rectangle_only_when_folds_are_allowed():
    face = sharp_bracket().faces[0]
    assert read_rectangles(face) == ()
    assert len(read_rectangles(face, folded=True)) == 5
    assert "re-entrant" in why_no_rectangle(face)


def test_holes_triangles_and_rounds_are_no_rectangles():
    plate = plate_with_square_holes(1)
    assert read_rectangles(plate.faces[0]) == ()
    assert "1 hole" in why_no_rectangle(plate.faces[0])
    triangle = prism(regular(3)).faces[0]
    assert read_rectangles(triangle) == ()
    assert "3 corners" in why_no_rectangle(triangle)
    assert read_rectangles(prism(regular(12)).faces[0]) == ()
    assert read_rectangles(prism(regular(40)).faces[0]) == ()


def test_box_pyramid_frustum_angles_cost_their_deviation():
    top, bottom = 0.5, 1.0
    points = [[x, y, z] for z, r in ((0, bottom), (1, top)) for x, y in ((-r, -r), (r, -r), (r, r), (-r, r))]
    faces = [[[3, 2, 1, 0]], [[4, 5, 6, 7]], *([[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i]] for i in range(4))]
    (reading,) = read_rectangles(polyhedron(points, faces).faces[2])
    slope = np.arctan2(bottom - top, np.hypot(1.0, bottom - top))
    assert np.isclose(reading.cost, 4 * slope / (np.pi / 2))
