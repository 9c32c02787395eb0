"""Refined meshes are nested, lie on the CAD model, and converge as theory says."""

import math
import pickle

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import InputError

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [pytest.mark.cad, pytest.mark.timeout(300)]

RADIUS, BEND = 1.0, 3.0


def elbow():
    """A quarter of a torus: every face but the caps is curved in both directions."""
    return cq.Workplane("XY").circle(RADIUS).revolve(90, (BEND, 0, 0), (BEND, 1, 0))


def ring():
    return cq.Workplane("XY").rect(1, 1).revolve(360, (3, 0, 0), (3, 1, 0))


def plate():
    plate = cq.Workplane().box(2, 1, 0.3).faces(">Z").workplane().hole(0.4)
    plate.faces("%Cylinder").tag("hole")
    return plate


def stepped_side():
    """Its long sides are two faces each, so that edges along the sweep end between the caps."""
    lower = cq.Workplane().rect(2, 1).extrude(1)
    return lower.faces(">Z").workplane().rect(2, 1).extrude(0.5, combine="a", clean=False)


def boss():
    """A round boss on a block: columns of two heights."""
    return cq.Workplane().box(3, 2, 1).faces(">Z").workplane().circle(0.5).extrude(0.6)


def assembly():
    """Two blocks that share a face, and a pin beside them."""
    model = cq.Assembly(name="three")
    model.add(cq.Workplane().box(2, 2, 1), name="low")
    model.add(cq.Workplane().box(2, 2, 0.5), name="high", loc=cq.Location((0, 0, 0.75)))
    model.add(cq.Workplane().circle(0.5).extrude(1), name="pin", loc=cq.Location((5, 0, 0)))
    return model


@pytest.mark.parametrize(
    ("part", "options"),
    [
        (boss, {"size": 0.4}),
        (assembly, {"size": 0.4}),
        (elbow, {"size": 0.5, "layers": 5}),
        (ring, {"size": 0.5, "layers": 12}),
        (plate, {"size": 0.3, "layers": 2, "strategy": "source"}),
        (stepped_side, {"size": 0.5}),
        (lambda: elbow().translate((1000, 0, 0)), {"size": 0.5, "layers": 5}),
    ],
    ids=["boss", "assembly", "elbow", "ring", "plate", "stepped", "far away"],
)
def test_coarse_nodes_stay_and_hexes_nest(part, options):
    coarse = cs.sweep_mesh(part(), allow_coarse=True, **options)
    fine = cs.refine(coarse)
    assert fine.n_hexes == 8 * coarse.n_hexes
    kept = fine.info["coarse_nodes"]
    assert np.array_equal(fine.points[kept], coarse.points)
    # Every coarse hex has eight pieces, and each of its corners is a corner of one of them.
    assert np.array_equal(np.bincount(fine.parents), np.full(coarse.n_hexes, 8))
    of_parent = fine.hexes[np.argsort(fine.parents, kind="stable")].reshape(coarse.n_hexes, -1)
    for corner in range(8):
        assert ((of_parent == kept[coarse.hexes[:, corner], None]).sum(axis=1) == 1).all()
    # The names are carried, quad by quad: every named quad is four.
    assert {name: 4 * len(quads) for name, quads in coarse.boundaries.items()} == {
        name: len(quads) for name, quads in fine.boundaries.items()
    }
    for name, quads in coarse.boundaries.items():
        assert set(kept[quads].ravel()) <= set(fine.boundaries[name].ravel())
    assert {name: 4 * len(quads) for name, quads in coarse.interfaces.items()} == {
        name: len(quads) for name, quads in fine.interfaces.items()
    }
    for name, ids in coarse.parts.items():
        assert set(fine.parents[fine.parts[name]]) == set(ids)
    assert fine.info["quality"].valid


