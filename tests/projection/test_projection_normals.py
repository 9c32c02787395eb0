"""Pseudo-normals, and planarity as a scale without a jump."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.errors import ProjectionError
from cadsweep.projection import fit_affine, project_layers, pseudo_normal
from cadsweep.projection.normals import CURVED, PLANAR, normal_share

from .projection_sections import annulus, circle, dome, random_rotation, rotation, square

UP = np.array([0.0, 0.0, 1.0])


def flat(curve):
    return np.c_[curve, np.zeros(len(curve))]


class TestPseudoNormal:
    def test_counter_clockwise_ring_looks_up(self):
        assert np.allclose(pseudo_normal(flat(circle(12, 2.0))), UP, atol=1e-15)

    def test_reversing_the_outer_loop_reverses_it(self):
        rng = np.random.default_rng(0)
        ring = rng.standard_normal((15, 3)) * 0.1 + flat(circle(15, 1.0))
        assert np.allclose(pseudo_normal(ring[::-1]), -pseudo_normal(ring), atol=1e-13)

    def test_it_is_the_vector_area(self):
        rng = np.random.default_rng(1)
        ring = rng.standard_normal((15, 3)) * 0.2 + flat(circle(15, 1.0))
        area = 0.5 * np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0)
        assert np.allclose(pseudo_normal(ring), area / np.linalg.norm(area), atol=1e-13)

    @pytest.mark.parametrize("turn", [1, -1])
    def test_holes_are_reversed_however_they_are_given(self, turn):
        outer, hole = flat(circle(24, 2.0)), flat(circle(12, 0.7))
        hole[:, 2] = 0.3 * hole[:, 0]
        ring = np.vstack([outer, hole])
        area = np.pi * 0  # vector areas by definition, hole against the outer loop
        area = sum(s * 0.5 * np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0) for s, p in ((1, outer), (-1, hole)))
        loops = [np.arange(24), np.arange(24, 36)[::turn]]
        assert np.allclose(pseudo_normal(ring, loops), area / np.linalg.norm(area), atol=1e-13)
        loops[0] = loops[0][::-1]
        assert np.allclose(pseudo_normal(ring, loops), -area / np.linalg.norm(area), atol=1e-13)

    def test_tubular_band_takes_the_outer_loops_side(self):
        band = np.vstack([flat(circle(16, 1.0)), flat(circle(16, 1.0)) + UP])
        loops = [np.arange(16), np.arange(16, 32)]
        assert np.allclose(pseudo_normal(band, loops), UP, atol=1e-13)
        assert np.allclose(pseudo_normal(band, [loops[0][::-1], loops[1]]), -UP, atol=1e-13)

    @pytest.mark.parametrize("start", [0.0, 0.3, 7.0])
    def test_figure_of_eight_takes_its_best_plane(self, start):
        t = 2 * np.pi * (np.arange(24) + start) / 24
        eight = np.c_[np.sin(t), np.sin(2 * t) / 2, np.zeros(24)]
        R = random_rotation(np.random.default_rng(2))
        normal = pseudo_normal(eight @ R.T)
        assert abs(normal @ R @ UP) == pytest.approx(1.0, abs=1e-12)
        assert np.allclose(pseudo_normal((eight @ R.T)[::-1]), -normal, atol=1e-12)

    def test_figure_of_eight_turns_with_the_part(self):
        t = 2 * np.pi * (np.arange(24) + 0.3) / 24
        eight = np.c_[np.sin(t), np.sin(2 * t) / 2, np.zeros(24)]
        for seed in range(5):
            R = random_rotation(np.random.default_rng(seed))
            assert np.allclose(pseudo_normal(eight @ R.T), R @ pseudo_normal(eight), atol=1e-12)

    def test_in_the_plane_it_is_the_left_hand_normal_of_a_line(self):
        line = np.outer(np.linspace(0, 1, 9), [3.0, 4.0])
        assert np.allclose(pseudo_normal(line), [-0.8, 0.6], atol=1e-14)
        assert np.allclose(pseudo_normal(line[::-1]), [0.8, -0.6], atol=1e-14)

    def test_a_loop_on_a_line_is_refused_by_number(self):
        ring = np.vstack([flat(circle(12, 2.0)), np.outer(np.linspace(0, 0.5, 5), [1, 1, 0])])
        with pytest.raises(ProjectionError) as caught:
            pseudo_normal(ring, [np.arange(12), np.arange(12, 17)])
        assert caught.value.loop == 1


class TestPlanarity:
    """Relative non-planarity: below 1e-5 planar, above 1e-2 not, smooth between."""

    section = dome(square(8), 0.4)
    ring = section.points[section.ring]

    def wavy(self, delta):
        """The ring with a relative non-planarity of exactly `delta`."""
        wave = np.sin(2.3 * np.arange(len(self.ring)))
        local = self.ring[:, :2] - self.ring[:, :2].mean(axis=0)
        wave -= wave.mean()
        wave -= local @ np.linalg.lstsq(local, wave, rcond=None)[0]
        radius = np.sqrt((local**2).sum())
        height = delta * radius / np.sqrt(1 - delta**2)
        return np.c_[self.ring[:, :2], wave / np.linalg.norm(wave) * height]

    @staticmethod
    def image(rng, ring):
        """A target ring that no affine map meets, as parts have them."""
        return ring @ random_rotation(rng).T + 0.05 * np.sin(3 * ring[:, [1, 2, 0]])

    @pytest.mark.parametrize("delta", [0.0, 1e-8, 0.99e-5])
    def test_planar_rings_send_the_normal_to_the_normal(self, delta):
        ring = self.wavy(delta)
        Y = self.image(np.random.default_rng(0), self.ring)
        phi = fit_affine(ring, Y, "H")
        assert np.allclose(phi.matrix @ pseudo_normal(ring), pseudo_normal(Y), atol=1e-5)

    @pytest.mark.parametrize("delta", [1.01e-2, 0.03, 0.2])
    def test_curved_rings_make_h_equal_to_f(self, delta):
        ring = self.wavy(delta)
        Y = self.image(np.random.default_rng(0), ring)
        f, h = fit_affine(ring, Y, "F"), fit_affine(ring, Y, "H")
        assert np.abs(f.matrix - h.matrix).max() < 1e-9
        assert np.abs(f(self.section.points) - h(self.section.points)).max() < 1e-9

    def test_no_jump_anywhere_on_the_scale(self):
        """From one delta to the next, 2 % apart, no step is much greater than its neighbours."""
        deltas = np.exp(np.linspace(np.log(1e-7), np.log(1e-1), 700))
        Y = self.image(np.random.default_rng(0), self.ring)
        images = np.array([fit_affine(self.wavy(d), Y, "H").matrix[:, 2] for d in deltas])
        steps = np.linalg.norm(np.diff(images, axis=0), axis=1)
        span = np.linalg.norm(images - images[0], axis=1).max()
        assert steps.max() < 0.06 * span
        changes = np.abs(np.diff(steps))
        assert changes.max() < 0.2 * steps.max()

    def test_share_falls_from_one_to_nothing(self):
        assert normal_share([0.0, PLANAR]).tolist() == [1.0, 1.0]
        assert normal_share([CURVED, 1.0]).tolist() == [0.0, 0.0]
        between = normal_share(np.geomspace(PLANAR, CURVED, 50))
        assert (np.diff(between) < 0).all()

    @pytest.mark.parametrize("eps", [1e-6, 1e-8, 1e-10])
    @pytest.mark.parametrize("strategy", ["source", "advancing", "both"])
    @pytest.mark.parametrize("seed", range(4))
    def test_noise_moves_the_result_by_little(self, eps, strategy, seed):
        rng = np.random.default_rng(seed)
        layers = np.array([self.section.points @ rotation([0, 1, 0], a).T + 4 * a * UP for a in (0, 0.3, 0.6, 0.9)])
        layers = layers + 0.05 * np.linspace(0, 1, 4)[:, None, None] * np.sin(2 * layers[:, :, [1, 2, 0]])

        def place(noise):
            moved = layers + noise
            rings = moved[:, self.section.ring]
            return project_layers(
                moved[0],
                self.section.quads,
                rings,
                loops=self.section.loops,
                strategy=strategy,
                target_points=moved[-1],
            ).points()

        noise = eps * rng.uniform(-1, 1, layers.shape)
        assert np.abs(place(noise) - place(0.0)).max() < 1e3 * eps

    @pytest.mark.parametrize("delta", [0.0, 1e-6, 1e-4, 1e-3, 5e-3, 0.1])
    @pytest.mark.parametrize("unit", [1e-3, 1e3, 2.54e-2])
    def test_the_unit_of_length_does_not_matter(self, delta, unit):
        ring = self.wavy(delta)
        Y = self.image(np.random.default_rng(4), self.ring)
        for functional in "FGH":
            small, large = fit_affine(ring, Y, functional), fit_affine(unit * ring, unit * Y, functional)
            bound = 1e-9 * max(1.0, np.abs(small.matrix).max())
            assert np.abs(small.matrix - large.matrix).max() < bound
            assert small.rank == large.rank


def test_annulus_normal_is_that_of_its_plane():
    section = annulus()
    ring = section.points[section.ring]
    rows = np.split(np.arange(len(ring)), [len(section.loops[0])])
    assert np.allclose(pseudo_normal(ring, rows), UP, atol=1e-14)
