"""Ring nodes on edges and linking sides: what they promise on solids whose answer is known."""

import numpy as np
import pytest

from cadsweep.errors import InputError, SurfaceMeshError
from cadsweep.surface.sides import RingBuilder
from cadsweep.surface.spacing import fit_linear_parts, graded_places, place_layers
from cadsweep.surface.sweep_grid import build_grid
from cadsweep.sweep import Intervals

from .surface_shapes import count_segments, l_shape, polygon_prism, raised, square, torus_piece


def build_rings(sweep, intervals, **options):
    layout = build_grid(sweep, intervals)
    places = place_layers(sweep, layout, bias=options.get("bias"), fractions=options.get("fractions"))
    builder = RingBuilder(sweep, layout, places, fit_linear_parts)
    builder.build()
    return builder


def hole():
    return square(0.4)[::-1]


def test_every_node_has_a_place_and_every_quad_a_face():
    sweep = polygon_prism([square(), hole()], [raised(0), raised(1), raised(3)])
    builder = build_rings(sweep, count_segments(sweep, 4, [2, 3]))
    side_faces, node_edges, node_vertices = builder.layout.labels()
    assert builder.rings.shape == (6, 32, 3)
    assert np.isfinite(builder.rings).all()
    assert (side_faces >= 0).all()
    assert set(np.unique(side_faces)) == set(range(16))
    assert set(np.unique(node_vertices)) - {-1} == set(range(24))
    assert ((node_edges >= 0) | (node_vertices < 0)).all()


def test_vertices_are_met_bit_for_bit():
    sweep = polygon_prism([l_shape()], [raised(0), raised(2.1, [[1.3, 0.2], [0.1, 0.8]], (0.3, 0.1))])
    builder = build_rings(sweep, count_segments(sweep, 5, 7))
    _, _, node_vertices = builder.layout.labels()
    on = node_vertices >= 0
    assert np.array_equal(builder.rings[on], sweep.solid.vertices[node_vertices[on]])


def test_straight_sweep_is_the_source_ring_moved():
    sweep = polygon_prism([l_shape()], [raised(0), raised(2)])
    rings = build_rings(sweep, count_segments(sweep, [5, 3, 4, 2, 2, 6], 8)).rings
    moved = rings[0] + np.linspace(0, 2, 9)[:, None, None] * [0, 0, 1]
    assert np.abs(rings - moved).max() < 1e-14


def test_layers_of_an_affine_loft_are_affine_images_of_the_source_ring():
    matrix = np.array([[1.7, 0.4], [-0.3, 0.6]])
    sweep = polygon_prism([l_shape(), 0.2 * square()[::-1] + 0.5], [raised(0), raised(2, matrix, (1.0, -0.5))])
    rings = build_rings(sweep, count_segments(sweep, [5, 3, 4, 2, 2, 6, 1, 2, 1, 2], 6)).rings
    for k, t in enumerate(np.linspace(0, 1, 7)):
        image = rings[0, :, :2] @ ((1 - t) * np.eye(2) + t * matrix).T + t * np.array([1.0, -0.5])
        assert np.abs(rings[k] - np.column_stack([image, np.full(len(image), 2 * t)])).max() < 1e-12


def test_rings_of_a_bent_round_bar_are_rotations_of_the_source_ring():
    sweep = torus_piece(2.0)
    counts = np.array([10, 10, 10, 10, 12, 12])
    rings = build_rings(sweep, Intervals(counts=counts, n_layers=12, size=1.0)).rings
    for k, u in enumerate(np.linspace(0, 2.0, 13)):
        rotation = np.array([[np.cos(u), -np.sin(u), 0], [np.sin(u), np.cos(u), 0], [0, 0, 1]])
        assert np.abs(rings[k] - rings[0] @ rotation.T).max() < 1e-14


def test_a_layer_sits_on_every_station():
    sweep = polygon_prism([square()], [raised(0), raised(1), raised(1.5, shift=(1, 0)), raised(4, shift=(1, 0))])
    builder = build_rings(sweep, count_segments(sweep, 3, [3, 2, 4]), bias=3.0)
    for layer, height in ((0, 0), (3, 1), (5, 1.5), (9, 4)):
        assert np.abs(builder.rings[layer, :, 2] - height).max() < 1e-14


def test_bias_is_the_ratio_of_the_last_layer_to_the_first_in_each_span():
    sweep = polygon_prism([square()], [raised(0), raised(1), raised(3)])
    rings = build_rings(sweep, count_segments(sweep, 2, [4, 5]), bias=2.5).rings
    thickness = np.diff(rings[:, 0, 2])
    assert thickness[3] / thickness[0] == pytest.approx(2.5)
    assert thickness[8] / thickness[4] == pytest.approx(2.5)
    ratios = thickness[5:] / thickness[4:-1]
    assert ratios == pytest.approx(ratios[0])


