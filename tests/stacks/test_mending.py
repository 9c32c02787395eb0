"""Quads of an arrangement that are flat on a level of the part, though fair in the plane."""

import numpy as np
import pytest

from cadsweep.mesh import QuadMesh
from cadsweep.stacks.mending import _Quads


def work_on(places, quads, *, loop):
    """Quads of one cell with material on every level; `places` (levels, nodes, 2), nodes of the `loop` fixed."""
    places = np.array(places, dtype=float)
    return _Quads(
        points=np.column_stack([places[0], np.zeros(len(places[0]))]),
        quads=np.array(quads),
        cells=np.zeros(len(quads), dtype=np.int64),
        places=places,
        there=np.ones((len(places), len(quads)), dtype=bool),
        lines=[np.array([*loop, loop[0]])],
        frame=np.eye(3)[:2],
    )


def all_alive(work):
    return np.flatnonzero(work.alive[: work.n_quads])


def areas(work):
    """Area (levels, quads) of what is there."""
    x, y = np.moveaxis(work.places[:, work.quads[all_alive(work)]], -1, 0)
    return 0.5 * (x * np.roll(y, -1, axis=-1) - np.roll(x, -1, axis=-1) * y).sum(axis=-1)


def test_an_edge_is_turned_where_a_corner_is_flat_on_another_level():
    # A hexagon 0 .. 5 in two quads; on the second level corner 5 lies on the line from 0 to 4.
    plane = [(0.0, 0.0), (1.0, -0.2), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (0.1, 0.9)]
    level = [(0.0, 0.0), (1.0, -0.2), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (0.5, 0.5)]
    work = work_on([plane, level], [[0, 1, 4, 5], [1, 2, 3, 4]], loop=range(6))
    before = work.worst([0, 1]).min()
    work.mend()
    assert before < 1e-9
    assert work.worst(all_alive(work)).min() > before + 0.02


BESIDE = {
    "a free node across": ([(1, 1), (0, 1.2), (-1, 1), (0, 0.6)], [[0, 1, 2, 6], [2, 3, 4, 6], [0, 6, 4, 5]], range(6)),
    "no free node": ([(0, 1.5)], [[0, 1, 2, 3]], range(4)),
}


@pytest.mark.parametrize("bulge", [0.0, 0.15])
@pytest.mark.parametrize("case", BESIDE)
def test_two_sides_of_a_quad_that_an_outline_draws_straight_are_parted(case, bulge):
    # Node 1 is between 0 and 2 on a line that is straight on level 1, or bends into the quad there.
    beside, quads, loop = BESIDE[case]
    plane, level = ([(-1.0, 0.0), (0.0, y), (1.0, 0.0), *beside] for y in (-0.6, bulge))
    work = work_on([plane, level], quads, loop=loop)
    whole = areas(work).sum(axis=1)
    assert work.worst([0]).min() <= 1e-9
    work.mend()
    assert work.worst(all_alive(work)).min() > 0.2
    assert np.allclose(areas(work).sum(axis=1), whole)


@pytest.mark.parametrize("slope", [0.1, 0.2, 0.4])
def test_the_tip_of_a_wedge_between_lines_is_as_good_as_its_angle(slope):
    # Node 1 lies on the line from the tip 0 to 2 on level 1; the wedge's other line goes through 3 and 5.
    plane, level = ([(0, 0), (1, y), (2, 0), (1, slope), (2.2, slope), (2, 2 * slope)] for y in (-0.3, 0.0))
    work = work_on([plane, level], [[0, 1, 2, 3], [2, 4, 5, 3]], loop=[0, 1, 2, 4, 5, 3])
    whole = areas(work).sum(axis=1)
    assert work.worst([0]).min() <= 1e-9
    work.mend()
    assert work.worst(all_alive(work)).min() == pytest.approx(np.sin(np.arctan(slope)))
    assert np.allclose(areas(work).sum(axis=1), whole)


def test_what_is_divided_otherwise_is_one_mesh_with_the_same_lines():
    beside, quads, loop = BESIDE["a free node across"]
    # Nodes of lines come after a free one: their numbers change when that goes.
    order = [6, 0, 1, 2, 3, 4, 5]
    number = np.argsort(order)
    places = np.array([[(-1.0, 0.0), (0.0, y), (1.0, 0.0), *beside] for y in (-0.6, 0.0)])[:, order]
    quads = number[np.array(quads)]
    work = work_on(places, quads, loop=number[list(loop)])
    assert work.mend()
    points = np.column_stack([places[0], np.zeros(7)])
    line = number[[0, 1, 2]]
    mesh = work.mended(
        QuadMesh(points=points, quads=quads, faces=np.zeros(3, dtype=np.int64), loops=(line,), edge_nodes={0: line})
    )
    assert np.array_equal(mesh.points[mesh.edge_nodes[0]], points[line])
    assert np.array_equal(mesh.points[mesh.loops[0]], points[line])
    assert np.array_equal(np.unique(mesh.quads), np.arange(len(mesh.points)))
    assert len(mesh.faces) == len(mesh.quads)


def test_inner_nodes_move_alike_on_all_levels():
    ring = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    quads = [[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]]
    levels = [[*ring, (1.0, 1.0)], [*ring, (1.85, 1.9)]]
    work = work_on(levels, quads, loop=range(8))
    apart, start = work.places[1, 8] - work.places[0, 8], work.points[:8].copy()
    before = work.worst(range(4)).min()
    work.mend()
    assert work.worst(all_alive(work)).min() > before
    assert np.allclose(work.places[1, 8] - work.places[0, 8], apart)
    assert np.array_equal(work.points[:8], start)


def test_fair_quads_are_left_alone():
    plane = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
    work = work_on([plane], [[0, 1, 4, 5], [1, 2, 3, 4]], loop=range(6))
    assert not work.mend()
