"""Cells of a planar complex cut by planes: nothing lost, and neighbours that agree."""

from collections import Counter
from math import sqrt

import numpy as np
import pytest

from cadsweep.decomposition.dividing import Plane, divide, divide_on

from .planar_shapes import hollow_box, unit_box


def plane(normal, offset):
    """A plane of any normal."""
    length = sqrt(sum(n * n for n in normal))
    return Plane(normal=tuple(n / length for n in normal), offset=offset / length)


def assert_agrees(pool, cells):
    """Every facet is on one cell, or on two from both sides; every edge of a cell has two of its facets."""
    uses = Counter(use for cell in cells for use in cell)
    assert set(uses.values()) == {1}
    for cell in cells:
        assert all(len(own) == 2 for own in pool.uses(cell).values())


def test_a_box_is_halved():
    pool, cell = unit_box()
    cells = divide(pool, (cell,), 0, plane((1, 0, 0), 0.25), -1)
    assert sorted(map(pool.volume, cells)) == pytest.approx([0.25, 0.75])
    assert sorted(map(len, cells)) == [6, 6]
    assert_agrees(pool, cells)


def test_a_plane_through_an_edge_makes_prisms():
    pool, cell = unit_box()
    cells = divide(pool, (cell,), 0, plane((1, -1, 0), 0.0), -1)
    assert [pool.volume(c) for c in cells] == pytest.approx([0.5, 0.5])
    assert sorted(map(len, cells)) == [5, 5]  # two triangles, two old sides, one new


def test_a_plane_that_touches_does_not_cut():
    pool, cell = unit_box()
    assert divide(pool, (cell,), 0, plane((1, 0, 0), 1.0), -1) is None
    assert divide(pool, (cell,), 0, plane((1, 1, 1), 3.0), -1) is None


def test_a_sliver_is_refused():
    pool, cell = unit_box()
    assert divide(pool, (cell,), 0, plane((1, 0, 0), 1e-4), -1) is None


def test_a_cut_divides_the_faces_of_its_neighbours():
    pool, cell = unit_box()
    low, high = divide(pool, (cell,), 0, plane((0, 0, 1), 0.5), -1)
    cells = divide(pool, (low, high), 0, plane((1, 0, 0), 0.5), -2)
    assert sorted(map(len, cells)) == [6, 6, 7]  # the shared face of the half not cut is two
    assert_agrees(pool, cells)


def test_a_cut_that_is_carried_on_divides_the_neighbours_with_their_faces():
    pool, cell = unit_box()
    cells = (cell,)
    for cut, height in ((-1, 0.25), (-2, 0.5)):
        largest = max(range(len(cells)), key=lambda j: pool.volume(cells[j]))
        cells = divide(pool, cells, largest, plane((0, 0, 1), height), cut)
    cells = divide_on(pool, cells, 0, plane((1, 0, 0), 0.5), -3)
    assert sorted(map(len, cells)) == [6] * 6  # no face of any of the three is imprinted
    assert sorted(map(pool.volume, cells)) == pytest.approx([0.125, 0.125, 0.125, 0.125, 0.25, 0.25])
    assert_agrees(pool, cells)


def test_a_cut_that_is_carried_on_ends_where_no_face_is_divided():
    pool, cell = unit_box()
    low, high = divide(pool, (cell,), 0, plane((0, 0, 1), 0.5), -1)
    cells = divide(pool, (low, high), 0, plane((1, 0, 0), 0.5), -2)
    whole = max(cells, key=pool.volume)
    number = next(j for j, one in enumerate(cells) if one is not whole)
    cells = divide_on(pool, cells, number, plane((0, 1, 0), 0.5), -3)
    assert len(cells) == 6  # the other half of the same layer and the whole one above are cut with it
    assert_agrees(pool, cells)


def test_a_void_stays_in_its_cell_and_is_opened_by_a_cut_through_it():
    pool, cell = hollow_box()
    assert pool.volume(cell) == pytest.approx(26.0)
    above = divide(pool, (cell,), 0, plane((0, 0, 1), 2.5), -1)
    assert sorted(map(pool.volume, above)) == pytest.approx([4.5, 21.5])
    assert sorted(map(len, above)) == [6, 12]
    through = divide(pool, (cell,), 0, plane((0, 0, 1), 1.5), -1)
    assert [pool.volume(c) for c in through] == pytest.approx([13.0, 13.0])
    new = [pool.facets[f] for f, _ in through[0] if pool.facets[f].origin < 0]
    assert len(new) == 1
    assert len(new[0].loops) == 2
    assert new[0].area == pytest.approx(8.0)


@pytest.mark.parametrize("cut_by", [divide, divide_on])
@pytest.mark.parametrize("seed", range(8))
def test_volume_is_kept_and_all_agree_whatever_is_cut(seed, cut_by):
    rng = np.random.default_rng(seed)
    pool, cell = hollow_box()
    cells = (cell,)
    volume = pool.volume(cell)
    n_cut = 0
    for cut in range(12):
        normal = rng.normal(size=3) if seed % 2 else np.eye(3)[rng.integers(3)]
        through = rng.uniform(0.5, 2.5, size=3)
        found = cut_by(pool, cells, int(rng.integers(len(cells))), plane(normal, normal @ through), -1 - cut)
        if found is None:
            continue
        n_cut += 1
        cells = found
        assert sum(map(pool.volume, cells)) == pytest.approx(volume, rel=1e-12)
        assert_agrees(pool, cells)
    assert len(cells) > n_cut >= 3
