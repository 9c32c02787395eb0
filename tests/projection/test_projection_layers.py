"""Whole sweeps: strategies, exactness, equivariance, and what is promised bit for bit."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from cadsweep.errors import InputError, ProjectionError
from cadsweep.projection import FactoredSweep, fit_affine, project_layers

from .projection_sections import annulus, bent, disc, dome, l_shape, random_rotation, rotation, square, star

FUNCTIONALS = ["F", "G", "H"]
STRATEGIES = ["source", "advancing", "both"]


def place(section, layers, **options):
    options.setdefault("target_points", layers[-1])
    return project_layers(section.points, section.quads, layers[:, section.ring], loops=section.loops, **options)


def warped(section, n_layers=6, seed=0, amount=0.15):
    """Layers of a curved sweep that no affine map meets; the caps are domed."""
    base = section.points
    layers = []
    for t in np.linspace(0, 1, n_layers + 1):
        R = rotation([1, 0.3, 0.2], 0.8 * t)
        bend = amount * t * np.sin(2 * base[:, [1, 0, 0]] + seed) + 0.5 * amount * t**2 * np.cos(3 * base[:, [0, 2, 1]])
        layers.append((base + bend) @ R.T * (1 + 0.3 * t) + [0, 1.5 * t**2, 4 * t])
    return np.array(layers)


@pytest.mark.parametrize("functional", FUNCTIONALS)
@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("residual", [True, False])
@pytest.mark.parametrize("make", [lambda: dome(square()), annulus])
class TestBitForBit:
    def test_rings_and_caps(self, functional, strategy, residual, make):
        section = make()
        layers = warped(section)
        sweep = place(section, layers, functional=functional, strategy=strategy, residual=residual)
        assert isinstance(sweep, FactoredSweep)
        points = sweep.points()
        assert (points[:, section.ring] == layers[:, section.ring]).all()
        assert (points[0] == section.points).all()
        assert (points[-1] == layers[-1]).all()
        assert (sweep.layer(0) == section.points).all()
        assert (sweep.layer(-1) == layers[-1]).all()
        assert (sweep.rings == layers[:, section.ring]).all()

    def test_every_slab_has_the_same_bits(self, functional, strategy, residual, make):
        section = make()
        sweep = place(section, warped(section), functional=functional, strategy=strategy, residual=residual)
        points = sweep.points()
        assert all((sweep.layer(k) == points[k]).all() for k in range(7))
        for run in (slice(0, 3), slice(2, None), slice(None, None, -2), slice(-2, None), slice(3, 3)):
            assert (sweep.points(run) == points[run]).all()

    def test_inside_it_is_the_product(self, functional, strategy, residual, make):
        section = make()
        sweep = place(section, warped(section), functional=functional, strategy=strategy, residual=residual)
        product = np.einsum("ij,kjc->kic", sweep.basis, sweep.coefficients)
        inside = np.setdiff1d(np.arange(len(section.points)), section.ring)
        assert np.abs(product[1:-1, inside] - sweep.points()[1:-1, inside]).max() < 1e-13 * 10
        assert sweep.basis.shape == (len(section.points), sweep.coefficients.shape[1])
        assert sweep.n_modes <= sweep.basis.shape[1] - 4
        assert sweep.ranks.shape == sweep.conditions.shape == (7,)


class TestOut:
    section = dome(square())

    def sweep(self):
        return place(self.section, warped(self.section))

    def test_the_callers_array_is_filled_and_returned(self):
        sweep = self.sweep()
        out = np.full((3, len(self.section.points), 3), np.nan)
        assert sweep.points(slice(1, 4), out=out) is out
        assert (out == sweep.points(slice(1, 4))).all()

    def test_it_may_be_a_view(self):
        sweep = self.sweep()
        whole = np.zeros((3, len(self.section.points) + 5, 3))
        sweep.points(slice(1, 4), out=whole[:, 2:-3])
        assert (whole[:, 2:-3] == sweep.points(slice(1, 4))).all()
        assert not whole[:, :2].any()
        assert not whole[:, -3:].any()

    @pytest.mark.parametrize("out", [np.empty((2, 49, 3)), np.empty((3, 49, 3), dtype=np.float32), [1, 2]])
    def test_another_shape_or_type_is_refused(self, out):
        with pytest.raises(InputError, match="`out`"):
            self.sweep().points(slice(1, 4), out=out)

    def test_read_only_is_refused(self):
        out = np.empty((3, 49, 3))
        out.flags.writeable = False
        with pytest.raises(InputError, match="read-only"):
            self.sweep().points(slice(1, 4), out=out)

    @pytest.mark.parametrize("k", [7, -8])
    def test_no_such_layer(self, k):
        with pytest.raises(IndexError):
            self.sweep().layer(k)


@pytest.mark.parametrize("degrees", [45, 90, 135, 179, 180])
@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("residual", [True, False])
def test_h_is_exact_on_a_bend(degrees, strategy, residual):
    section = dome(square(6))
    layers = bent(section, degrees, 12)
    points = place(section, layers, functional="H", strategy=strategy, residual=residual).points()
    size = np.ptp(layers.reshape(-1, 3), axis=0).max()
    assert np.abs(points - layers).max() < 1e-12 * size


@pytest.mark.parametrize("make", [lambda: dome(square()), annulus, l_shape])
@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("seed", range(3))
def test_affine_sweeps_are_exact_and_have_no_modes(make, strategy, seed):
    rng = np.random.default_rng(seed)
    section = make()
    points = section.points
    if seed:  # a ring that spans space, so that every affine map shows
        points = points + 0.3 * np.c_[np.zeros((len(points), 2)), points[:, 0] * points[:, 1]]
    section = type(section)(points, section.quads, section.loops)
    maps = [np.eye(3)] + [random_rotation(rng) for _ in range(4)]
    if seed:
        maps = [np.eye(3) + 0.06 * k * rng.standard_normal((3, 3)) for k in range(5)]
    layers = np.array([points @ A.T + k * np.array([0, 0.2, 1.0]) for k, A in enumerate(maps)])
    with_carry = place(section, layers, strategy=strategy)
    without = place(section, layers, strategy=strategy, residual=False)
    assert with_carry.n_modes == 0
    assert np.abs(with_carry.points() - layers).max() < 1e-11
    assert np.abs(with_carry.points() - without.points()).max() <= 1e-12


@pytest.mark.parametrize("functional", FUNCTIONALS)
def test_source_equals_least_squares_layer_by_layer(functional):
    section = dome(square())
    layers = warped(section)
    points = place(section, layers, functional=functional, strategy="source", residual=False).points()
    X = section.points[section.ring]
    inside = np.setdiff1d(np.arange(len(section.points)), section.ring)
    for k in range(1, 6):
        Y = layers[k, section.ring]
        cX, cY = X.mean(axis=0), Y.mean(axis=0)
        if functional == "G":
            A = np.linalg.lstsq(X - cX + cY - cX, Y - cX, rcond=1e-10)[0].T
            expected = (section.points - 2 * cX + cY) @ A.T + cX
        else:
            left, right = X - cX, Y - cY
            if functional == "H":  # the ring is planar: Remark 8 asks for the normals
                area = np.cross(Y - cY, np.roll(Y - cY, -1, axis=0)).sum(axis=0)
                left = np.vstack([left, [0, 0, 1]])
                right = np.vstack([right, area / np.linalg.norm(area)])
            A = np.linalg.lstsq(left, right, rcond=1e-10)[0].T
            expected = (section.points - cX) @ A.T + cY
        assert np.abs(points[k] - expected)[inside].max() < 1e-11


@pytest.mark.parametrize("functional", FUNCTIONALS)
def test_advancing_is_the_composition_of_its_steps(functional):
    section = dome(square())
    layers = warped(section)
    sweep = place(section, layers, functional=functional, strategy="advancing", residual=False)
    expected = section.points
    inside = np.setdiff1d(np.arange(len(section.points)), section.ring)
    for k in range(1, 6):
        step = fit_affine(layers[k - 1, section.ring], layers[k, section.ring], functional)
        expected = step(expected)
        assert np.abs(sweep.layer(k) - expected)[inside].max() < 1e-10
        assert sweep.ranks[k] == step.rank
        if np.isfinite(step.condition):
            assert sweep.conditions[k] == pytest.approx(step.condition, rel=1e-6)


@pytest.mark.parametrize("functional", FUNCTIONALS)
def test_both_is_the_weighted_mean_of_the_caps(functional):
    section = annulus()
    layers = warped(section)
    sweep = place(section, layers, functional=functional, strategy="both", residual=False)
    rings = layers[:, section.ring]
    rows = np.split(np.arange(rings.shape[1]), [len(section.loops[0])])
    along = np.r_[np.zeros((1, rings.shape[1])), np.cumsum(np.linalg.norm(np.diff(rings, axis=0), axis=2), axis=0)]
    inside = np.setdiff1d(np.arange(len(section.points)), section.ring)
    for k in range(1, 6):
        w = (along[k] / along[-1]).mean()
        assert sweep.weights[k] == pytest.approx(w, rel=1e-12)
        forth = fit_affine(rings[0], rings[k], functional, loops=rows)(layers[0])
        back = fit_affine(rings[-1], rings[k], functional, loops=rows)(layers[-1])
        assert np.abs(sweep.layer(k) - (1 - w) * forth - w * back)[inside].max() < 1e-10


def test_the_weight_follows_length_not_index():
    section = square()
    heights = np.array([0.0, 0.1, 0.3, 2.0, 4.0])
    layers = section.points + heights[:, None, None] * np.array([0, 0, 1.0])
    assert np.allclose(place(section, layers).weights, heights / 4.0, atol=1e-14)


@pytest.mark.parametrize("functional", FUNCTIONALS)
@pytest.mark.parametrize("residual", [True, False])
@pytest.mark.parametrize("make", [lambda: dome(square()), annulus])
def test_both_is_reversed_when_source_and_target_swap(functional, residual, make):
    section = make()
    layers = warped(section)
    forth = place(section, layers, functional=functional, residual=residual).points()
    turned = project_layers(
        layers[-1], section.quads, layers[::-1, section.ring], loops=section.loops, functional=functional,
        residual=residual, target_points=layers[0],
    ).points()  # fmt: skip
    assert np.abs(turned[::-1] - forth).max() < 1e-10


@pytest.mark.parametrize("functional", FUNCTIONALS)
@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("seed", range(2))
class TestEquivariance:
    section = dome(square())

    def test_rotation_translation_scaling(self, functional, strategy, seed):
        rng = np.random.default_rng(seed)
        layers = warped(self.section)
        R, shift, scale = random_rotation(rng), rng.standard_normal(3), 10.0 ** rng.integers(-3, 4)
        before = place(self.section, layers, functional=functional, strategy=strategy).points()
        moved = type(self.section)(scale * (layers[0] @ R.T + shift), self.section.quads, self.section.loops)
        after = place(moved, scale * (layers @ R.T + shift), functional=functional, strategy=strategy).points()
        assert np.abs(after - scale * (before @ R.T + shift)).max() < 1e-9 * scale

    def test_relabelled_nodes(self, functional, strategy, seed):
        rng = np.random.default_rng(seed)
        layers = warped(self.section)
        before = place(self.section, layers, functional=functional, strategy=strategy).points()
        order = rng.permutation(len(self.section.points))
        label = np.argsort(order)
        relabelled = type(self.section)(
            self.section.points[order], label[self.section.quads], [label[loop] for loop in self.section.loops]
        )
        after = place(relabelled, layers[:, order], functional=functional, strategy=strategy).points()
        assert np.abs(after - before[:, order]).max() < 1e-10


@pytest.mark.parametrize("make", [square, annulus, l_shape, disc, star])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_straight_sweep_is_an_extrusion(make, strategy):
    section = make()
    layers = section.points + np.linspace(0, 3, 5)[:, None, None] * np.array([0.2, 0.1, 1.0])
    assert np.abs(place(section, layers, strategy=strategy).points() - layers).max() < 1e-13 * 10


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_a_full_ring_closes(strategy):
    """rings[N] == rings[0], and the target is the source."""
    section = dome(square())
    layers = bent(section, 360, 16)
    layers[0] = layers[-1] = section.points
    sweep = place(section, layers, strategy=strategy)
    assert np.abs(sweep.points() - layers).max() < 1e-12 * 10
    assert (sweep.layer(16) == sweep.layer(0)).all()


@pytest.mark.parametrize("functional", ["F", "H"])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_in_the_plane(functional, strategy):
    """n = 2: the same functions, between parameter spaces."""
    section = annulus()
    plane = section.points[:, :2]
    layers = np.array([plane @ np.array([[1, 0.2 * t], [0, 1 + t]]).T + [t, 0] for t in np.linspace(0, 1, 4)])
    sweep = project_layers(
        plane, section.quads, layers[:, section.ring], loops=section.loops, functional=functional, strategy=strategy,
        target_points=layers[-1],
    )  # fmt: skip
    assert np.abs(sweep.points() - layers).max() < 1e-13 * 10


def test_conditions_and_ranks_are_those_of_fit_affine():
    section = dome(square())
    layers = warped(section)
    rings = layers[:, section.ring]
    for functional in FUNCTIONALS:
        sweep = place(section, layers, functional=functional, strategy="source")
        for k in range(7):
            phi = fit_affine(rings[0], rings[k], functional)
            assert sweep.ranks[k] == phi.rank
            assert sweep.conditions[k] == phi.condition or abs(sweep.conditions[k] / phi.condition - 1) < 1e-9


class TestHardRings:
    section = dome(square())

    @pytest.mark.parametrize(("strategy", "functional"), list(itertools.product(STRATEGIES, FUNCTIONALS)))
    def test_a_ring_on_a_line_is_named(self, strategy, functional):
        layers = warped(self.section)
        layers[3, :, :] = layers[3, :, :1] * np.array([1.0, 2.0, 0.5])
        with pytest.raises(ProjectionError, match="layer 3") as caught:
            place(self.section, layers, strategy=strategy, functional=functional)
        assert (caught.value.layer, caught.value.loop) == (3, 0)

    def test_a_collapsed_target_is_named(self):
        layers = warped(self.section)
        layers[-1] = 1.0
        with pytest.raises(ProjectionError) as caught:
            place(self.section, layers)
        assert (caught.value.layer, caught.value.loop) == (6, 0)

    def test_a_hole_on_a_line_is_named(self):
        section = annulus()
        layers = warped(section)
        layers[2, section.loops[1]] = np.outer(np.linspace(0, 1, len(section.loops[1])), [1, 1, 1])
        with pytest.raises(ProjectionError) as caught:
            place(section, layers)
        assert (caught.value.layer, caught.value.loop) == (2, 1)

    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_two_coinciding_nodes_are_harmless(self, strategy):
        layers = bent(self.section, 90, 6)
        a, b = self.section.loops[0][3:5]
        layers[:, b] = layers[:, a]
        section = type(self.section)(layers[0], self.section.quads, self.section.loops)
        points = place(section, layers, strategy=strategy).points()
        assert np.abs(points - layers).max() < 1e-11
        layers = warped(section)
        assert np.isfinite(place(section, layers, strategy=strategy).points()).all()

    def test_not_a_number_is_named(self):
        layers = warped(self.section)
        layers[2, self.section.ring[5], 1] = np.nan
        with pytest.raises(InputError, match="layer 2, ring node 5"):
            place(self.section, layers)

    def test_rings_of_unequal_length(self):
        rings = [layer[self.section.ring] for layer in warped(self.section)]
        rings[2] = rings[2][:-1]
        with pytest.raises(InputError, match="same number of nodes"):
            project_layers(self.section.points, self.section.quads, rings, loops=self.section.loops, strategy="source")

    def test_both_needs_a_target(self):
        with pytest.raises(InputError, match="target_points"):
            place(self.section, warped(self.section), target_points=None)

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"functional": "K"}, "'F', 'G', 'H'"),
            ({"residual_tolerance": 0.0}, "residual_tolerance"),
            ({"residual_tolerance": float("nan")}, "residual_tolerance"),
            ({"strategy": "average"}, "'source', 'advancing', 'both'"),
            ({"target_points": np.zeros((3, 3))}, "target_points"),
        ],
    )
    def test_options_are_checked(self, change, message):
        with pytest.raises(InputError, match=message):
            place(self.section, warped(self.section), **change)

    def test_rings_must_follow_the_loops(self):
        layers = warped(self.section)
        rings = np.roll(layers[:, self.section.ring], 1, axis=1)
        with pytest.raises(InputError, match="disagree"):
            project_layers(layers[0], self.section.quads, rings, loops=self.section.loops, strategy="source")

    def test_loose_nodes_are_refused(self):
        layers = warped(self.section)
        loose = np.concatenate([layers, np.zeros((len(layers), 1, 3))], axis=1)
        with pytest.raises(InputError, match="no boundary node"):
            project_layers(
                loose[0], self.section.quads, loose[:, self.section.ring], loops=self.section.loops, strategy="source"
            )
