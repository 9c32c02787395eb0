"""The residual: few modes, no noise, carried inwards as a harmonic function."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.projection import project_layers
from cadsweep.projection.residual import compress, cotangent_weights, extend, shortest_segment

from .projection_sections import annulus, circle, disc, dome, l_shape, plate_with_hole, square


def place(section, layers, **options):
    options.setdefault("target_points", layers[-1])
    return project_layers(section.points, section.quads, layers[:, section.ring], loops=section.loops, **options)


def square_to_arcs(n_layers=12):
    """The paper's example 4: every side of a square becomes an arc, on a straight skewed path."""
    section = dome(square(8))
    x, y, z = section.points.T
    bulge = np.c_[x * (1 - y**2) * 0, y * 0, z * 0]
    bulge[:, 0] = 0.3 * x * (1 - y**2)
    bulge[:, 1] = 0.3 * y * (1 - x**2)
    t = np.linspace(0, 1, n_layers + 1)[:, None, None]
    return section, section.points + t**2 * bulge + t * np.array([1.0, 0.0, 4.0])


@pytest.mark.parametrize("strategy", ["source", "advancing", "both"])
def test_the_product_meets_the_rings(strategy):
    section, layers = square_to_arcs()
    sweep = place(section, layers, strategy=strategy)
    product = sweep.basis @ sweep.coefficients
    tolerance = 1e-4 * shortest_segment(sweep.rings, section.loops)
    assert np.linalg.norm(product[:, section.ring] - sweep.rings, axis=-1).max() <= tolerance
    assert sweep.remainder <= tolerance
    missed = place(section, layers, strategy=strategy, residual=False)
    assert missed.n_modes == 0
    assert missed.remainder > 100 * tolerance


def test_modes_are_as_few_as_the_shapes_of_the_residual():
    """Example 4's rings leave the square's affine images in two shapes, one for x and one for y."""
    section, layers = square_to_arcs()
    assert 1 <= place(section, layers, strategy="source").n_modes <= 2


@pytest.mark.parametrize("seed", range(3))
def test_noise_makes_no_modes(seed):
    rng = np.random.default_rng(seed)
    section = dome(square(8))
    layers = section.points + np.linspace(0, 3, 20)[:, None, None] * np.array([0, 0, 1.0])
    segment = 0.25
    layers[1:-1] += rng.uniform(-1, 1, layers[1:-1].shape) * 0.5e-4 * segment / np.sqrt(3)
    assert place(section, layers).n_modes == 0
    section, layers = square_to_arcs(20)
    clean = place(section, layers).n_modes
    layers[1:-1] += (
        rng.uniform(-1, 1, layers[1:-1].shape) * 0.2e-4 * shortest_segment(layers[:, section.ring], section.loops)
    )
    assert place(section, layers).n_modes <= clean


@pytest.mark.parametrize(("b", "n_layers", "rank"), [(60, 200, 3), (400, 300, 5), (30, 4, 2), (20, 50, 20)])
def test_compress_finds_the_rank(b, n_layers, rank):
    rng = np.random.default_rng(b)
    residuals = np.einsum("ir,rkc->kic", rng.standard_normal((b, rank)), rng.standard_normal((rank, n_layers, 3)))
    modes = compress(residuals, 1e-9)
    assert modes.shapes.shape[1] == min(rank, 3 * n_layers)
    assert np.abs(modes.shapes).max() == pytest.approx(1.0)
    back = np.einsum("iq,kqc->kic", modes.shapes, modes.amplitudes)
    assert np.linalg.norm(back - residuals, axis=-1).max() <= 1e-9
    assert modes.remainder <= 1e-9


@pytest.mark.parametrize("make", [lambda: square(7), annulus, l_shape, disc, plate_with_hole])
def test_extension_reproduces_linear_functions(make):
    """Cotangent weights are exact for linear functions on a planar mesh, holes and corners included."""
    section = make()
    values = section.points @ np.array([[1.0, 0.3], [-0.7, 2.0], [0, 0]]) + [0.5, -1.0]
    extended = extend(cotangent_weights(section.points, section.quads), section.ring, values[section.ring])
    assert np.abs(extended - values).max() < 1e-12


def test_extension_is_harmonic():
    """log r on an annulus, to second order in the size of the quads."""
    errors = []
    for refine in (1, 2):
        section = annulus(m=48 * refine, n_radial=8 * refine)
        exact = np.log(np.linalg.norm(section.points, axis=1))[:, None]
        extended = extend(cotangent_weights(section.points, section.quads), section.ring, exact[section.ring])
        errors.append(np.abs(extended - exact).max())
    assert errors[0] < 0.01
    assert errors[1] < 0.3 * errors[0]


def test_extension_stays_within_its_boundary_values():
    section = l_shape()
    rng = np.random.default_rng(0)
    values = rng.uniform(-1, 1, (len(section.ring), 3))
    extended = extend(cotangent_weights(section.points, section.quads), section.ring, values)
    assert (extended <= values.max(axis=0) + 1e-12).all()
    assert (extended >= values.min(axis=0) - 1e-12).all()


def test_the_carry_lifts_the_worst_corner():
    """Quads beside an arc: without the carry the last row is squeezed or torn, with it the row is shared out."""
    section, layers = square_to_arcs()
    target = layers.copy()
    for k in (6, 11):
        worst = []
        for residual in (False, True):
            points = place(section, target, strategy="source", residual=residual).layer(k)
            edges = np.linalg.norm(np.diff(points[section.quads], axis=1), axis=2)
            worst.append(edges.min())
        assert worst[1] >= worst[0]


def test_shortest_segment_leaves_coinciding_nodes_out():
    ring = np.c_[circle(8, 1.0), np.zeros(8)]
    expected = np.linalg.norm(ring[1] - ring[0])
    ring[4] = ring[3]
    assert shortest_segment(ring[None], [np.arange(8)]) == pytest.approx(expected)
