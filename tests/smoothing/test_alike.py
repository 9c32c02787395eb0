"""Patches that are each other's image: what one became, the others become."""

from dataclasses import replace

import numpy as np
import pytest

from cadsweep.smoothing.alike import Alike
from cadsweep.smoothing.optimise import polished
from cadsweep.smoothing.patch import Patch

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


def lattice():
    """Points and hexahedra of 3 x 3 x 3 cubes, those inside moved, and which are inside."""
    nodes = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    low = nodes[(nodes < 3).all(axis=1)]
    hexes = ((low[:, None] + CUBE) @ [16, 4, 1]).astype(np.int64)
    free = ((nodes > 0) & (nodes < 3)).all(axis=1)
    points = nodes * [1.0, 1.3, 1.7] + 0.02 * np.sin(5.0 * nodes @ [[1, 2, 3], [3, 1, 2], [2, 3, 1]])
    points[free] += np.random.default_rng(3).uniform(-0.25, 0.25, (int(free.sum()), 3))
    return points, hexes, free


def patch_of(points, hexes, free, goal=0.9):
    return Patch(
        points=points, hexes=hexes, free=free, lengths=np.ones((len(hexes), 3)), goals=np.full(len(hexes), goal)
    )


ANGLE = 0.7
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE), 0], [np.sin(ANGLE), np.cos(ANGLE), 0], [0, 0, 1]])
MIRROR = np.diag([1.0, -1.0, 1.0])


class Counted:
    """Polishing, and how often it was asked for."""

    def __init__(self):
        self.n = 0

    def __call__(self, patch, points):
        self.n += 1
        return polished(patch, points)


@pytest.mark.parametrize("motion", [TURN, MIRROR, TURN @ MIRROR], ids=["turned", "mirrored", "both"])
def test_an_image_goes_where_its_original_went(motion):
    points, hexes, free = lattice()
    one, step, known = patch_of(points, hexes, free), Counted(), Alike()
    moved = known.stepped(step, one, one.points)
    assert one.score(moved).beats(one.score(points))
    order = np.random.default_rng(1).permutation(len(points))
    turned = np.argsort(order)[hexes]
    if np.linalg.det(motion) < 0:  # a mirror turns hexahedra inside out
        turned = turned[:, [4, 5, 6, 7, 0, 1, 2, 3]]
    other = patch_of((points @ motion.T + [30.0, -4.0, 2.0])[order], turned[::-1], free[order])
    image = known.stepped(step, other, other.points)
    assert step.n == 1
    assert np.allclose(image, (moved @ motion.T + [30.0, -4.0, 2.0])[order], atol=1e-5)
    assert np.array_equal(image[~other.free], other.points[~other.free])
    assert other.score(image).worst == pytest.approx(one.score(moved).worst, abs=1e-5)


def same(points, hexes, free):
    return patch_of(points, hexes, free)


def shifted(points, hexes, free):
    points = points.copy()
    points[21] += 1e-3
    return patch_of(points, hexes, free)


def fastened(points, hexes, free):
    free = free.copy()
    free[[21, 0]] = free[[0, 21]]
    return patch_of(points, hexes, free)


def crossed(points, hexes, free):
    return patch_of(points, np.concatenate([hexes[:-1], hexes[:1]]), free)


def asked(points, hexes, free):
    return patch_of(points, hexes, free, goal=0.5)


def held(points, hexes, free):
    """Its faces are others: what is brought back to them is where it began."""
    return replace(patch_of(points, hexes, free), snap=lambda moved: points.copy())


OTHERS = [(same, 1), (shifted, 2), (fastened, 2), (crossed, 2), (asked, 2), (held, 2)]


@pytest.mark.parametrize(("other", "taken"), OTHERS, ids=lambda own: getattr(own, "__name__", str(own)))
def test_the_step_is_taken_anew_where_something_differs(other, taken):
    points, hexes, free = lattice()
    step, known = Counted(), Alike()
    for patch in (patch_of(points, hexes, free), other(points, hexes, free)):
        known.stepped(step, patch, patch.points)
    assert step.n == taken
