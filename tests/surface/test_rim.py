"""Rows of quads along a rim: they close, stand square on it, and leave the rest to be filled."""

import numpy as np
import pytest

from cadsweep.surface.rim import lay_rows


def circle(radius, n):
    """A regular polygon, counter-clockwise."""
    angle = 2 * np.pi * np.arange(n) / n
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def rectangle(width, height, across, up):
    """A rectangle with nodes on its sides, counter-clockwise from its lower left corner."""
    s, t = np.arange(across) / across * width, np.arange(up) / up * height
    return np.concatenate(
        [
            np.stack([s, 0 * s], axis=1),
            np.stack([width + 0 * t, t], axis=1),
            np.stack([width - s, height + 0 * s], axis=1),
            np.stack([0 * t, height - t], axis=1),
        ]
    )


def flat(places):
    """Normals of a plane."""
    return np.tile([0.0, 0.0, 1.0], (len(places), 1))


def signed_area(polygon):
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def areas(points, quads):
    return np.array([signed_area(points[quad]) for quad in quads])


def test_rows_and_the_rest_cover_the_polygon():
    loops = [circle(5.0, 40), circle(2.0, 20)[::-1]]
    inner, quads, left = lay_rows(loops, [True, True], flat)
    points = np.concatenate([*loops, inner])
    covered = areas(points, quads)
    assert (covered > 0).all()
    whole = sum(signed_area(loop) for loop in loops)
    assert np.isclose(covered.sum() + sum(signed_area(points[loop]) for loop in left), whole, rtol=1e-12)
    # One quad for every segment, one inner node for every node.
    assert len(quads) == 60
    assert len(inner) == 60


def test_row_turns_a_corner_with_one_quad():
    loop = rectangle(6.0, 4.0, 12, 8)
    inner, quads, left = lay_rows([loop], [True], flat)
    uses = np.bincount(quads.ravel(), minlength=len(loop))[: len(loop)]
    assert sorted(uses.tolist()) == [1] * 4 + [2] * 36
    # Two nodes less for each corner.
    assert len(left[0]) == len(inner) == len(loop) - 8
    assert np.isclose(areas(np.concatenate([loop, inner]), quads).min(), 0.25)


def test_loop_that_is_not_smooth_stays():
    loops = [circle(5.0, 40), circle(2.0, 20)[::-1]]
    _, quads, left = lay_rows(loops, [True, False], flat)
    assert (left[1] == 40 + np.arange(20)).all()
    assert len(quads) == 40


def test_row_is_deep_enough_to_turn():
    # A dome of radius 1 whose rim leans by 45 degrees, finely divided.
    loop = circle(np.sin(np.pi / 4), 200)

    def dome(places):
        return np.column_stack([places, np.sqrt(1 - (places**2).sum(axis=1))])

    inner, _, _ = lay_rows([loop], [True], dome)
    turned = np.arccos((dome(inner) * dome(loop)).sum(axis=1))
    chord = 2 * np.sin(np.pi / 4) * np.sin(np.pi / 200)
    assert (turned > 2 * chord).all()
    assert (turned < np.pi / 8 + chord).all()


def test_no_room_for_rows():
    assert lay_rows([circle(5.0, 12), circle(4.9, 12)[::-1]], [True, True], flat) is None


def borders(cells):
    """Edges of polygons that one of them alone has."""
    edges = {}
    for cell in cells:
        for pair in zip(cell, np.roll(cell, -1), strict=True):
            key = tuple(sorted(map(int, pair)))
            edges[key] = edges.get(key, 0) + 1
    assert max(edges.values()) <= 2
    return {edge for edge, uses in edges.items() if uses == 1}


@pytest.mark.parametrize("across", range(1, 7))
@pytest.mark.parametrize("up", range(1, 7))
def test_the_border_of_rows_and_rest_is_the_polygon(across, up):
    """Also of a few segments, where corners stand too near to each other for rows between them."""
    loop = rectangle(6.0, 6.0, across, up)
    found = lay_rows([loop], [True], flat)
    assert (found is None) <= (min(across, up) < 4)
    if found is not None:
        _, quads, left = found
        assert borders([*quads.tolist(), *left]) == borders([np.arange(len(loop))])