def test_a_pair_of_biases_refines_both_ends():
    sweep = polygon_prism([square()], [raised(0), raised(1)])
    thickness = np.diff(build_rings(sweep, count_segments(sweep, 2, 9), bias=(4.0, 2.0)).rings[:, 0, 2])
    assert thickness[4] / thickness[0] == pytest.approx(4)
    assert thickness[4] / thickness[8] == pytest.approx(2)


def test_explicit_fractions_place_the_layers():
    sweep = polygon_prism([square()], [raised(0), raised(2, 1.5 * np.eye(2))])
    places = [0, 0.1, 0.15, 0.7, 1]
    rings = build_rings(sweep, count_segments(sweep, 3, 4), fractions=places).rings
    assert np.abs(rings[:, :, 2] - 2 * np.array(places)[:, None]).max() < 1e-14


@pytest.mark.parametrize("places", [[0, 0.5, 1], [0, 0.3, 0.3, 0.6, 1], [0.1, 0.3, 0.4, 0.6, 1]])
def test_fractions_that_are_no_places_are_refused(places):
    sweep = polygon_prism([square()], [raised(0), raised(2)])
    with pytest.raises(InputError, match="fractions must be 5 numbers"):
        build_rings(sweep, count_segments(sweep, 3, 4), fractions=places)


def test_a_loop_without_stations_follows_the_one_that_has_them():
    sweep = polygon_prism([square(), hole()], [raised(0), raised(1), raised(4)], merged=[(1, i) for i in range(4)])
    # The hole's rails keep their vertices at the middle level, its faces span both.
    builder = build_rings(sweep, count_segments(sweep, 2, [3, 3]), bias=2.0)
    heights = builder.rings[:, :, 2]
    assert np.abs(heights - heights[:, :1]).max() < 1e-14


def test_t_junctions_put_the_rows_of_whole_faces_between_divided_ones():
    sweep = polygon_prism([square()], [raised(0), raised(1), raised(3)], merged=[(0, 1)])
    assert sweep.stations == ()
    builder = build_rings(sweep, count_segments(sweep, 4, [2, 4]))
    side_faces, node_edges, _ = builder.layout.labels()
    assert len(set(side_faces[:, 4])) == 1
    assert len(set(side_faces[:, 0])) == 2
    assert (node_edges[2, [1, 9, 13]] >= 0).all()
    assert (node_edges[2, 5:8] == -1).all()
    assert np.abs(builder.rings[2, :, 2] - 1).max() < 1e-14


def test_a_layer_that_a_t_junction_holds_is_held_on_all_rails():
    # The junction stands at a third of the height, with two of five layers below it.
    sweep = polygon_prism([square()], [raised(0), raised(1), raised(3)], merged=[(0, 1), (0, 2)])
    heights = build_rings(sweep, count_segments(sweep, 4, [2, 3])).rings[:, :, 2]
    assert np.abs(heights - heights[:, :1]).max() < 1e-14
    assert heights[2, 0] == 1.0


def test_a_junction_far_from_its_layer_does_not_undo_the_bias():
    sweep = polygon_prism([square()], [raised(0), raised(1), raised(2)], merged=[(0, 1)])
    layout = build_grid(sweep, count_segments(sweep, 4, [4, 4]))
    places = place_layers(sweep, layout, bias=100.0, fractions=None)
    assert np.array_equal(places[0], graded_places(8, 100.0))


def test_nodes_of_a_twisted_prism_keep_their_order_on_every_row():
    c, s = np.cos(0.9), np.sin(0.9)
    sweep = polygon_prism([l_shape()], [raised(0), raised(5, [[c, -s], [s, c]])])
    rings = build_rings(sweep, count_segments(sweep, 6, 10)).rings
    for side in range(6):
        row = rings[:, 6 * side : 6 * side + 6]
        along = np.linalg.norm(np.diff(row, axis=1), axis=2)
        assert (along > 0.5 * along.mean(axis=1, keepdims=True)).all()


def test_counts_that_do_not_match_name_the_face():
    sweep = polygon_prism([square()], [raised(0), raised(1)])
    intervals = count_segments(sweep, 3, 2)
    intervals.counts[sweep.target_loops[0][1][0]] = 4
    with pytest.raises(SurfaceMeshError, match=r"face 1 .* 3 segments at the bottom and 4 at the top"):
        build_grid(sweep, intervals)


def test_sides_that_leave_a_gap_are_refused():
    from dataclasses import replace

    sweep = polygon_prism([square()], [raised(0), raised(1)])
    gap = replace(sweep, linking_sides=sweep.linking_sides[:3])
    with pytest.raises(SurfaceMeshError, match="do not tile the band"):
        build_grid(gap, count_segments(sweep, 3, 2))


def test_a_wrong_layer_count_is_refused():
    from dataclasses import replace

    sweep = polygon_prism([square()], [raised(0), raised(1)])
    with pytest.raises(SurfaceMeshError):
        build_grid(sweep, replace(count_segments(sweep, 3, 2), n_layers=3))
