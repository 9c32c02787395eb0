"""The functionals F, G and H: the paper's propositions, and plain least squares as the oracle."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.errors import InputError, ProjectionError
from cadsweep.projection import AffineMap, fit_affine, pseudo_normal

from .projection_sections import annulus, circle, dome, random_rotation, rotation, square

SEEDS = range(8)


def hyperplanar_ring(rng, n, m=20):
    """m random points of a random hyperplane of R^n, in cyclic order within it for n = 3."""
    if n == 2:
        direction = rng.standard_normal(2)
        return rng.standard_normal(2) + np.sort(rng.uniform(-1, 1, m))[:, None] * direction
    plane = circle(m, 1.0) * rng.uniform(0.7, 1.3, (m, 1))
    return rng.standard_normal(3) + np.c_[plane, np.zeros(m)] @ random_rotation(rng).T


def spatial_ring(rng, n, m=20):
    """m points that span R^n, in cyclic order."""
    plane = circle(m, 1.0) * rng.uniform(0.7, 1.3, (m, 1))
    if n == 2:
        return plane + rng.standard_normal(2)
    return np.c_[plane, rng.uniform(-0.5, 0.5, m)] @ random_rotation(rng).T + rng.standard_normal(3)


def lstsq_map(functional, X, Y, u=None):
    """Eqs. (6), (9), (10) as they stand in the paper, solved by numpy; returns A and the map."""
    cX, cY = X.mean(axis=0), Y.mean(axis=0)
    if functional == "G":
        left, right, origin, image = X - cX + cY - cX, Y - cX, 2 * cX - cY, cX
    else:
        left, right, origin, image = X - cX, Y - cY, cX, cY
    if u is not None:
        left, right = np.vstack([left, u[0]]), np.vstack([right, u[1]])
    A = np.linalg.lstsq(left, right, rcond=1e-10)[0].T
    return A, left, lambda x: (x - origin) @ A.T + image


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("functional", ["F", "G", "H"])
@pytest.mark.parametrize("kind", [hyperplanar_ring, spatial_ring])
@pytest.mark.parametrize("seed", SEEDS)
def test_equals_plain_least_squares(n, functional, kind, seed):
    rng = np.random.default_rng(seed)
    X, Y = kind(rng, n), spatial_ring(rng, n)
    u = None
    if functional == "H" and kind is hyperplanar_ring:
        u = (pseudo_normal(X), pseudo_normal(Y))
    A, system, phi = lstsq_map(functional, X, Y, u)
    fitted = fit_affine(X, Y, functional)
    assert isinstance(fitted, AffineMap)
    assert np.abs(fitted.matrix - A).max() < 1e-9 * max(1.0, np.abs(A).max())
    x = rng.standard_normal((30, n))
    assert np.abs(fitted(x) - phi(x)).max() < 1e-8 * max(1.0, np.abs(A).max())
    assert fitted.rank == np.linalg.matrix_rank(system, tol=1e-9)


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("seed", SEEDS)
class TestRanks:
    """Propositions 1 to 4 and Remark 5."""

    def test_proposition_1_f_loses_one_rank_on_a_hyperplane(self, n, seed):
        rng = np.random.default_rng(seed)
        phi = fit_affine(hyperplanar_ring(rng, n), spatial_ring(rng, n), "F")
        assert phi.rank == n - 1
        assert phi.condition == np.inf

    def test_proposition_2_g_too_where_the_centres_lie_in_it(self, n, seed):
        rng = np.random.default_rng(seed)
        X = hyperplanar_ring(rng, n)
        within = X[3] - X[11]
        Y = spatial_ring(rng, n)
        Y += X.mean(axis=0) + within - Y.mean(axis=0)
        assert fit_affine(X, Y, "G").rank == n - 1

    def test_remark_5_g_has_full_rank_elsewhere(self, n, seed):
        rng = np.random.default_rng(seed)
        phi = fit_affine(hyperplanar_ring(rng, n), spatial_ring(rng, n), "G")
        assert phi.rank == n

    def test_proposition_3_h_has_full_rank_on_a_hyperplane(self, n, seed):
        rng = np.random.default_rng(seed)
        X, Y = hyperplanar_ring(rng, n), spatial_ring(rng, n)
        phi = fit_affine(X, Y, "H")
        assert phi.rank == n
        assert phi.condition < 1e4
        # Its n extra degrees of freedom send one normal to the other.
        assert np.allclose(phi.matrix @ pseudo_normal(X), pseudo_normal(Y), atol=1e-10)

    def test_proposition_4_h_has_full_rank_off_it_without_vectors(self, n, seed):
        rng = np.random.default_rng(seed)
        X, Y = spatial_ring(rng, n), spatial_ring(rng, n)
        phi = fit_affine(X, Y, "H")
        assert phi.rank == n
        assert phi.condition == pytest.approx(np.linalg.cond(X - X.mean(axis=0)), rel=1e-9)
        assert np.abs(phi.matrix - fit_affine(X, Y, "F").matrix).max() < 1e-12


class TestRemark8:
    """All four cases of the vectors of H."""

    plane = np.c_[circle(24, 1.0), np.zeros(24)]
    wavy = plane + 0.2 * np.c_[np.zeros((24, 2)), np.cos(3 * np.arange(24))]

    @pytest.mark.parametrize("target", [plane, wavy])
    def test_planar_source_sends_normal_to_pseudo_normal(self, target):
        Y = target @ rotation([1, 2, 3], 1.0).T
        phi = fit_affine(self.plane, Y, "H")
        assert np.allclose(phi.matrix @ [0, 0, 1], pseudo_normal(Y), atol=1e-12)

    @pytest.mark.parametrize("target", [plane, wavy])
    def test_curved_source_needs_no_normal(self, target):
        Y = target @ rotation([1, 2, 3], 1.0).T
        assert np.allclose(fit_affine(self.wavy, Y, "H").matrix, fit_affine(self.wavy, Y, "F").matrix, atol=1e-9)

    def test_given_vectors_enter_as_they_are(self):
        rng = np.random.default_rng(3)
        X, Y, u = spatial_ring(rng, 3), spatial_ring(rng, 3), rng.standard_normal((2, 3))
        A, _, _ = lstsq_map("H", X, Y, u)
        assert np.allclose(fit_affine(X, Y, "H", vectors=(u[0], u[1])).matrix, A, atol=1e-12)


@pytest.mark.parametrize("functional", ["F", "G", "H"])
@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("seed", SEEDS)
def test_affine_images_are_met_exactly(functional, n, seed):
    rng = np.random.default_rng(seed)
    A, b = rng.standard_normal((n, n)), rng.standard_normal(n)
    X, x = spatial_ring(rng, n), rng.standard_normal((10, n))
    if functional == "G":  # exact where c^Y - c^X is a fixed vector of A, as Remark 4 supposes
        d, v = rng.standard_normal((2, n))
        A += np.outer(d - A @ d, v) / (v @ d)
        b = d + X.mean(axis=0) - A @ X.mean(axis=0)
    phi = fit_affine(X, X @ A.T + b, functional)
    assert np.abs(phi(X) - (X @ A.T + b)).max() < 1e-10
    assert np.abs(phi(x) - (x @ A.T + b)).max() < 1e-10


def test_translations_are_exact_for_every_functional():
    section = dome(square(6))
    ring = section.points[section.ring]
    for functional in "GH":
        phi = fit_affine(ring, ring + [0.3, 0.2, 5.0], functional)
        assert np.abs(phi(section.points) - (section.points + [0.3, 0.2, 5.0])).max() < 1e-14 * 10


def test_loops_are_rows_and_their_order_does_not_matter():
    section = annulus()
    lengths = [len(loop) for loop in section.loops]
    ring = section.points[section.ring]
    rng = np.random.default_rng(0)
    image = ring @ random_rotation(rng).T + 0.01 * rng.standard_normal(ring.shape)
    rows = np.split(np.arange(len(ring)), np.cumsum(lengths)[:-1])
    first = fit_affine(ring, image, "H", loops=rows)
    order = rng.permutation(len(ring))
    shuffled = [np.argsort(order)[row] for row in rows]
    second = fit_affine(ring[order], image[order], "H", loops=shuffled)
    assert np.abs(first.matrix - second.matrix).max() < 1e-13
    mesh_loops = fit_affine(ring, image, "H", loops=[loop + len(ring) for loop in section.loops])
    assert np.abs(first.matrix - mesh_loops.matrix).max() == 0.0
    hole_turned = fit_affine(ring, image, "H", loops=[rows[0], rows[1][::-1]])
    assert np.abs(first.matrix - hole_turned.matrix).max() < 1e-13


class TestRefusals:
    ring = np.c_[circle(12, 1.0), np.zeros(12)]

    def test_not_a_number(self):
        bad = self.ring.copy()
        bad[4, 1] = np.nan
        with pytest.raises(InputError, match="node 4"):
            fit_affine(self.ring, bad)

    def test_unequal_length(self):
        with pytest.raises(InputError, match="different shapes"):
            fit_affine(self.ring, self.ring[:-1])

    def test_unknown_functional_lists_the_good_ones(self):
        with pytest.raises(InputError, match="'F', 'G', 'H'"):
            fit_affine(self.ring, self.ring, "E")

    def test_vectors_belong_to_h(self):
        with pytest.raises(InputError, match="'H'"):
            fit_affine(self.ring, self.ring, "F", vectors=([0, 0, 1], [0, 0, 1]))

    def test_loops_must_use_every_row(self):
        with pytest.raises(InputError, match="every row"):
            fit_affine(self.ring, self.ring, loops=[np.arange(11)])

    @pytest.mark.parametrize("functional", ["F", "G", "H"])
    def test_remark_7_all_on_a_line(self, functional):
        line = np.outer(np.linspace(0, 1, 12), [1.0, 2.0, 3.0])
        with pytest.raises(ProjectionError) as caught:
            fit_affine(line, self.ring, functional)
        assert (caught.value.layer, caught.value.loop) == (0, 0)

    def test_remark_7_in_the_plane_all_in_a_point(self):
        with pytest.raises(ProjectionError):
            fit_affine(np.ones((8, 2)), circle(8, 1.0))

    def test_two_coinciding_nodes_are_harmless(self):
        twice = self.ring.copy()
        twice[5] = twice[4]
        R = rotation([1, 1, 0], 0.7)
        phi = fit_affine(twice, twice @ R.T, "H")
        assert np.abs(phi.matrix - R).max() < 1e-13


def test_remark_6_g_skews_where_h_does_not():
    """At angle theta G misses a node of height z above the source plane by 2 z tan(theta / 2)."""
    z = 0.3
    section = dome(square(6), z)
    middle = np.argmin(np.linalg.norm(section.points[:, :2], axis=1))
    ring, axis = section.points[section.ring], np.array([0.0, 3.0, 0.0])
    for degrees in (45, 90, 135, 179):
        R = rotation([1, 0, 0], np.radians(degrees))
        images = (section.points - axis) @ R.T + axis
        g = fit_affine(ring, images[section.ring], "G")
        miss = np.linalg.norm(g(section.points) - images, axis=1)[middle]
        assert miss == pytest.approx(2 * z * np.tan(np.radians(degrees) / 2), rel=1e-9)
        h = fit_affine(ring, images[section.ring], "H")
        assert np.abs(h(section.points) - images).max() < 1e-12 * 6
    half_turn = (ring - axis) @ rotation([1, 0, 0], np.pi).T + axis
    assert fit_affine(ring, half_turn, "G").rank == 2
    h = fit_affine(ring, half_turn, "H")
    assert h.rank == 3
    whole = (section.points - axis) @ rotation([1, 0, 0], np.pi).T + axis
    assert np.abs(h(section.points) - whole).max() < 1e-12 * 6
