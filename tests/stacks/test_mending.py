"""Quads of an arrangement that are flat on a level of the part, though fair in the plane."""

import numpy as np

from cadsweep.stacks.mending import _Quads


def work_on(places, quads, *, lines):
    """Quads of one cell with material on every level; `places` (levels, nodes, 2), nodes of `lines` fixed."""
    work = object.__new__(_Quads)
    work.places = np.array(places, dtype=float)
    work.quads = np.array(quads)
    work.cells = np.zeros(len(quads), dtype=np.int64)
    work.there = np.ones((len(work.places), len(quads)), dtype=bool)
    work.moves = np.zeros((work.places.shape[1], 2))
    work.fixed = np.isin(np.arange(work.places.shape[1]), lines)
    work.lines = {(min(a, b), max(a, b)) for a, b in zip(lines, np.roll(lines, -1).tolist(), strict=True)}
    work.around = {n: {q for q, own in enumerate(quads) if n in own} for n in range(work.places.shape[1])}
    work.changed = False
    return work


def test_an_edge_is_turned_where_a_corner_is_flat_on_another_level():
    # A hexagon 0 .. 5 in two quads; on the second level corner 5 lies on the line from 0 to 4.
    plane = [(0.0, 0.0), (1.0, -0.2), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (0.1, 0.9)]
    level = [(0.0, 0.0), (1.0, -0.2), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (0.5, 0.5)]
    work = work_on([plane, level], [[0, 1, 4, 5], [1, 2, 3, 4]], lines=[0, 1, 2, 3, 4, 5])
    before = work.worst([0, 1]).min()
    work.mend()
    assert before < 1e-9
    assert work.worst([0, 1]).min() > before + 0.02
    assert {5, 2} <= set(work.quads[0]) & set(work.quads[1])


def test_inner_nodes_move_alike_on_all_levels():
    ring = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    quads = [[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]]
    levels = [[*ring, (1.0, 1.0)], [*ring, (1.85, 1.9)]]
    work = work_on(levels, quads, lines=list(range(8)))
    apart = work.places[1, 8] - work.places[0, 8]
    before = work.worst(range(4)).min()
    work.mend()
    assert work.worst(range(4)).min() > before
    assert np.allclose(work.places[1, 8] - work.places[0, 8], apart)
    assert np.allclose(work.moves[:8], 0.0)


def test_fair_quads_are_left_alone():
    plane = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
    work = work_on([plane], [[0, 1, 4, 5], [1, 2, 3, 4]], lines=[0, 1, 2, 3, 4, 5])
    work.mend()
    assert not work.changed
