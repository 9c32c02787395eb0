"""Orders above 2: the lattice is VTK's, nodes are on the CAD, straight stays straight, others read the files."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep import io
from cadsweep.errors import InputError, InvertedHexError
from cadsweep.io.cgns_zones import turned_quads
from cadsweep.io.msh_common import HEX_TYPES, QUAD_TYPES, hex_order, quad_order
from cadsweep.lattice import find_rows, lexicographic, number_lattice, quad_lexicographic, unique_rows
from cadsweep.mesh import HexMesh
from cadsweep.orders.elevate import elevate
from cadsweep.quality import check_mesh, positive_inside

from ..io.io_meshes import box, twisted_box
from .order_shapes import roll

ORDERS = range(1, 9)


def _turned(mesh: HexMesh) -> HexMesh:
    """The same body with nodes renumbered, so that neighbours see edges and faces from all sides."""
    number = np.random.default_rng(3).permutation(mesh.n_nodes)
    points = np.empty_like(mesh.points)
    points[number] = mesh.points
    boundaries = {name: number[quads] for name, quads in mesh.boundaries.items()}
    return HexMesh(points=points, hexes=number[mesh.hexes], boundaries=boundaries, parts=mesh.parts)


def _rolled(order: int, n: int = 2) -> tuple[HexMesh, float]:
    """A rolled plate and its volume; its outside lies on two cylinders."""
    return roll(_turned(box(n, 1, 1, size=(1.0, 1.0, 1.0))), order), (4.0**2 - 3.0**2) / 2


@pytest.mark.parametrize("order", ORDERS)
def test_the_lattice_is_vtks(order):
    vtk = pytest.importorskip("vtkmodules.vtkCommonDataModel")
    n = order + 1
    for place, number in enumerate(lexicographic(order).tolist()):
        at = (place % n, place // n % n, place // n // n)
        assert vtk.vtkLagrangeHexahedron.PointIndexFromIJK(*at, (order, order, order)) == number


@pytest.mark.parametrize("order", [2, 3, 5])
def test_neighbours_share_the_nodes_between_them(order):
    mesh = _turned(twisted_box())
    high = elevate(mesh, order=order, nodes=27)
    np.testing.assert_array_equal(high.points[: mesh.n_nodes], mesh.points)
    np.testing.assert_array_equal(high.hexes[:, :8], mesh.hexes)
    assert len(np.unique(high.hexes)) == high.n_nodes == len(np.unique(high.points.round(9), axis=0))
    before, after = (positive_inside(m.points, m.hexes)[1] for m in (mesh, high))
    np.testing.assert_allclose(after, before, rtol=1e-12)
    report = check_mesh(high)
    assert report.valid
    assert report.order == order


@pytest.mark.parametrize("order", [3, 4])
def test_straight_hexes_stay_trilinear_bit_for_the_rounding(order):
    mesh = _turned(twisted_box())
    high = elevate(mesh, order=order)
    at = np.arange(order + 1) / order
    ends = np.stack([1.0 - at, at], axis=1)
    corners = mesh.points[mesh.hexes[:, [0, 1, 3, 2, 4, 5, 7, 6]]].reshape(-1, 2, 2, 2, 3)
    expected = np.einsum("kK,jJ,iI,mKJIc->mkjic", ends, ends, ends, corners).reshape(mesh.n_hexes, -1, 3)
    np.testing.assert_allclose(high.points[high.hexes[:, lexicographic(order)]], expected, atol=1e-13)


@pytest.mark.parametrize("order", [3, 4, 5])
def test_nodes_are_on_the_surface_and_the_volume_converges(order):
    """Halving the size divides the error of the volume by 2^(p + 1) but for terms of higher order."""
    errors = []
    for n in (1, 2):
        mesh, volume = _rolled(order, n)
        for name, radius in (("source", 3.0), ("target", 4.0)):
            on = mesh.points[np.unique(mesh.boundaries[name])]
            np.testing.assert_allclose(np.hypot(on[:, 0], on[:, 2]), radius, rtol=1e-14)
        assert check_mesh(mesh).valid
        errors.append(abs(positive_inside(mesh.points, mesh.hexes)[1].sum() - volume))
    assert errors[1] < errors[0] / (0.9 * 2 ** (order + 1))


def test_a_fold_is_refused_with_its_place():
    mesh = box(2, 2, 2)
    with pytest.raises(InvertedHexError, match=r"order 3 .* at \("):
        elevate(mesh, order=3, surfaces=[(mesh.boundaries["source"], lambda p: p + [0.0, 0.0, 3.0])])
    with pytest.raises(InputError, match="2 to 8"):
        elevate(mesh, order=9)
    with pytest.raises(InputError, match="order 3 already"):
        elevate(elevate(mesh, order=3), order=4)


WAYS = [
    (".vtu", {}, 8),
    (".vtkhdf", {}, 8),
    (".mesh", {}, 8),
    (".msh", {}, 8),
    (".msh", {"binary": False}, 8),
    (".msh", {"version": "2.2"}, 8),
    (".cgns", {}, 4),
]


@pytest.mark.parametrize(
    ("suffix", "options", "order"), [(suffix, options, order) for suffix, options, most in WAYS for order in (3, most)]
)
def test_files_bring_the_mesh_back(suffix, options, order, tmp_path):
    mesh, _ = _rolled(order)
    mesh.write(tmp_path / f"ring{suffix}", **options)
    back = io.read(tmp_path / f"ring{suffix}")
    assert back.order == order
    for name in back.boundaries.keys() & mesh.boundaries.keys():
        quads = mesh.boundaries[name]
        np.testing.assert_array_equal(back.points[back.boundaries[name]], mesh.points[quads])
    if options.get("version") != "2.2":  # where a quad has one name
        assert sorted(back.boundaries) == sorted(mesh.boundaries)
    np.testing.assert_array_equal(back.points[back.hexes], mesh.points[mesh.hexes])


@pytest.mark.parametrize(
    ("name", "most"),
    [("a.inp", 2), ("a.bdf", 2), ("a.cgns", 4), ("a.med", 2), ("a.e", 2), ("a.su2", 1), ("polyMesh", 1)],
)
def test_formats_without_the_order_refuse_it_and_say_which_they_have(name, most, tmp_path):
    for order in range(most + 1, most + 3):
        mesh, _ = _rolled(order)
        with pytest.raises(InputError, match=f"no hexahedra of order {order}.*order={most}"):
            mesh.write(tmp_path / name)
    with pytest.raises(InputError, match="order=1"):
        mesh.write(tmp_path / "a.msh", version="fluent")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("order", ORDERS)
def test_the_order_of_nodes_is_gmshs(order):
    gmsh = pytest.importorskip("gmsh")
    n = order + 1
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        for kind, numbers, of_vtk in (
            (HEX_TYPES[n**3], hex_order(n**3), lexicographic(order)),
            (QUAD_TYPES[n**2], quad_order(n**2), quad_lexicographic(order)),
        ):
            _, dimension, own_order, _, places, _ = gmsh.model.mesh.getElementProperties(kind)
            assert own_order == order
            at = np.rint((np.reshape(places, (-1, dimension)) + 1) / 2 * order).astype(int)
            np.testing.assert_array_equal(of_vtk[at @ n ** np.arange(dimension)], numbers)
    finally:
        gmsh.finalize()


@pytest.mark.parametrize(("order", "suffix"), [(3, ".msh"), (4, ".msh"), (3, ".cgns"), (4, ".cgns")])
def test_gmsh_reads_the_same_volume(order, suffix, tmp_path):
    gmsh = pytest.importorskip("gmsh")
    mesh, _ = _rolled(order)
    mesh.write(tmp_path / f"ring{suffix}")
    gmsh.initialize(interruptible=False, readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 2)
        gmsh.open(str(tmp_path / f"ring{suffix}"))
        kind = HEX_TYPES[(order + 1) ** 3]
        places, weights = gmsh.model.mesh.getIntegrationPoints(kind, f"Gauss{3 * order}")
        _, determinants, _ = gmsh.model.mesh.getJacobians(kind, places)
        volume = np.sum(np.reshape(determinants, (-1, len(weights))) * weights)
        _, _, nodes = gmsh.model.mesh.getElements(2)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        at = dict(zip(tags.tolist(), np.reshape(coordinates, (-1, 3)), strict=True))
        quads = np.array([at[tag] for tag in np.concatenate(nodes).tolist()])
    finally:
        gmsh.finalize()
    assert volume == pytest.approx(positive_inside(mesh.points, mesh.hexes)[1].sum(), rel=1e-9)
    of_mesh = mesh.points[np.concatenate([q.ravel() for q in mesh.boundaries.values()])]
    np.testing.assert_allclose(np.unique(quads, axis=0), np.unique(of_mesh, axis=0))


@pytest.mark.parametrize("suffix", [".vtu", ".vtkhdf"])
def test_vtk_reads_the_same_body(suffix, tmp_path):
    """VTK evaluates its own shape functions at a place of no node, as tensors of Lagrange polynomials do."""
    pyvista = pytest.importorskip("pyvista")
    mesh, _ = _rolled(3)
    mesh.write(tmp_path / f"ring{suffix}")
    grid = pyvista.read(tmp_path / f"ring{suffix}")
    assert set(grid.celltypes) == {72}
    at = np.array([0.21, 0.57, 0.83])
    nodes = np.arange(4) / 3
    values = [
        np.array([np.prod([(x - b) / (a - b) for b in nodes if b != a]) for a in nodes])
        for x in at
    ]  # fmt: skip
    weights = np.einsum("k,j,i->kji", values[2], values[1], values[0]).ravel()
    for cell in range(mesh.n_hexes):
        place, own = [0.0] * 3, [0.0] * 64
        grid.GetCell(cell).EvaluateLocation(_sub_id(), at.tolist(), place, own)
        expected = weights @ mesh.points[mesh.hexes[cell, lexicographic(3)]]
        np.testing.assert_allclose(place, expected, rtol=1e-12)


def _sub_id():
    reference = pytest.importorskip("vtkmodules.vtkCommonCore").reference
    return reference(0)


@pytest.mark.parametrize("order", [3, 6])
def test_mfem_reads_the_same_volume(order, tmp_path):
    mfem = pytest.importorskip("mfem.ser")
    mesh, _ = _rolled(order)
    mesh.write(tmp_path / "ring.mesh")
    read = mfem.Mesh(str(tmp_path / "ring.mesh"), 1, 1)
    # MFEM's own GetElementVolume takes too few points for a Jacobian of this degree.
    rule, volume = mfem.IntRules.Get(5, 3 * order), 0.0
    for element in range(read.GetNE()):
        change = read.GetElementTransformation(element)
        for point in (rule.IntPoint(q) for q in range(rule.GetNPoints())):
            change.SetIntPoint(point)
            volume += point.weight * change.Weight()
    assert read.GetNodalFESpace().GetMaxElementOrder() == order
    assert volume == pytest.approx(positive_inside(mesh.points, mesh.hexes)[1].sum(), rel=1e-9)


@pytest.mark.parametrize("order", [2, 3, 5])
def test_mfem_sees_the_same_polynomial_between_the_nodes(order, tmp_path):
    mfem = pytest.importorskip("mfem.ser")
    mesh, _ = _rolled(order)
    mesh.write(tmp_path / "ring.mesh")
    read = mfem.Mesh(str(tmp_path / "ring.mesh"), 1, 1)
    nodes = np.arange(order + 1) / order
    at = (0.21, 0.57, 0.83)
    along = [[np.prod([(x - b) / (a - b) for b in nodes if b != a]) for a in nodes] for x in at]
    weights = np.einsum("k,j,i->kji", along[2], along[1], along[0]).ravel()
    point = mfem.IntegrationPoint()
    point.Set3(*at)
    for element in range(mesh.n_hexes):
        place = read.GetElementTransformation(element).Transform(point)
        expected = weights @ mesh.points[mesh.hexes[element, lexicographic(order)]]
        np.testing.assert_allclose(place, expected, rtol=0, atol=1e-13 * np.abs(mesh.points).max())


def test_numbers_of_one_hex_are_a_permutation():
    lattice = number_lattice(np.arange(8)[None], 8, 4)
    assert sorted(lattice.hexes[0].tolist()) == list(range(125))
    assert lattice.n_nodes == 125


@pytest.mark.cad
@pytest.mark.parametrize("order", [3, 6])
def test_nodes_of_a_tube_lie_on_its_cylinders(order):
    cq = pytest.importorskip("cadquery")
    import cadsweep as cs

    mesh = cs.sweep_mesh(cq.Workplane().circle(3).circle(2).extrude(4), size=1.5, layers=2, order=order)
    assert mesh.hexes.shape[1] == (order + 1) ** 3
    sides = np.unique(np.concatenate([quads for name, quads in mesh.boundaries.items() if name.startswith("side")]))
    radius = np.hypot(*mesh.points[sides, :2].T)
    assert np.minimum(abs(radius - 2), abs(radius - 3)).max() < 1e-9
    volume = positive_inside(mesh.points, mesh.hexes)[1].sum()
    assert volume == pytest.approx(np.pi * 5 * 4, rel=10.0**-order)


@pytest.mark.cad
def test_two_zones_of_order_3_share_their_contact_in_cgns(tmp_path):
    """Each zone has the contact's quads outward from itself: from one side they are turned, edges and inside, too."""
    cq = pytest.importorskip("cadquery")
    import cadsweep as cs

    model = cq.Assembly().add(cq.Workplane().circle(1).extrude(1), name="low")
    model.add(cq.Workplane().circle(1).extrude(1).translate((0, 0, 1)), name="high")
    mesh = cs.sweep_mesh(model, size=1.0, order=3, allow_coarse=True)
    mesh.write(tmp_path / "two.cgns")
    back = io.read(tmp_path / "two.cgns")
    assert check_mesh(back).valid
    np.testing.assert_array_equal(back.points[back.interfaces["low__high"]], mesh.points[mesh.interfaces["low__high"]])


def test_turning_a_quad_exchanges_its_axes():
    for size in (4, 8, 9, 16, 25):
        quad = np.arange(size)[None]
        once = turned_quads(quad)
        np.testing.assert_array_equal(once[0, :4], [0, 3, 2, 1])
        np.testing.assert_array_equal(turned_quads(once), quad)
    table = quad_lexicographic(3).reshape(4, 4)
    np.testing.assert_array_equal(turned_quads(np.arange(16)[None])[0, table], table.T)


@pytest.mark.parametrize("width", [2, 4])
def test_rows_are_found_where_they_stand(width):
    rng = np.random.default_rng(width)
    known, _ = unique_rows(np.sort(rng.integers(0, 50, (800, width)), axis=1))
    picked = rng.integers(0, len(known), 300)
    np.testing.assert_array_equal(find_rows(known, known[picked], "side"), picked)
    for strange in (known[:1] + np.eye(width, dtype=np.int64)[-1] * 100, np.zeros((1, width), dtype=np.int64) + 99):
        with pytest.raises(InputError, match="a side is none"):
            find_rows(known, strange, "side")
