"""The compiled loop for planes moves nodes as the one for any surface does."""

import numpy as np
import pytest

from cadsweep.surface.relax import _State, relax_quads

from .surface_shapes import Plane


def shaken_grid(n: int, shake: float):
    """Nodes (the border first) and quads of n x n on a plane that is askew, the inner ones off by up to `shake`."""
    random = np.random.default_rng(n)
    plane = Plane((1.0, 2.0, 3.0), random.normal(size=3))
    uv = np.stack(np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0)), axis=-1).reshape(-1, 2)
    inside = ((uv > 0) & (uv < n)).all(axis=1)
    uv[inside] += random.uniform(-shake, shake, (inside.sum(), 2))
    order = np.argsort(inside, kind="stable")
    number = np.argsort(order).reshape(n + 1, n + 1)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1).reshape(-1, 4)
    # Seen along the sweep: against the outward normal.
    return plane, plane.evaluate(uv[order]), uv[order], quads[:, ::-1], int((~inside).sum())


@pytest.mark.parametrize(("n", "shake"), [(4, 0.3), (9, 0.6), (14, 0.45)])
def test_nodes_on_a_plane_go_where_those_on_any_surface_go(n, shake):
    plane, points, uv, quads, n_fixed = shaken_grid(n, shake)
    moved, moved_uv, worst = relax_quads(plane, points, uv, quads, n_fixed=n_fixed)
    state = _State(plane, points, uv, quads, n_fixed)
    before = state.sines.min()
    state.smooth()
    state.search()
    assert worst > before
    assert worst == pytest.approx(state.sines.min(), abs=1e-9)
    assert np.allclose(moved, state.points, atol=1e-9)
    assert np.allclose(plane.evaluate(moved_uv), moved, atol=1e-12)
    assert (moved[:n_fixed] == points[:n_fixed]).all()


def test_what_is_given_is_not_changed():
    plane, points, uv, quads, n_fixed = shaken_grid(4, 0.3)
    kept = points.copy(), uv.copy()
    relax_quads(plane, points, uv, quads, n_fixed=n_fixed)
    assert (points == kept[0]).all()
    assert (uv == kept[1]).all()
