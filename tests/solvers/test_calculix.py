"""CalculiX solves on swept parts, with the names of their faces as boundary conditions."""

from __future__ import annotations

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.orders.elevate import elevate

from .calculix import POISSON, YOUNG, require_calculix, solve

pytestmark = [pytest.mark.solver, pytest.mark.cad]


@pytest.fixture(autouse=True)
def _calculix():
    require_calculix()
    pytest.importorskip("cadquery")


def angle_with_hole():
    """An L-section 30 long along z, with a hole through one arm: its quads are no rectangles."""
    import cadquery as cq

    section = [(0, 0), (12, 0), (12, 4), (4, 4), (4, 10), (0, 10)]
    return cq.Workplane().polyline(section).close().extrude(30).faces(">Z").workplane(origin=(8, 2, 30)).hole(2)


@pytest.mark.parametrize("nodes", [8, 20])
def test_tension_is_exact(tmp_path, nodes):
    """The patch test: under constant stress the displacements are linear, to the last printed digit.

    u_z = s z / E, u_x = -nu s x / E, u_y = -nu s y / E with s = 100.
    """
    mesh = cs.sweep_mesh(angle_with_hole(), size=2.0, layers=5, bias=2.0)
    if nodes == 20:
        mesh = elevate(mesh, nodes=20)
    low = np.flatnonzero(mesh.points[:, 2] < mesh.points[:, 2].min() + 1e-9)
    assert set(np.unique(mesh.boundaries["source"])) == set(low) or set(np.unique(mesh.boundaries["target"])) == set(
        low
    )
    fixed, loaded = ("source", "target") if low[0] in mesh.boundaries["source"] else ("target", "source")
    x, y, z = (mesh.points - mesh.points[low].min(axis=0)).T
    corner, along_x = (int(i) for i in (np.argmin(x + y + z), low[np.argmax(x[low] - y[low])]))
    assert y[along_x] == 0
    pins = f"{corner + 1}, 1, 2\n{along_x + 1}, 2, 2\n"
    u = solve(tmp_path, mesh, f"*BOUNDARY\n{fixed}, 3, 3\n{pins}*DSLOAD\n{loaded}, P, -100.\n")
    strain = 100 / YOUNG
    exact = np.column_stack([-POISSON * strain * x, -POISSON * strain * y, strain * z])
    assert np.abs(u - exact).max() < 1e-6 * np.abs(exact).max()


def test_bending_of_the_elbow_meets_a_refined_solution(tmp_path):
    """A pipe elbow, clamped at one end and pulled at the other: order 1 and a coarse order 2 against a fine order 2."""
    import cadquery as cq

    elbow = cq.Workplane("XY").moveTo(30, 0).circle(10).circle(7.5).revolve(90, (0, 0), (0, 1))

    def tip(element, order, size, layers):
        mesh = cs.sweep_mesh(elbow, size=size, layers=layers, order=order)
        folder = tmp_path / f"{order}-{layers}"
        folder.mkdir()
        u = solve(folder, mesh, "*BOUNDARY\nsource, 1, 3\n*DSLOAD\ntarget, P, -1.\n", element=element)
        return np.linalg.norm(u[np.unique(mesh.boundaries["target"][:, :4])].mean(axis=0))

    fine = tip("C3D20", 2, 1.7, 14)
    coarse = tip("C3D20", 2, 2.5, 8)
    linear = tip("C3D8I", 1, 1.7, 14)
    # Another size and another element agree with the fine solution.
    assert abs(coarse - fine) < 0.03 * fine
    assert abs(linear - fine) < 0.03 * fine


def test_names_of_a_script_become_boundary_conditions(tmp_path):
    """Faces named in an assembly are node sets and surfaces of the deck."""
    import cadquery as cq

    body = cq.Workplane().box(4, 3, 10)
    part = cq.Assembly().add(body, name="beam")
    part.addSubshape(body.faces("<Z").val(), name="wall")
    part.addSubshape(body.faces(">Z").val(), name="load")
    mesh = cs.sweep_mesh(part, size=1.5)
    wall, load = (next(n for n in mesh.boundaries if word in n) for word in ("wall", "load"))
    u = solve(tmp_path, mesh, f"*BOUNDARY\n{wall}, 1, 3\n*DSLOAD\n{load}, P, -21.\n")
    pulled = u[np.unique(mesh.boundaries[load]), 2]
    # A bar of length 10 under 21 N/mm2 grows by 0.001, a little less with a clamped end.
    assert 0.9e-3 < pulled.mean() < 1.0e-3
