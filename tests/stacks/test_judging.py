"""What is said of the quads of an arrangement before hexahedra are made, and of outlines that cross."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.mesh import QuadMesh
from cadsweep.pipeline.columns.stacking import find_stacks
from cadsweep.stack import Levels
from cadsweep.stacks import judge_plane
from cadsweep.stacks.outline_crossings import n_crossings


class Drawn:
    """Polylines (m, 2) as the edges of a graph of one cell."""

    def __init__(self, *courses):
        self.courses = [np.array(course, dtype=float) for course in courses]
        self.cell = {2 * e + side: 0 for e in range(len(courses)) for side in (0, 1)}

    def samples(self, e):
        return self.courses[e]


@pytest.mark.parametrize(
    ("other", "found"),
    [
        ([(1, -1), (1, 1)], 1),  # across
        ([(0.5, -1), (1, 1), (1.5, -1)], 2),  # there and back
        ([(1, 0), (1, 1)], 0),  # it begins on the line
        ([(2, 0), (3, 1)], 0),  # it goes on from the line's end
        ([(0.5, 0), (1.5, 0)], 0),  # along the line
        ([(3, -1), (3, 1)], 0),  # past its end
    ],
)
def test_lines_cross_where_each_has_ends_on_both_sides_of_the_other(other, found):
    graph = Drawn([(0, 0), (2, 0)], other)
    assert n_crossings(graph, {0}, {0}) == found
    assert n_crossings(graph, {1}, {0}) == found


def test_edges_of_other_cells_are_not_asked():
    graph = Drawn([(0, 0), (2, 0)], [(1, -1), (1, 1)])
    graph.cell = {0: 0, 1: 0, 2: 1, 3: 1}
    assert n_crossings(graph, {0}, {0}) == 0
    assert n_crossings(graph, {0}, {0, 1}) == 1


@pytest.fixture(scope="module")
def bossed():
    """A plate with a boss on it: two cells, the boss's a square of four right corners."""
    part = cq.Workplane().box(6, 6, 1).union(cq.Workplane().box(2, 2, 2, centered=(True, True, False)))
    return next(s for s in find_stacks(cs.load(part)) if abs(s.direction[2]) > 0.9)


def planar(stack, cell_corners):
    """Two quads in the boss's cell over a rectangle of 2 by 2 that share an edge from the bottom to the top."""
    prism = stack.arrangement.prism
    boss = min(stack.arrangement.bottoms, key=lambda f: np.ptp(prism.vertices[vertices_of(prism, f)], axis=0).max())
    up = stack.direction[2] > 0
    x = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), *cell_corners], dtype=float)
    points = np.column_stack([x, np.zeros(6)])
    quads = np.array([[0, 4, 5, 3], [4, 1, 2, 5]])
    lines = {e: np.zeros(0, dtype=np.int64) for e in stack.arrangement.over}
    for e in prism.faces[boss].edges:
        ends = prism.vertices[[prism.edges[e].start, prism.edges[e].end]][:, :2]
        corners = [int(np.argmin(np.linalg.norm(x[:4] - end, axis=1))) for end in ends]
        between = {frozenset((0, 1)): 4, frozenset((2, 3)): 5}.get(frozenset(corners))
        lines[e] = np.array([corners[0], *([] if between is None else [between]), corners[1]])
    mesh = QuadMesh(
        points=points, quads=quads if up else quads[:, ::-1], faces=np.full(2, boss), loops=(), edge_nodes=lines
    )
    return mesh, set(prism.faces[boss].edges)


def vertices_of(prism, f):
    return [v for e in prism.faces[f].edges for v in (prism.edges[e].start, prism.edges[e].end)]


LEVELS = Levels(caps={}, heights=np.arange(3.0))


def test_right_quads_lack_nothing(bossed):
    mesh, _ = planar(bossed, [(0, -1), (0, 1)])
    judged = judge_plane(bossed, LEVELS, mesh)
    assert (judged.poor, judged.around, judged.lacking) == (set(), set(), 0.0)
    assert judged.worst == pytest.approx(1.0)


def test_a_sheared_quad_lacks_what_its_cell_would_allow(bossed):
    # The inner edge runs 1.8 aside over a height of 2.
    mesh, _ = planar(bossed, [(-0.9, -1), (0.9, 1)])
    judged = judge_plane(bossed, LEVELS, mesh)
    assert judged.worst == pytest.approx(1 / np.sqrt(1 + 0.9**2))
    assert judged.poor == set()  # poor begins at 0.35


def test_a_folded_quad_names_the_outlines_around_it(bossed):
    mesh, around = planar(bossed, [(-3.0, -1), (0, 1)])
    judged = judge_plane(bossed, LEVELS, mesh)
    assert judged.worst < 0
    assert judged.around == around
    assert judged.poor <= around
    assert judged.poor
    # One cell lacks: what it should have (0.35, below 0.9 of a right angle's sine) less what it has.
    assert judged.lacking == pytest.approx(0.35 - judged.worst)
