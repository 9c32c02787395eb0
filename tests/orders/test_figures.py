"""What is said of bent hexahedra: ratios and bounds of the Jacobian, and the distance between their nodes."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.lattice import lexicographic
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate
from cadsweep.quality import check_mesh
from cadsweep.quality.bernstein import prove

from ..io.io_meshes import box
from .order_shapes import roll


def rolled(order: int, n: int, nodes: int = 27) -> HexMesh:
    return roll(box(n, 1, 1, size=(1.0, 1.0, 1.0)), order, nodes)


def determinants(grid: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Of nodes (n, n, n, 3), indexed k, j, i, at the tensor product of places: by Lagrange polynomials."""
    n = len(grid)
    nodes = np.arange(n) / (n - 1)
    values, slopes = np.empty((len(at), n)), np.empty((len(at), n))
    for a in range(n):
        roots = np.delete(nodes, a)
        polynomial = np.poly1d(roots, r=True) / np.prod(nodes[a] - roots)
        values[:, a], slopes[:, a] = polynomial(at), polynomial.deriv()(at)
    columns = [
        np.einsum("kK,jJ,iI,KJIc->kjic", *(slopes if axis == own else values for own in (2, 1, 0)), grid)
        for axis in range(3)
    ]
    return np.linalg.det(np.stack(columns, axis=-1))


@pytest.mark.parametrize("order", [2, 3, 4])
def test_ratio_and_bound_are_those_of_the_determinant(order):
    mesh = rolled(order, 1)
    proof = prove(mesh.points, mesh.hexes)
    grid = mesh.points[mesh.hexes[0, lexicographic(order)]].reshape(*(order + 1,) * 3, 3)
    same = determinants(grid, np.linspace(0.0, 1.0, 3 * order))
    assert proof.ratios[0] == pytest.approx(same.min() / same.max(), rel=1e-9)
    dense = determinants(grid, np.linspace(0.0, 1.0, 41))
    assert proof.bounds[0] <= dense.min() / same.max() * (1.0 + 1e-9)
    assert proof.bounds[0] > 0.5 * dense.min() / same.max()
    report = check_mesh(mesh)
    assert (report.jacobian_ratio, report.jacobian_bound) == (proof.ratios.min(), proof.bounds.min())
    assert report.to_dict()["jacobian_ratio"] == report.jacobian_ratio
    assert "Jacobian: least over greatest" in str(report)


def test_bricks_have_one_and_order_1_has_none():
    bricks = box(2, 2, 2)
    assert check_mesh(bricks).jacobian_ratio is None
    high = check_mesh(elevate(bricks, order=3))
    assert high.jacobian_ratio == pytest.approx(1.0, abs=1e-12)
    assert high.jacobian_bound == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("order", "nodes"), [(2, 20), (2, 27), (3, 27), (4, 27)])
def test_the_distance_falls_with_the_power_of_the_order_and_one(order, nodes):
    far, near = (rolled(order, n, nodes).info["curved_distance"] for n in (1, 2))
    assert near < far / (0.9 * 2 ** (order + 1))
    # A chord's sagitta is what order 1 is off.
    assert far < 4.0 * (1.0 - np.cos(0.5))
    assert near > 0.0
