"""Hard sweeps: nothing inverted, corrections sparse, saved with the factors, and never for the worse."""

from __future__ import annotations

import numpy as np
import pytest
from projection_sections import (
    annulus,
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
from test_projection_target import Graph, Plane

from cadsweep.mesh import sweep_hexes
from cadsweep.projection import FactoredSweep, corrected, project_layers, project_target
from cadsweep.projection.corrections import scaled_jacobians
from cadsweep.projection.descent import minimise
from cadsweep.projection.hexenergy import corner_energies
from cadsweep.projection.relax import _corner_energies


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
    sweep = corrected(sweep_of(section, rings, surface), section.quads, section.loops)
    values = scaled_jacobians(sweep)
    assert (values > 0.0).all()
    assert values.min() >= least


def folded_in_the_middle(rise=4.0):
    """The arms of an L grow and shrink again: both caps are fine, the layers between them fold."""
    section = l_shape(5, 3.0, 1.0)
    longer = np.where(section.points > 1, 1 + 3 * (section.points - 1), section.points)
    t = np.linspace(0, 1, 21)[:, None, None]
    w = np.sin(np.pi * t)
    rings = (1 - w) * section.points[section.ring] + w * longer[section.ring] + rise * t * np.array([0, 0, 1])
    return section, rings, Plane(rise)


class TestCorrections:
    section, rings, surface = folded_in_the_middle()

    def pair(self):
        plain = sweep_of(self.section, self.rings, self.surface)
        return plain, corrected(plain)

    def test_folded_layers_unfold(self):
        plain, mended = self.pair()
        assert (scaled_jacobians(plain) <= 0.0).any()
        assert scaled_jacobians(mended).min() >= 0.3

    def test_rings_and_caps_stay_and_the_rest_is_sparse(self):
        plain, mended = self.pair()
        points = mended.points()
        assert (points[:, self.section.ring] == self.rings).all()
        assert (points[0] == self.section.points).all()
        assert (points[-1] == plain.target_points).all()
        moved = (points != plain.points()).any(axis=2)
        assert moved.sum() <= len(mended.corrections.nodes) < 0.5 * moved.size
        assert np.isin(mended.corrections.nodes, self.section.ring).sum() == 0

    def test_every_slab_has_the_same_bits(self):
        _, mended = self.pair()
        points = mended.points()
        for run in (slice(3, 9), slice(None, None, -3), slice(10, 11)):
            assert (mended.points(run) == points[run]).all()

    def test_saved_with_the_factors(self, tmp_path):
        _, mended = self.pair()
        mended.save(tmp_path / "part.sweep.npz")
        assert (FactoredSweep.load(tmp_path / "part.sweep.npz").points() == mended.points()).all()

    def test_once_more_changes_nothing_for_the_worse(self):
        _, mended = self.pair()
        again = corrected(mended)
        assert scaled_jacobians(again).min() >= scaled_jacobians(mended).min() - 1e-9


def test_good_sweeps_go_through_untouched():
    section = annulus()
    rings = between(section.points[section.ring], section.points[section.ring] + [0, 0, 2], 8)
    sweep = sweep_of(section, rings, Plane(2.0))
    assert corrected(sweep) is sweep


def test_what_only_the_boundary_spoils_is_left_alone():
    """A square's corner on a circle: its hexahedra are flat on the boundary itself."""
    section = square(8)
    ring = section.points[section.ring]
    angle = np.angle(ring[:, 0] + 1j * ring[:, 1])
    rings = between(ring, at(3.0, np.c_[np.cos(angle), np.sin(angle)]))
    sweep = sweep_of(section, rings, Plane(3.0))
    assert scaled_jacobians(sweep).min() < 0.2
    assert corrected(sweep) is sweep


def test_scaled_jacobian_is_the_least_corner():
    section, rings, surface = quarter_twist()
    sweep = sweep_of(section, rings, surface)
    points = sweep.points().reshape(-1, 3)
    hexes = sweep_hexes(section.quads, sweep.n_nodes, sweep.n_layers)
    x = points[hexes]
    corners = [
        (0, 1, 3, 4),
        (1, 2, 0, 5),
        (2, 3, 1, 6),
        (3, 0, 2, 7),
        (4, 7, 5, 0),
        (5, 4, 6, 1),
        (6, 5, 7, 2),
        (7, 6, 4, 3),
    ]
    values = []
    for i, *others in corners:
        J = np.stack([x[:, j] - x[:, i] for j in others], axis=2)
        values.append(np.linalg.det(J) / np.prod(np.linalg.norm(J, axis=1), axis=1))
    assert np.abs(scaled_jacobians(sweep).ravel() - np.min(values, axis=0)).max() < 1e-12


class TestGradients:
    """Compiled gradients against differences."""

    @pytest.mark.parametrize(("eps", "squarings"), [(0.3, 0), (0.3, 2), (1e-6, 1)])
    def test_hexahedra(self, eps, squarings):
        rng = np.random.default_rng(0)
        section = square(2)
        points = np.concatenate([section.points, section.points + [0, 0, 0.8]]) + 0.1 * rng.standard_normal((18, 3))
        hexes, ideal = sweep_hexes(section.quads, 9, 1), rng.uniform(0.5, 1.5, (4, 3))
        self.check(lambda x, g: corner_energies(x, hexes, ideal, eps, 0.1, 0.4, squarings, g), points)

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
