"""Poisson's equation on swept meshes with scikit-fem: the orders of convergence that the elements promise."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep import io
from cadsweep.cells import side_quads, sweep_hexes
from cadsweep.lattice import lexicographic
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate

skfem = pytest.importorskip("skfem")
pytestmark = pytest.mark.solver


def pipe_bend(n: int) -> HexMesh:
    """A quarter of a disc-like section (arcs inside and out) swept through a bend, n quads a side, n layers."""
    s, t = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    ids = np.arange(s.size).reshape(s.shape)
    quads = np.stack([ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]], axis=-1).reshape(-1, 4)
    stations = [np.stack([s.ravel(), t.ravel(), np.full(s.size, w)], axis=-1) for w in np.linspace(0, 1, n + 1)]
    loop = np.concatenate([ids[:-1, 0], ids[-1, :-1], ids[:0:-1, -1], ids[0, :0:-1]])
    parameters = np.concatenate(stations)
    mesh = HexMesh(
        points=place(parameters),
        hexes=sweep_hexes(quads, s.size, n),
        boundaries={
            "source": quads[:, ::-1],
            "target": quads + n * s.size,
            "side_1": side_quads([loop], s.size, n).reshape(-1, 4),
        },
    )
    return mesh


def place(parameters: np.ndarray) -> np.ndarray:
    """The part: radius 1 to 2 over a right angle in the section, bent about the y axis by 0.8 rad at radius 4."""
    radius, angle, turn = 1 + parameters[:, 0], 0.5 * np.pi * parameters[:, 1], 0.8 * parameters[:, 2]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return np.column_stack([(4 + x) * np.cos(turn), y, (4 + x) * np.sin(turn)])


def parameters_of(points: np.ndarray) -> np.ndarray:
    """The inverse of :func:`place`."""
    turn = np.arctan2(points[:, 2], points[:, 0])
    x, y = np.hypot(points[:, 0], points[:, 2]) - 4, points[:, 1]
    return np.column_stack([np.hypot(x, y) - 1, np.arctan2(y, x) / (0.5 * np.pi), turn / 0.8])


def on_part(n: int):
    """Project to the surface of parameters that are multiples of 1 / (2 n): middles of edges and quads."""

    def project(points: np.ndarray) -> np.ndarray:
        return place(np.round(parameters_of(points) * 2 * n) / (2 * n))

    return project


def exact(x):
    return np.sin(0.9 * x[0]) * np.cos(0.7 * x[1]) * np.exp(0.5 * x[2])


def load(x):
    return (0.9**2 + 0.7**2 - 0.5**2) * exact(x)


def error_on(path, element) -> float:
    """L2 error of the solution with the exact values on the boundary."""
    from skfem.helpers import dot, grad

    mesh = skfem.Mesh.load(str(path))
    basis = skfem.Basis(mesh, element, intorder=6)
    stiffness = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis)
    right = skfem.LinearForm(lambda v, w: load(w.x) * v).assemble(basis)
    values = basis.zeros()
    fixed = basis.get_dofs().flatten()
    values[fixed] = exact(basis.doflocs[:, fixed])
    solution = skfem.solve(*skfem.condense(stiffness, right, x=values, D=fixed))
    return float(np.sqrt(skfem.Functional(lambda w: (w["u"] - exact(w.x)) ** 2).assemble(basis, u=solution)))


@pytest.mark.parametrize(("nodes", "order"), [(8, 2), (27, 3)])
def test_poisson_converges_at_its_order(tmp_path, nodes, order):
    errors = []
    for n in (3, 6) if nodes == 27 else (4, 8):
        mesh = pipe_bend(n)
        if nodes == 27:
            quads = np.concatenate(list(mesh.boundaries.values()))
            mesh = elevate(mesh, nodes=27, surfaces=[(quads, on_part(n))])
        io.write(mesh, tmp_path / f"{n}.msh")
        element = skfem.ElementHex1() if nodes == 8 else skfem.ElementHex2()
        errors.append(error_on(tmp_path / f"{n}.msh", element))
    assert np.log2(errors[0] / errors[1]) > order - 0.15


def test_curved_sides_without_the_surface_lose_the_order(tmp_path):
    """The middles on the surface matter: straight hex27 end at the order of the geometry."""
    errors = []
    for n in (3, 6):
        io.write(elevate(pipe_bend(n), nodes=27), tmp_path / f"{n}.msh")
        mesh = skfem.Mesh.load(str(tmp_path / f"{n}.msh"))
        volume = skfem.Functional(lambda w: 1 + 0 * w.x[0]).assemble(skfem.Basis(mesh, skfem.ElementHex2()))
        # Pappus: area of the section times the way of its centroid.
        area = 0.25 * np.pi * (4 - 1)
        way = 0.8 * (4 + (8 - 1) / 3 / area)
        errors.append(abs(volume - area * way))
    assert 1.7 < np.log2(errors[0] / errors[1]) < 2.3


def halved(mesh: HexMesh) -> HexMesh:
    """The same straight-edged mesh with every hex in eight."""
    fine = elevate(mesh, nodes=27)
    grid = fine.hexes[:, lexicographic(2)].reshape(-1, 3, 3, 3)  # z, y, x
    corners = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)]
    children = [
        np.stack([grid[:, k + c, j + b, i + a] for c, b, a in corners], axis=1)
        for k in (0, 1)
        for j in (0, 1)
        for i in (0, 1)
    ]
    return HexMesh(points=fine.points, hexes=np.concatenate(children), boundaries={})


@pytest.mark.cad
@pytest.mark.parametrize(("nodes", "order"), [(8, 2), (27, 3)])
def test_poisson_on_a_part_from_cad(tmp_path, nodes, order):
    """A block with a hole: quads without structure, halved."""
    cq = pytest.importorskip("cadquery")
    import cadsweep as cs

    part = cq.Workplane().box(4, 4, 3).faces(">Z").workplane().hole(1.5)
    # Two or more quads across the wall: on fewer the error does not yet fall at the rate of the element.
    coarse = cs.sweep_mesh(part, size=0.7, layers=4)
    meshes = [coarse, halved(coarse)] if nodes == 27 else [halved(coarse), halved(halved(coarse))]
    errors = []
    for j, mesh in enumerate(meshes):
        (elevate(mesh, nodes=27) if nodes == 27 else mesh).write(tmp_path / f"{j}.msh")
        errors.append(error_on(tmp_path / f"{j}.msh", skfem.ElementHex1() if nodes == 8 else skfem.ElementHex2()))
    assert np.log2(errors[0] / errors[1]) > order - 0.15
