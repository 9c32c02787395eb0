"""No mesh that runs into itself is valid; sheets that touch from outside, or are near, are not called crossing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from cadsweep.mesh import HexMesh
from cadsweep.quality import check_mesh, find_crossings

from .quality_meshes import UNIT_CUBE, raised, swept_block, without_structure


def coil(pitch, turns=2.5):
    """Layers of a coil of 24 layers a turn: section 1 x 1, radius 4."""

    def place(k, xy):
        t = 2 * np.pi * k / 24
        radius, height = 4 + xy[:, 0] / 4, xy[:, 1] / 3 + pitch * k / 24
        return np.c_[radius * np.cos(t), -radius * np.sin(t), height]

    return swept_block(4, 3, round(24 * turns), place=place)


@pytest.mark.parametrize("structured", [True, False])
def test_a_coil_whose_turns_meet_is_not_valid_and_says_where(structured):
    mesh = coil(0.8) if structured else without_structure(coil(0.8))
    report = check_mesh(mesh)
    assert report.n_inverted == 0
    assert len(report.problems) == 1
    assert "runs into itself" in report.problems[0]
    assert "'side' crosses itself" in report.problems[0]
    x, y, z = report.crossings[0].place
    assert 3.9 < np.hypot(x, y) < 5.1  # where the coil is
    assert 0.5 < z < 0.8 * 1.5 + 1.0  # and where it has two turns


def test_a_coil_whose_turns_touch_or_keep_apart_is_valid():
    assert check_mesh(coil(1.001)).valid
    # Turns of the same nodes: touching, which another check than that of crossings speaks of.
    assert check_mesh(coil(1.0)).crossings == ()


def random_parallelograms(rng, n, spread):
    """Flat quads (n, 4, 3) of size 1 with centres within a cube of size `spread`."""
    center, u, v = rng.uniform(0, spread, (n, 3)), rng.normal(size=(n, 3)), rng.normal(size=(n, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v -= 0.7 * u * np.sum(u * v, axis=1, keepdims=True)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    return np.stack([center, center + u, center + u + v, center + v], axis=1)


def have_common_point(one, other):
    """Whether two convex hulls meet, by linear programming: the other way of finding out."""
    equal = np.vstack([np.hstack([one.T, -other.T]), [[1] * 4 + [0] * 4], [[0] * 4 + [1] * 4]])
    return linprog(np.zeros(8), A_eq=equal, b_eq=[0, 0, 0, 1, 1], bounds=(0, 1)).status == 0


def test_flat_quads_cross_where_linear_programming_says_so():
    quads = random_parallelograms(np.random.default_rng(4), 40, 3.0)
    pairs, _ = find_crossings(quads.reshape(-1, 3), np.arange(160).reshape(-1, 4))
    expected = {(i, j) for j in range(40) for i in range(j) if have_common_point(quads[i], quads[j])}
    assert 10 < len(expected) < 32  # as many as are looked for at least
    assert set(map(tuple, pairs.tolist())) == expected


def test_crossings_do_not_depend_on_place_scale_and_order():
    rng = np.random.default_rng(8)
    quads = random_parallelograms(rng, 40, 3.0)
    pairs, places = find_crossings(quads.reshape(-1, 3), np.arange(160).reshape(-1, 4))
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shuffled = rng.permutation(40)
    moved = 1e3 * (quads[shuffled] @ turn.T) + [5e4, -3e4, 1e4]
    again, there = find_crossings(moved.reshape(-1, 3), np.arange(160).reshape(-1, 4))
    assert {frozenset(pair) for pair in shuffled[again].tolist()} == {frozenset(pair) for pair in pairs.tolist()}
    assert len(places) == len(there) > 5


def saddle(lift, bend):
    """A quad on z = lift + bend * x * y over the unit square."""
    return np.array([[0, 0, lift], [1, 0, lift], [1, 1, lift + bend], [0, 1, lift]], dtype=float)


@pytest.mark.parametrize(("one", "other", "cross"), [
    (saddle(0, 1), saddle(0.01, 1), False),  # their hulls have nearly all in common
    (saddle(0, 1), saddle(0.3, -1), True),
    (saddle(0, 1), saddle(0, -1) - [0, 0, 1e-3], False),
    (saddle(0, 0), saddle(0.24, -1) + [0, 0, 0.005], True),  # dips through in a corner alone
    (saddle(0, 0), saddle(0, 0)[[1, 0, 3, 2]] + [0.3, 0.2, 0], False),  # in one plane, back to back: they touch
    (saddle(0, 1), saddle(0, 1)[::-1], False),  # on each other, as at a contact
])  # fmt: skip
def test_bilinear_quads_are_looked_at_exactly(one, other, cross):
    pairs, places = find_crossings(np.concatenate([one, other]), np.arange(8).reshape(2, 4))
    assert len(pairs) == len(places) == cross


def block_at(size, center):
    mesh = swept_block(2, 2, 2)
    return (mesh.points - 1.0) * size / 2 + center, mesh.hexes


def joined(*pieces):
    """A mesh of several blocks that share no nodes."""
    counts = np.cumsum([0] + [len(points) for points, _ in pieces])
    hexes = np.concatenate([hexes + first for (_, hexes), first in zip(pieces, counts[:-1], strict=True)])
    return HexMesh(points=np.concatenate([points for points, _ in pieces]), hexes=hexes, boundaries={})


def test_a_solid_inside_another_is_found_and_beside_it_is_not():
    inside = check_mesh(joined(block_at(4.0, [0, 0, 0]), block_at(1.0, [0.3, 0.2, 0.1])))
    assert "inside another one" in inside.problems[0]
    assert len(inside.problems) == 1
    assert check_mesh(joined(block_at(4.0, [0, 0, 0]), block_at(1.0, [2.6, 0, 0]))).valid
    assert "cross" in check_mesh(joined(block_at(4.0, [0, 0, 0]), block_at(1.0, [2.0, 0.1, 0.2]))).problems[0]


@pytest.mark.parametrize("shift", [(1, 0, 0), (1, 1, 0), (1, 1, 1), (0.3, 0, 0), (0.3, 1, 0), (0.3, 0.3, 0)])
def test_blocks_that_overlap_in_line_with_each_other_cross(shift):
    # Walls flush with walls and edges on edges: no quad goes through another, the blocks do.
    one, other = block_at(2.0, [0, 0, 0]), block_at(2.0, shift)
    report = check_mesh(joined(one, other))
    assert any("runs into itself" in problem for problem in report.problems)


@pytest.mark.parametrize("shift", [(2, 0, 0), (2, 0.3, 0), (2, 2, 0), (2, 2, 2), (2, 1.7, 0.1)])
def test_blocks_that_touch_do_not_cross(shift):
    # By a whole face, by part of one, along an edge, in a corner.
    assert check_mesh(joined(block_at(2.0, [0, 0, 0]), block_at(2.0, shift))).crossings == ()


def hollow():
    """A cube of 3 x 3 x 3 hexahedra without the middle one."""
    mesh = swept_block(3, 3, 3)
    return mesh.points, np.delete(mesh.hexes, 13, axis=0)


def test_a_cavity_is_no_fault_and_may_hold_another_solid():
    assert check_mesh(joined(hollow())).valid
    assert check_mesh(joined(hollow(), block_at(0.5, [1.5, 1.5, 1.5]))).valid
    within = joined(hollow(), block_at(0.25, [0.5, 0.5, 0.5]))  # in the wall
    assert any("inside another one" in problem for problem in check_mesh(within).problems)


def test_curved_quads_of_order_2_are_looked_at_with_their_bow():
    # Two cubes 0.1 apart, of order 2: where the faces between them bow by 0.2 each, they cross.
    def pair(bow):
        corners = np.stack([UNIT_CUBE, UNIT_CUBE + [0, 0, 1.1]])
        nodes = raised(corners, 27)
        nodes[0, 25, 2] += bow  # centre of the top face of the lower cube
        nodes[1, 24, 2] -= bow  # and of the bottom face of the upper one
        points = nodes.reshape(-1, 3)
        hexes = np.arange(54).reshape(2, 27)
        faces = [
            (0, 4, 7, 3, 16, 15, 19, 11, 20), (1, 2, 6, 5, 9, 18, 13, 17, 21), (0, 1, 5, 4, 8, 17, 12, 16, 22),
            (3, 7, 6, 2, 19, 14, 18, 10, 23), (0, 3, 2, 1, 11, 10, 9, 8, 24), (4, 5, 6, 7, 12, 13, 14, 15, 25),
        ]  # fmt: skip
        return HexMesh(points=points, hexes=hexes, boundaries={"all": hexes[:, faces].reshape(-1, 9)})

    assert check_mesh(pair(0.0)).valid
    report = check_mesh(pair(0.2))
    assert report.n_inverted == 0
    assert "'all' crosses itself" in report.problems[0]
    assert check_mesh(replace(pair(0.04))).valid
