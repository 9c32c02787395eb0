"""Running metrics, reports and limits."""

from __future__ import annotations

import json

import numpy as np
import pytest

from cadsweep.quality import (
    QualityAccumulator,
    boundary_limit,
    check_mesh,
    corner_limits,
    measure_hexes,
    scaled_jacobians,
)

from .quality_meshes import fixed_nodes, hex_soup, random_hexes, swept_block, swept_ring


def wavy(k, xy):
    x, y = xy.T
    return np.c_[x + 0.2 * np.sin(y + k), y + 0.15 * np.cos(2 * x - k), 0.7 * k + 0.2 * np.sin(x * y)]


def test_a_mesh_streamed_layer_by_layer_gets_the_same_figures():
    mesh = swept_block(6, 5, 7, place=wavy)
    s = mesh.structure
    streamed = QualityAccumulator()
    layers = mesh.points.reshape(-1, s.n_nodes, 3)
    for k in range(s.n_layers):
        streamed.add(layers[k], layers[k + 1], s.quads, first_hex=k * len(s.quads), layer=k)
    whole = check_mesh(mesh)
    assert streamed.worst == whole.worst
    assert streamed.min_scaled_jacobian == whole.min_scaled_jacobian
    assert streamed.mean_scaled_jacobian == pytest.approx(whole.mean_scaled_jacobian, rel=1e-12)
    assert streamed.volume == pytest.approx(whole.volume, rel=1e-12)
    assert streamed.n_hexes == whole.n_hexes
    for name, summary in streamed.summaries().items():
        assert np.array_equal(summary.counts, whole.metrics[name].counts)
        assert summary.percentiles == whole.metrics[name].percentiles


def test_summaries_say_what_numpy_says():
    points, hexes = hex_soup(random_hexes(5000, 0.1))
    seen = QualityAccumulator()
    seen.add_hexes(points, hexes)
    measured = measure_hexes(points, hexes)
    for name, summary in seen.summaries().items():
        values = getattr(measured, name)
        assert summary.min == values.min()
        assert summary.max == values.max()
        assert summary.mean == pytest.approx(values.mean())
        assert summary.counts.sum() == len(values)
        assert np.array_equal(summary.counts, np.histogram(values, summary.edges)[0])
        assert summary.counts[0] > 0 or summary.min == values.max()  # over the data's range
        for percent, value in summary.percentiles.items():
            exact = np.percentile(values, percent)
            assert value == pytest.approx(exact, abs=2e-3 * max(1, exact**2))


def test_the_worst_ten_are_the_worst_ten_inverted_first():
    points, hexes = hex_soup(random_hexes(2000, 0.3))
    seen = QualityAccumulator()
    seen.add_hexes(points, hexes)
    values = scaled_jacobians(points, hexes)
    assert [one.id for one in seen.worst] == np.argsort(values, kind="stable")[:10].tolist()
    assert all(one.inverted for one in seen.worst)
    one = seen.worst[0]
    np.testing.assert_allclose(one.center, points[hexes[one.id]].mean(axis=0))
    assert str(one.id) in str(one)


def test_layers_of_the_worst_hexes():
    mesh = swept_block(4, 4, 5)
    points = mesh.points.copy()
    points[3 * mesh.structure.n_nodes + 6] += [0.3, 0.3, 0.3]
    from dataclasses import replace

    worst = check_mesh(replace(mesh, points=points)).worst
    assert {one.layer for one in worst[:8]} == {2, 3}
    assert all(one.id // len(mesh.structure.quads) == one.layer for one in worst)


def test_the_worst_are_those_that_a_sort_finds_and_of_equals_the_first():
    mesh = swept_block(6, 5, 4, place=wavy)
    least = scaled_jacobians(mesh.points, mesh.hexes)
    expected = sorted(range(mesh.n_hexes), key=lambda h: (least[h], h))[:10]
    assert [one.id for one in check_mesh(mesh).worst] == expected
    seen = QualityAccumulator()
    seen.add_hexes(*hex_soup(random_hexes(30, 0.0)))
    assert [one.id for one in seen.worst] == list(range(10))


def test_report_is_json_and_text():
    report = check_mesh(swept_block(place=wavy))
    data = json.loads(json.dumps(report.to_dict(), allow_nan=False))
    assert data["n_hexes"] == report.n_hexes
    assert data["valid"] is True
    assert len(data["worst"]) == 10
    assert sum(report.histogram[1]) == report.n_hexes
    assert f"{report.n_hexes:,} hexahedra" in str(report)


@pytest.mark.parametrize("make", [lambda: swept_block(5, 4, 4, place=wavy), swept_ring, lambda: swept_block(3, 3, 1)])
def test_boundary_limit_bounds_every_position_of_the_inner_nodes(make):
    mesh = make()
    limit = boundary_limit(mesh.points, mesh.structure)
    fixed = fixed_nodes(mesh)
    assert limit.value == pytest.approx(corner_limits(mesh.points, mesh.hexes, fixed).min())
    if limit.hex >= 0:
        assert corner_limits(mesh.points, mesh.hexes, fixed)[limit.hex] == pytest.approx(limit.value)
        assert limit.node in mesh.hexes[limit.hex]
    rng = np.random.default_rng(0)
    for _ in range(5):
        points = mesh.points.copy()
        points[~fixed] += rng.normal(size=(np.count_nonzero(~fixed), 3)) * 0.1
        assert scaled_jacobians(points, mesh.hexes).min() <= limit.value + 1e-12


def test_a_sheared_block_is_limited_by_its_shear():
    # The sides lean by 45 degrees: every upright edge meets the caps' edges at a sine of 1 / sqrt 2.
    mesh = swept_block(3, 3, 3, place=lambda k, xy: np.c_[xy[:, 0] + k, xy[:, 1], np.full(len(xy), float(k))])
    assert boundary_limit(mesh.points, mesh.structure).value == pytest.approx(np.sqrt(0.5))


def test_a_poor_mesh_says_what_its_boundary_allows():
    sheared = swept_block(3, 3, 3, place=lambda k, xy: np.c_[xy[:, 0] + 3 * k, xy[:, 1], np.full(len(xy), float(k))])
    report = check_mesh(sheared)
    # Upright edges lean by 3 in 1: a sine of 1 / sqrt 10.
    assert report.limit.value == pytest.approx(np.sqrt(0.1))
    assert "by boundary nodes alone" in str(report)
    assert report.to_dict()["limit"]["value"] == pytest.approx(np.sqrt(0.1))
    assert check_mesh(swept_block()).limit is None
