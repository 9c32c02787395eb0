"""Derivatives of meshes by parameters, where the exact ones are known."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import CadSweepError, InputError

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(300)]


def box(scale=2.0, width=1.0):
    return cq.Workplane().box(2 * scale, width * scale, 0.5 * scale, centered=False)


def elbow(radius=3.0, angle=80.0):
    return cq.Workplane("XY").circle(1).revolve(angle, (radius, 0, 0), (radius, 1, 0))


def plate(x=0.1):
    return cq.Workplane().box(2, 1, 0.3).faces(">Z").workplane().center(x, 0).hole(0.4)


def test_a_scaled_box_moves_with_its_points():
    found = cs.sensitivity(box, {"scale": 2.0}, wrt="scale", size=1.0)
    assert np.abs(found.derivative - found.mesh.points / 2.0).max() < 1e-7
    assert found.error < 1e-7
    assert (found.step, found.value, found.wrt) == (0.02, 2.0, "scale")


def test_every_node_of_a_bent_bar_turns_about_its_axis():
    """Its flat sides are grids between arcs: what is inside of them moves as their arcs do."""

    def bar(radius):
        return cq.Workplane("XY").rect(1, 1).revolve(80.0, (radius, 0, 0), (radius, 1, 0))

    found = cs.sensitivity(bar, {"radius": 3.0}, wrt="radius", size=0.3, allow_coarse=True)
    x, _, z = found.mesh.points.T
    away = np.hypot(3.0 - x, z)
    exact = np.stack([1.0 - (3.0 - x) / away, np.zeros_like(x), z / away], axis=1)
    assert np.abs(found.derivative - exact).max() < 1e-9


def test_an_elbow_by_its_radius_and_by_its_angle():
    """On the surface a node keeps its angles: x = R - (R + r cos v) cos u, with R - x in the plane of the bend."""
    by_radius = cs.sensitivity(elbow, {"radius": 3.0}, wrt="radius", size=0.6, layers=4, allow_coarse=True)
    mesh = by_radius.mesh
    surface = np.unique(np.concatenate([quads.ravel() for quads in mesh.boundaries.values()]))
    x, _, z = mesh.points[surface].T
    turned = np.arctan2(np.abs(z), 3.0 - x)
    exact = np.stack([1.0 - np.cos(turned), np.zeros_like(x), np.sign(z) * np.sin(turned)], axis=1)
    assert np.abs(by_radius.derivative[surface] - exact).max() < 1e-6
    by_angle = cs.sensitivity(elbow, {"radius": 3.0, "angle": 80.0}, wrt="angle", size=0.6, layers=4, allow_coarse=True)
    # d u / d angle = u / angle, about the axis at x = 3
    exact = np.stack([np.abs(z), np.zeros_like(x), np.sign(z) * (3.0 - x)], axis=1) * (turned / 80.0)[:, None]
    assert np.abs(by_angle.derivative[surface] - exact).max() < 1e-6


def test_a_moving_hole_takes_its_nodes_along_and_leaves_the_outline():
    found = cs.sensitivity(plate, {"x": 0.1}, wrt="x", step=0.01, size=0.25)
    x, y, _ = found.mesh.points.T
    on_hole = np.abs(np.hypot(x - 0.1, y) - 0.2) < 1e-9
    outside = (np.abs(np.abs(x) - 1) < 1e-9) | (np.abs(np.abs(y) - 0.5) < 1e-9)
    assert on_hole.sum() > 8
    assert np.abs(found.derivative[on_hole] - [1, 0, 0]).max() < 1e-7
    assert np.abs(found.derivative[outside]).max() < 1e-7
    # In between nothing moves further than the hole, nor out of its plane.
    assert np.abs(found.derivative[:, 0]).max() < 1.0 + 1e-6
    assert np.abs(found.derivative[:, 2]).max() < 1e-7


def test_the_derivative_predicts_the_mesh_of_a_neighbour():
    found = cs.sensitivity(elbow, {"radius": 3.0, "angle": 80.0}, wrt="angle", size=0.6, layers=4, allow_coarse=True)
    errors = []
    for far in (2.0, 1.0):
        neighbour = cs.sweep_mesh(elbow(angle=80.0 + far), like=found.mesh)
        errors.append(np.abs(found.mesh.points + far * found.derivative - neighbour.points).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)  # what a line misses grows with the square


def test_a_script_gives_the_parameters_that_are_not_given(tmp_path):
    script = tmp_path / "block.py"
    script.write_text("import cadquery as cq\nlength = 4.0\nn = 'a'\nshow_object(cq.Workplane().box(length, 1, 1))\n")
    found = cs.sensitivity(script, wrt="length", size=0.5)
    assert found.value == 4.0
    assert np.abs(found.derivative[:, 0] - found.mesh.points[:, 0] / 4.0).max() < 1e-7
    with pytest.raises(InputError, match=r"no parameter 'width'.*length"):
        cs.sensitivity(script, wrt="width")
    with pytest.raises(InputError, match="must be a finite number"):
        cs.sensitivity(script, wrt="n")


def test_a_parameter_that_changes_the_faces_has_no_derivative():
    def stepped(gap):
        body = cq.Workplane().box(2, 1, 0.5)
        return body if gap <= 1.0 else body.faces(">Z").workplane().hole(0.3)

    with pytest.raises(CadSweepError, match=r"no derivative by 'gap': at gap = 1\.01"):
        cs.sensitivity(stepped, {"gap": 1.0}, wrt="gap", size=0.5)
    with pytest.raises(InputError, match="give step"):
        cs.sensitivity(stepped, {"gap": 0.0}, wrt="gap", size=0.5)
    with pytest.raises(InputError, match="step must be"):
        cs.sensitivity(stepped, {"gap": 1.0}, wrt="gap", step=-1.0)
