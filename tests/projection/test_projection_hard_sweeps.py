"""Hard sweeps: the product alone inverts nothing; and the energies and the minimiser underneath."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.cells import sweep_hexes
from cadsweep.projection import project_layers, project_target
from cadsweep.projection.descent import minimise
from cadsweep.projection.injective import _corner_energies
from cadsweep.quality import scaled_jacobians

from .projection_sections import (
    bent,
    circle,
    disc,
    dome,
    l_shape,
    plate_with_hole,
    rotation,
    square,
    square_boundary,
    star,
)
from .test_projection_target import Graph, Plane


def between(first, last, n_layers=20):
    """Rings on straight lines between two rings."""
    t = np.linspace(0.0, 1.0, n_layers + 1)[:, None, None]
    return (1 - t) * first + t * last


def at(height, curve):
    return np.c_[curve, np.full(len(curve), height)]


def sweep_of(section, rings, surface, **options):
    cap = project_target(section.points, section.quads, section.loops, rings[-1], surface=surface)
    return project_layers(
        section.points, section.quads, rings, loops=section.loops, target_points=cap.points, **options
    )


def l_with_longer_arms():
    section = l_shape(5, 3.0, 1.0)
    longer = np.where(section.points > 1, 1 + 3 * (section.points - 1), section.points)
    return section, between(section.points[section.ring], longer[section.ring] + [0, 0, 4]), Plane(4.0)


def moving_hole():
    section = plate_with_hole(48, 10, 2.0, 0.8, center=(-0.8, -0.8))
    target = plate_with_hole(48, 10, 2.0, 0.32, center=(0.8, 0.8))
    return section, between(section.points[section.ring], target.points[target.ring] + [0, 0, 4]), Plane(4.0)


def star_to_circle():
    section = star()
    return section, between(section.points[section.ring], at(3.0, circle(40, 1.0))), Plane(3.0)


def circle_to_square():
    section = disc()
    return section, between(section.points[section.ring], at(3.0, square_boundary(32, 1.0))), Plane(3.0)


def unlike_domes():
    section = dome(square(10), 0.5)
    surface = Graph(-0.5)
    target = surface.evaluate(surface.project(section.points[section.ring]))
    return section, between(section.points[section.ring], target), surface


def domed_half_torus():
    """SMESH leaves 78 of these 1,280 hexahedra inverted."""
    section = dome(square(8), 0.5)
    rings = bent(section, -180, 20, radius=2.2)[:, section.ring]
    return section, rings, Plane(0.0, np.diag([1.0, -1.0, -1.0]))


def quarter_twist():
    section = square(10)
    turned = [section.points[section.ring] @ rotation([0, 0, 1], a).T for a in np.linspace(0, np.pi / 2, 21)]
    return section, np.array(turned) + np.linspace(0, 3, 21)[:, None, None] * np.array([0, 0, 1]), Plane(3.0)


@pytest.mark.parametrize(
    ("make", "least"),
    [
        (l_with_longer_arms, 0.5),
        (moving_hole, 0.15),
        (star_to_circle, 0.5),
        (circle_to_square, 0.6),
        (unlike_domes, 0.4),
        (domed_half_torus, 0.6),
        (quarter_twist, 0.7),
    ],
)
def test_hard_sweeps_are_valid(make, least):
    section, rings, surface = make()
    sweep = sweep_of(section, rings, surface)
    hexes = sweep_hexes(section.quads, sweep.n_nodes, sweep.n_layers)
    assert scaled_jacobians(sweep.points().reshape(-1, 3), hexes).min() >= least


class TestGradients:
    """Compiled gradients against differences."""

    @pytest.mark.parametrize(("eps", "squarings"), [(0.3, 0), (0.3, 2), (1e-6, 1)])
    def test_quads(self, eps, squarings):
        rng = np.random.default_rng(1)
        section = square(2)
        y = section.points[:, :2] + 0.1 * rng.standard_normal((9, 2))
        ideal, metric = rng.uniform(0.5, 1.5, (4, 2)), np.eye(2) + 0.2 * rng.standard_normal((4, 2, 2))
        self.check(lambda x, g: _corner_energies(x, section.quads, ideal, metric, eps, 0.1, 0.4, squarings, g), y)

    @staticmethod
    def check(energy, x):
        gradient = np.zeros_like(x)
        energy(x, gradient)
        differences = np.zeros_like(x)
        for place in np.ndindex(*x.shape):
            for side in (1, -1):
                moved = x.copy()
                moved[place] += side * 1e-6
                differences[place] += side * energy(moved, np.zeros_like(x)) / 2e-6
        assert np.abs(gradient - differences).max() < 1e-6 * np.abs(gradient).max()


def test_minimise_solves_a_quadratic():
    rng = np.random.default_rng(0)
    A = rng.standard_normal((30, 30))
    A = A @ A.T + np.eye(30)
    b = rng.standard_normal((30, 3))
    diagonal = np.diag(A)[:, None]
    x, _ = minimise(
        lambda x: (float(0.5 * np.vdot(x, A @ x) - np.vdot(b, x)), A @ x - b),
        np.zeros((30, 3)),
        lambda r: r / diagonal,
        n_steps=500,
        tolerance=0.0,
    )
    assert np.abs(A @ x - b).max() < 1e-4


def test_minimise_stays_on_its_side_of_a_barrier():
    # x - log(x - 1) has its least value at 2 and none below 1.
    def energy(x):
        if x[0, 0] <= 1:
            return np.inf, np.zeros((1, 1))
        return float(x[0, 0] - np.log(x[0, 0] - 1)), 1 - 1 / (x - 1)

    for start in (1.0001, 1.5, 50.0):
        found, value = minimise(energy, np.array([[start]]), lambda r: r, n_steps=500, tolerance=1e-12)
        assert found[0, 0] == pytest.approx(2, abs=1e-3)
        assert value == pytest.approx(2, abs=1e-6)
