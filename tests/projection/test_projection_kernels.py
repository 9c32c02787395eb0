"""The compiled product against numpy, whatever the shape; its memory, and its bits on any number of threads."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from cadsweep.projection import kernels, project_layers
from cadsweep.projection.fitting import factorise_pairs
from cadsweep.projection.functionals import RingFactors

from .projection_sections import bent, dome, square


@pytest.mark.parametrize("n_nodes", [1, 127, 128, 129, 500])
@pytest.mark.parametrize("r", [4, 5, 7, 8, 12, 13])
@pytest.mark.parametrize("n_layers", [1, 3, 20])
def test_product_and_rings(n_nodes, r, n_layers):
    rng = np.random.default_rng(n_nodes + r)
    basis, coefficients = rng.standard_normal((n_nodes, r)), rng.standard_normal((n_layers, r, 3))
    ring_nodes = rng.permutation(n_nodes)[: n_nodes // 3]
    rings = rng.standard_normal((n_layers, len(ring_nodes), 3))
    out = np.full((n_layers, n_nodes, 3), np.nan)
    kernels.place(kernels.pack(basis), coefficients, ring_nodes, rings, out)
    expected = basis @ coefficients
    expected[:, ring_nodes] = rings
    assert np.abs(out - expected).max() < 1e-13 * r
    assert (out[:, ring_nodes] == rings).all()


def test_bits_do_not_depend_on_the_number_of_threads(monkeypatch):
    rng = np.random.default_rng(0)
    basis, coefficients = rng.standard_normal((1000, 7)), rng.standard_normal((300, 7, 3))
    ring_nodes, rings = np.arange(100), rng.standard_normal((300, 100, 3))
    results = []
    for threads in (1, 2, 5):
        monkeypatch.setattr(kernels, "n_threads", lambda threads=threads: threads)
        out = np.empty((300, 1000, 3))
        kernels.place(kernels.pack(basis), coefficients, ring_nodes, rings, out)
        results.append(out)
    assert all((out == results[0]).all() for out in results)


def test_placing_takes_little_more_memory_than_the_result():
    section = dome(square(30))
    layers = bent(section, 90, 200)
    sweep = project_layers(
        section.points, section.quads, layers[:, section.ring], loops=section.loops, target_points=layers[-1]
    )
    sweep.layer(1)  # what is compiled and packed once
    tracemalloc.start()
    points = sweep.points()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= 1.2 * points.nbytes


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("flatness", [1.0, 1e-3, 1e-6, 0.0])
def test_factors_of_many_rings_are_those_of_each(n, flatness):
    """Against numpy's factorisation, ring by ring, down to rings that are exactly planar."""
    rng = np.random.default_rng(1)
    rings = rng.standard_normal((6, 40, n))
    rings[..., -1] *= flatness
    turn = np.linalg.qr(rng.standard_normal((n, n)))[0]
    rings = rings @ turn + 10 * rng.standard_normal(n)
    centers = rings.mean(axis=1)
    factors, products = factorise_pairs(rings, centers)
    assert isinstance(factors, RingFactors)
    for k in range(6):
        X = rings[max(k - 1, 0)] - centers[max(k - 1, 0)]
        values = np.linalg.svd(X, compute_uv=False)
        assert np.abs(factors.values[k] - values).max() < 1e-13 * values[0] * 10
        # X^T Y = Vt^T diag(values) Q^T Y, whatever the signs within.
        Y = rings[k] - centers[k]
        back = factors.Vt[k].T @ (factors.values[k][:, None] * products[k])
        assert np.abs(back - X.T @ Y).max() < 1e-12 * values[0] ** 2