def test_cells_follow_the_curves_of_the_model_and_two_levels_are_one_after_the_other():
    coarse = cs.sweep_mesh(boss(), size=0.4, allow_coarse=True)
    fine = cs.refine(coarse, 2)
    assert np.array_equal(fine.points, cs.refine(cs.refine(coarse)).points)
    off = [abs(mesh.info["quality"].volume / coarse.info["cad_volume"] - 1.0) for mesh in (coarse, fine)]
    assert off[1] == pytest.approx(off[0] / 16, rel=0.1)  # second order: 1 / 4 a level
    on_boss = fine.points[np.unique(fine.boundaries["side_5"])]
    assert np.allclose(np.hypot(on_boss[:, 0], on_boss[:, 1]), 0.5, atol=1e-9)


def test_two_levels_are_one_after_the_other_and_the_option_does_the_same():
    coarse = cs.sweep_mesh(elbow(), size=0.6, layers=4, allow_coarse=True)
    twice, stepwise = cs.refine(coarse, 2), cs.refine(cs.refine(coarse))
    assert np.array_equal(twice.points, stepwise.points)
    assert np.array_equal(twice.hexes, stepwise.hexes)
    assert np.array_equal(np.bincount(twice.parents), np.full(coarse.n_hexes, 64))
    assert np.array_equal(twice.points[twice.info["coarse_nodes"]], coarse.points)
    at_once = cs.sweep_mesh(elbow(), size=0.6, layers=4, refine=2, allow_coarse=True)
    assert np.array_equal(at_once.points, twice.points)
    assert at_once.info["sweeps"][0]["layers"] == 16


def test_new_nodes_lie_on_the_torus():
    fine = cs.sweep_mesh(elbow(), size=0.6, layers=4, refine=2, allow_coarse=True)
    sides = np.unique(np.concatenate([q.ravel() for name, q in fine.boundaries.items() if name.startswith("side")]))
    x, y, z = fine.points[sides].T
    off = np.hypot(np.hypot(x - BEND, z) - BEND, y) - RADIUS
    assert np.abs(off).max() < 1e-9


def test_volume_and_area_converge_at_second_order():
    meshes = [cs.sweep_mesh(elbow(), size=0.6, layers=4, allow_coarse=True)]
    for _ in range(3):
        meshes.append(cs.refine(meshes[-1]))
    reports = [mesh.info["quality"] for mesh in meshes]
    exact = {"volume": math.pi**2 / 2 * RADIUS**2 * BEND, "side": math.pi**2 * RADIUS * BEND}
    volumes = [report.volume for report in reports]
    sides = [sum(area for name, area in report.areas.items() if name.startswith("side")) for report in reports]
    for figure, values in (("volume", volumes), ("side", sides)):
        errors = np.abs(np.array(values) - exact[figure])
        orders = np.log2(errors[:-1] / errors[1:])
        assert np.abs(orders[1:] - 2.0).max() < 0.1, (figure, orders)


def test_poissons_equation_converges_at_second_order_over_four_levels():
    skfem = pytest.importorskip("skfem")
    from skfem.helpers import dot, grad

    def solution(x):
        return np.sin(x[0]) * np.cosh(0.5 * x[1]) * np.cos(0.7 * x[2])

    factor = -(-1.0 + 0.25 - 0.49)  # -div grad of the solution over the solution

    def error(mesh):
        cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
        corners = skfem.MeshHex.init_refdom().p.T
        order = [int(np.flatnonzero((cube == corner).all(axis=1))[0]) for corner in corners]
        basis = skfem.Basis(skfem.MeshHex(mesh.points.T, mesh.hexes[:, order].T), skfem.ElementHex1(), intorder=4)
        stiffness = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis)
        load = skfem.LinearForm(lambda v, w: factor * solution(w.x) * v).assemble(basis)
        values = solution(basis.doflocs)
        # Direct, the finest level alone would take longer than all the rest of this file.
        solver = skfem.solver_iter_pcg(rtol=1e-10)
        solved = skfem.solve(*skfem.condense(stiffness, load, x=values, D=basis.get_dofs()), solver=solver)
        off = skfem.Functional(lambda w: (w["u"] - solution(w.x)) ** 2).assemble(basis, u=basis.interpolate(solved))
        return math.sqrt(off)

    mesh = cs.sweep_mesh(elbow(), size=0.9, layers=4, allow_coarse=True)
    errors = [error(mesh)]
    for _ in range(3):
        mesh = cs.refine(mesh)
        errors.append(error(mesh))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (orders > 1.7).all(), orders


def test_a_mesh_of_order_two_stays_one():
    coarse = cs.sweep_mesh(plate(), size=0.4, layers=1, order=2)
    fine = cs.refine(coarse)
    assert fine.hexes.shape == (8 * coarse.n_hexes, 20)
    corners = np.unique(coarse.hexes[:, :8])
    assert np.array_equal(fine.points[fine.info["coarse_nodes"]], coarse.points[corners])


def test_what_cannot_be_refined_is_said(tmp_path):
    mesh = cs.sweep_mesh(plate(), size=0.5, layers=1)
    mesh.write(tmp_path / "plate.vtu")
    for stranger in (cs.read(tmp_path / "plate.vtu"), pickle.loads(pickle.dumps(mesh))):
        with pytest.raises(InputError, match="needs the CAD model"):
            cs.refine(stranger)
    for levels in (0, 9, 1.5, True):
        with pytest.raises(InputError, match="levels must be"):
            cs.refine(mesh, levels)
    with pytest.raises(InputError, match="without refine"):
        cs.stream_mesh(plate(), tmp_path / "plate.vtkhdf", refine=1)


def test_a_family_shows_the_order_and_the_limit_of_volume_and_area():
    family = cs.make_family(cs.sweep_mesh(boss(), size=0.4, allow_coarse=True), 3)
    assert [mesh.n_hexes for mesh in family.meshes] == [family.meshes[0].n_hexes * 8**k for k in range(3)]
    volume = family.convergence["volume"]
    exact = family.meshes[0].info["cad_volume"]
    assert volume.order == pytest.approx(2.0, abs=0.1)
    assert abs(volume.extrapolated - exact) < 0.1 * abs(volume.values[-1] - exact)
    assert volume.index * volume.values[-1] > abs(volume.values[-1] - exact)  # the uncertainty covers the error
    assert family.convergence["area of side_1"].index == 0.0  # a plane wall has its area on every mesh
    assert str(family).splitlines()[0].split()[-2:] == ["the", "finest"]
    assert family.index([3.0, 2.0, 1.5]).order == pytest.approx(1.0)
    with pytest.raises(InputError, match="one value a mesh"):
        family.index([1.0, 2.0])
    with pytest.raises(InputError, match="3 to 7 meshes"):
        cs.make_family(family.meshes[0], 2)


def test_the_quads_at_a_coarse_rim_node_share_what_the_curve_takes():
    """A hole of 8 segments takes 11 degrees from both ends of the fan at each of its nodes, at the first level."""
    plate = cq.Workplane().rect(3, 2).extrude(0.4).faces(">Z").workplane().hole(1)
    mesh = cs.sweep_mesh(plate, size=0.5, layers=1)
    fine = cs.refine(mesh)
    assert (fine.points[fine.info["coarse_nodes"]] == mesh.points).all()
    assert fine.quality().min_scaled_jacobian > 0.9 * mesh.quality().min_scaled_jacobian
    caps = np.concatenate([fine.boundaries[name] for name in ("source", "target")])
    assert set(np.abs(fine.points[caps.ravel()][:, 2] - 0.2).round(9)) == {0.2}
    rim = np.abs(np.hypot(*fine.points[:, :2].T) - 0.5) < 1e-9
    assert rim.sum() == 3 * 16


def test_the_quads_of_columns_share_it_too():
    """A bored pin on a plate: its rim is the outline of a column, and its bore goes through both."""
    part = cq.Workplane().box(20, 20, 3).faces(">Z").workplane().circle(6).extrude(4).faces(">Z").workplane().hole(6)
    mesh = cs.sweep_mesh(part, size=2.5, allow_coarse=True)
    fine = cs.refine(mesh)
    assert (fine.points[fine.info["coarse_nodes"]] == mesh.points).all()
    worst = [one.info["quality"].min_scaled_jacobian for one in (mesh, fine)]
    assert worst[1] > 0.85 * worst[0]
    caps = np.unique(fine.points[:, 2].round(9))
    assert {-1.5, 1.5, 5.5} <= set(caps.tolist())
    assert fine.info["quality"].valid
