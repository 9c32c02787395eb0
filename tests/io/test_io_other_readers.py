"""Every file as other programs' readers see it: nodes, hexes, orientation, names, counts."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from cadsweep import io
from cadsweep.io.sides import SIDES
from cadsweep.quality import positive_inside

from .io_meshes import bent_box, twisted_box, two_parts

NAMES = ["source", "target", "side_1", "side_2", "side_3", "side_4", "walls"]


def exact_volume(mesh):
    return positive_inside(mesh.points, mesh.hexes)[1].sum()


def as_sets(points, cells):
    """Cells as sorted rows of corner coordinates: independent of all numbering."""
    corners = np.round(points[cells], 12)
    rows = [tuple(sorted(map(tuple, cell))) for cell in corners.tolist()]
    return sorted(rows)


@pytest.mark.parametrize("nodes", [8, 20, 27])
@pytest.mark.parametrize("suffix", [".vtu", ".vtkhdf"])
def test_vtk_reads_geometry_and_names(tmp_path, suffix, nodes):
    pv = pytest.importorskip("pyvista")
    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / f"part{suffix}")
    grid = pv.read(tmp_path / f"part{suffix}")
    assert grid.n_cells == mesh.n_hexes
    np.testing.assert_array_equal(grid.points, mesh.points)
    np.testing.assert_array_equal(grid.cells_dict[{8: 12, 20: 25, 27: 29}[nodes]], mesh.hexes)
    assert list(grid.field_data["boundary_names"]) == NAMES
    for name, quads in mesh.boundaries.items():
        assert set(map(tuple, grid.field_data[f"boundary:{name}"])) == set(map(tuple, quads))
    touched = np.asarray(grid.cell_data["boundary"])
    on_source = np.isin(mesh.hexes[:, :8], mesh.boundaries["source"]).any(axis=1)
    assert (touched[on_source] == 0).all()
    assert list(grid.field_data["part_names"]) == ["box"]
    # VTK triangulates curved sides; straight hexes have their exact volume.
    if nodes == 8:
        assert grid.volume == pytest.approx(exact_volume(mesh), rel=1e-3)


@pytest.mark.cad
@pytest.mark.parametrize("nodes", [8, 20, 27])
@pytest.mark.parametrize(
    ("suffix", "options"),
    [
        (".msh", {}),
        (".msh", {"binary": False}),
        (".msh", {"version": "2.2"}),
        (".med", {}),
        (".cgns", {}),
        (".unv", {}),
    ],
)
def test_gmsh_reads_geometry_and_names(tmp_path, suffix, options, nodes):
    pytest.importorskip("gmsh")
    from cadsweep.gmsh_session import gmsh_session

    if suffix == ".unv" and nodes == 27:
        pytest.skip("UNV has no hex27")
    mesh = bent_box(nodes)
    path = tmp_path / f"part{suffix}"
    io.write(mesh, path, **options)
    with gmsh_session("test") as gmsh:
        gmsh.merge(str(path))
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        assert len(tags) == mesh.n_nodes
        order = np.argsort(tags)
        points = xyz.reshape(-1, 3)[order]
        kinds, _, connectivity = gmsh.model.mesh.getElements(3)
        assert [int(k) for k in kinds] == [{8: 5, 20: 17, 27: 12}[nodes]]
        corners = np.searchsorted(tags[order], connectivity[0].reshape(-1, nodes)[:, :8])
        assert as_sets(points, corners) == as_sets(mesh.points, mesh.hexes[:, :8])
        # The integral of the Jacobian as gmsh computes it knows every node of every hex.
        elements = np.concatenate(gmsh.model.mesh.getElements(3)[1])
        volumes = gmsh.model.mesh.getElementQualities(elements, "volume")
        assert np.sum(volumes) == pytest.approx(exact_volume(mesh), rel=1e-9)
        assert min(gmsh.model.mesh.getElementQualities(elements, "minDetJac")) > 0
        found = {}
        for dimension, tag in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dimension, tag).strip()
            entities = gmsh.model.getEntitiesForPhysicalGroup(dimension, tag)
            n = sum(len(ids) for e in entities for ids in gmsh.model.mesh.getElements(dimension, e)[1])
            found[dimension, name] = n
    if suffix == ".cgns":  # gmsh makes its groups of the element sections, not of boundary conditions
        assert found or kinds.size
        return
    expected = {(2, name): len(quads) for name, quads in mesh.boundaries.items()}
    if options.get("version") == "2.2":
        del expected[2, "walls"]
    assert {key: n for key, n in found.items() if key[1]} == {**expected, (3, "box"): mesh.n_hexes}


def test_vtk_reads_cgns(tmp_path):
    pv = pytest.importorskip("pyvista")
    mesh = bent_box(8)
    io.write(mesh, tmp_path / "part.cgns")
    reader = pv.CGNSReader(str(tmp_path / "part.cgns"))
    reader.load_boundary_patch = True
    zone = reader.read()[0][0]
    grid = zone["Internal"]
    np.testing.assert_array_equal(grid.points, mesh.points)
    np.testing.assert_array_equal(grid.cells_dict[12], mesh.hexes)
    patches = zone["Patches"]
    assert {name: patches[name].n_cells for name in list(patches.keys())} == {
        n: len(q) for n, q in mesh.boundaries.items()
    }


def test_vtk_reads_a_zone_a_part_of_cgns(tmp_path):
    pv = pytest.importorskip("pyvista")
    mesh = bent_box(8)
    half = mesh.n_hexes // 2
    low, high = np.arange(half), np.arange(half, mesh.n_hexes)
    faces = mesh.hexes[low, 4:8]
    between = faces[np.isin(faces, mesh.hexes[high]).all(axis=1)]
    mesh = replace(mesh, parts={"low": low, "high": high}, interfaces={"low__high": between}, structure=None)
    io.write(mesh, tmp_path / "part.cgns")
    zones = pv.CGNSReader(str(tmp_path / "part.cgns")).read()[0]
    assert set(zones.keys()) == {"low", "high"}
    for name, ids in mesh.parts.items():
        grid = zones[name]["Internal"] if "Internal" in zones[name].keys() else zones[name]  # noqa: SIM118
        assert as_sets(grid.points, grid.cells_dict[12]) == as_sets(mesh.points, mesh.hexes[ids])


def test_a_cgns_connectivity_names_the_same_quads_in_both_zones(tmp_path):
    h5py = pytest.importorskip("h5py")
    mesh = bent_box(8)
    half = mesh.n_hexes // 2
    faces = mesh.hexes[:half, 4:8]
    between = faces[np.isin(faces, mesh.hexes[half:]).all(axis=1)]
    parts = {"low": np.arange(half), "high": np.arange(half, mesh.n_hexes)}
    mesh = replace(mesh, parts=parts, interfaces={"low__high": between}, structure=None)
    io.write(mesh, tmp_path / "part.cgns")
    quads = []
    with h5py.File(tmp_path / "part.cgns") as file:
        for name, other in (("low", "high"), ("high", "low")):
            zone = file["Base"][name]
            points = np.column_stack([zone["GridCoordinates"][f"Coordinate{axis}"][" data"] for axis in "XYZ"])
            link = zone["ZoneGridConnectivity"]["low__high"]
            assert bytes(link[" data"][()].tobytes()).decode() == other
            numbers = link["PointList"][" data"][()].ravel()
            assert len(numbers) == len(between)
            first = zone["low__high"]["ElementRange"][" data"][()].ravel()[0]
            rows = zone["low__high"]["ElementConnectivity"][" data"][()].reshape(-1, 4)
            quads.append(points[rows[numbers - first] - 1])
    # The donor's quads are the same, seen from the other side.
    assert np.array_equal(np.sort(quads[0], axis=1), np.sort(quads[1], axis=1))
    normals = [np.cross(own[:, 2] - own[:, 0], own[:, 3] - own[:, 1]) for own in quads]
    assert (np.einsum("qd,qd->q", *normals) < 0).all()


@pytest.mark.parametrize("nodes", [8, 20, 27])
def test_vtk_reads_exodus_with_side_sets(tmp_path, nodes):
    pv = pytest.importorskip("pyvista")
    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / "part.e")
    reader = pv.get_reader(str(tmp_path / "part.e"))
    for side_set in range(len(NAMES)):
        reader.reader.SetObjectStatus(3, side_set, 1)  # vtkExodusIIReader::SIDE_SET
    blocks = reader.read()
    grid = next(b for b in blocks[0] if b is not None)
    # VTK's reader numbers the nodes of each block anew and keeps them in single precision.
    seen = grid.points[grid.cells_dict[{8: 12, 20: 25, 27: 29}[nodes]]]
    np.testing.assert_allclose(seen, mesh.points[mesh.hexes], rtol=1e-6, atol=1e-6)
    assert blocks[0].keys() == ["box"]
    side_sets = blocks["Side Sets"]
    assert {name: side_sets[name].n_cells for name in list(side_sets.keys())} == {
        n: len(q) for n, q in mesh.boundaries.items()
    }
    if nodes == 8:
        for name, quads in mesh.boundaries.items():
            patch = side_sets[name]
            seen = patch.points[np.vstack([c.point_ids for c in patch.cell])]
            np.testing.assert_allclose(
                np.sort(seen.mean(axis=1), axis=0), np.sort(mesh.points[quads].mean(axis=1), axis=0), atol=1e-6
            )


def test_netcdf_library_reads_exodus(tmp_path):
    netCDF4 = pytest.importorskip("netCDF4")
    mesh = two_parts()
    io.write(mesh, tmp_path / "part.exo")
    with netCDF4.Dataset(tmp_path / "part.exo") as file:
        assert file.dimensions["num_elem"].size == mesh.n_hexes
        names = [b"".join(row.compressed()).decode() for row in file["ss_names"][:]]
        assert names == list(mesh.boundaries)
        assert file["connect1"].elem_type == "HEX8"
        # Side numbers of Exodus: 1-2-6-5, 2-3-7-6, 3-4-8-7, 1-5-8-4, 1-4-3-2, 5-6-7-8.
        corners = np.array([[1, 2, 6, 5], [2, 3, 7, 6], [3, 4, 8, 7], [1, 5, 8, 4], [1, 4, 3, 2], [5, 6, 7, 8]]) - 1
        blocks = [file[f"connect{j}"][:] - 1 for j in range(1, 1 + file.dimensions["num_el_blk"].size)]
        hexes = np.concatenate(blocks)
        for j, name in enumerate(names, 1):
            of, side = file[f"elem_ss{j}"][:] - 1, file[f"side_ss{j}"][:] - 1
            quads = hexes[of[:, None], corners[side]]
            assert as_sets(mesh.points, quads) == as_sets(mesh.points, mesh.boundaries[name])


@pytest.mark.parametrize("nodes", [8, 27])
def test_mfem_integrates_the_volume(tmp_path, nodes):
    mfem = pytest.importorskip("mfem.ser")
    mesh = bent_box(nodes)
    path = tmp_path / "part.mesh"
    io.write(mesh, path)
    read = mfem.Mesh(str(path))
    assert read.GetNE() == mesh.n_hexes
    assert read.CheckElementOrientation(False) == 0
    assert read.CheckBdrElementOrientation(False) == 0
    assert sum(read.GetElementVolume(j) for j in range(read.GetNE())) == pytest.approx(exact_volume(mesh), rel=1e-9)
    assert read.GetNBE() == sum(len(mesh.boundaries[name]) for name in NAMES if name != "walls")


def test_mfem_writes_what_we_read(tmp_path):
    mfem = pytest.importorskip("mfem.ser")
    mesh = two_parts()
    io.write(mesh, tmp_path / "part.mesh")
    mfem.Mesh(str(tmp_path / "part.mesh")).Print(str(tmp_path / "again.mesh"))
    back = io.read(tmp_path / "again.mesh")
    np.testing.assert_array_equal(back.hexes, mesh.hexes)
    assert set(back.parts) == set(mesh.parts)
    for name, ids in mesh.parts.items():
        np.testing.assert_array_equal(back.parts[name], ids)
    assert {name: len(q) for name, q in back.boundaries.items()} == {n: len(q) for n, q in mesh.boundaries.items()}


@pytest.mark.parametrize("suffix", [".msh", ".inp"])
def test_meshio_reads_hexes(tmp_path, suffix):
    meshio = pytest.importorskip("meshio")
    mesh = twisted_box()
    io.write(mesh, tmp_path / f"part{suffix}")
    read = meshio.read(tmp_path / f"part{suffix}")
    np.testing.assert_allclose(read.points, mesh.points, rtol=1e-12)
    np.testing.assert_array_equal(read.cells_dict["hexahedron"], mesh.hexes)


@pytest.mark.parametrize("nodes", [8, 27])
def test_scikit_fem_takes_groups_of_msh(tmp_path, nodes):
    skfem = pytest.importorskip("skfem")
    pytest.importorskip("meshio")
    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / "part.msh")
    read = skfem.Mesh.load(str(tmp_path / "part.msh"))
    assert read.nelements == mesh.n_hexes
    if nodes == 27:
        return  # its loader takes groups of quads of order 1 alone
    assert {"source", "target"} <= set(read.boundaries)
    assert len(read.boundaries["source"]) == len(mesh.boundaries["source"])


@pytest.mark.cad
@pytest.mark.parametrize("nodes", [8, 20, 27])
def test_node_order_of_med_equals_that_of_the_med_library(tmp_path, nodes):
    """One hex, written by gmsh through the MED library: its row of nodes is our table."""
    pytest.importorskip("gmsh")
    import h5py

    from cadsweep.gmsh_session import gmsh_session
    from cadsweep.io import med
    from cadsweep.io.msh_common import HEX_TYPES, hex_order

    mesh = bent_box(nodes)
    points = mesh.points[mesh.hexes[0]]
    with gmsh_session("test") as gmsh:
        entity = gmsh.model.addDiscreteEntity(3)
        gmsh.model.mesh.addNodes(3, entity, np.arange(1, nodes + 1), points.reshape(-1))
        gmsh.model.mesh.addElementsByType(entity, HEX_TYPES[nodes], [1], hex_order(nodes) + 1)
        gmsh.write(str(tmp_path / "one.med"))
    with h5py.File(tmp_path / "one.med") as file:
        step = next(iter(next(iter(file["ENS_MAA"].values())).values()))
        seen = step["NOE/COO"][:].reshape(3, -1).T
        row = step[f"MAI/{med.HEX_TYPES[nodes][0]}/NOD"][:] - 1
    np.testing.assert_array_equal(seen[row], points[med.HEX_ORDER[nodes]])


@pytest.mark.parametrize("nodes", [8, 20, 27])
def test_gmsh_files_are_read(tmp_path, nodes):
    """A mesh that gmsh made and wrote, in every version and kind that is read."""
    pytest.importorskip("gmsh")
    from cadsweep.gmsh_session import gmsh_session

    with gmsh_session("test") as gmsh:
        square = gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
        made = gmsh.model.occ.extrude([(2, square)], 0, 0, 3, numElements=[3], recombine=True)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.4)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.4)
        for curve in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(curve[1], 3)
        gmsh.model.mesh.setTransfiniteSurface(square)
        gmsh.model.mesh.setRecombine(2, square)
        gmsh.model.addPhysicalGroup(2, [square], name="floor")
        gmsh.model.addPhysicalGroup(3, [made[1][1]], name="body")
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", nodes == 20)
        gmsh.option.setNumber("Mesh.ElementOrder", 1 if nodes == 8 else 2)
        gmsh.model.mesh.generate(3)
        files = []
        for version in (4.1, 2.2):
            for binary in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                files.append(tmp_path / f"{version}_{binary}.msh")
                gmsh.write(str(files[-1]))
    for path in files:
        mesh = io.read(path)
        assert mesh.hexes.shape == (12, nodes)
        assert exact_volume(mesh) == pytest.approx(6)
        assert list(mesh.boundaries) == ["floor"]
        assert len(mesh.boundaries["floor"]) == 4
        assert list(mesh.parts) == ["body"]


@pytest.mark.parametrize("nodes", [8, 20, 27])
@pytest.mark.parametrize("compressor", ["none", "zlib", "lzma"])
@pytest.mark.parametrize("mode", ["ascii", "binary", "raw", "base64"])
def test_vtu_files_of_vtk_are_read(tmp_path, nodes, compressor, mode):
    """A grid that VTK wrote, in every way that is read; names come along in field data."""
    pv = pytest.importorskip("pyvista")
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / "first.vtu")
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(pv.read(tmp_path / "first.vtu"))
    writer.SetFileName(str(tmp_path / "part.vtu"))
    {
        "none": writer.SetCompressorTypeToNone,
        "zlib": writer.SetCompressorTypeToZLib,
        "lzma": writer.SetCompressorTypeToLZMA,
    }[compressor]()
    {"ascii": writer.SetDataModeToAscii, "binary": writer.SetDataModeToBinary}.get(mode, writer.SetDataModeToAppended)()
    if mode in {"raw", "base64"}:
        writer.SetEncodeAppendedData(mode == "base64")
    writer.Write()
    back = io.read(tmp_path / "part.vtu")
    np.testing.assert_allclose(back.points, mesh.points, atol=1e-5 if mode == "ascii" else 0)
    np.testing.assert_array_equal(back.hexes, mesh.hexes)
    assert list(back.boundaries) == list(mesh.boundaries)
    for name, quads in mesh.boundaries.items():
        np.testing.assert_array_equal(np.sort(back.boundaries[name], axis=0), np.sort(quads, axis=0))
    assert list(back.parts) == ["box"]


def test_side_tables_agree():
    """The nodes of a side lie on it: corners, middles and centre of a unit cube's sides."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    from cadsweep.io.sides import HEX_EDGES

    cube = np.concatenate([corners, corners[HEX_EDGES].mean(axis=1)])
    for side in SIDES:
        quad = cube[side[:4]]
        np.testing.assert_array_equal(cube[side[4:8]], (quad + np.roll(quad, -1, axis=0)) / 2)
        normal = np.cross(quad[1] - quad[0], quad[2] - quad[1])
        assert normal @ (quad.mean(axis=0) - 0.5) > 0
    assert sorted(SIDES[:, 8]) == list(range(20, 26))


@pytest.mark.parametrize("nodes", [8, 20, 27])
def test_the_med_library_lists_cells_and_groups(tmp_path, nodes):
    if shutil.which("mdump") is None:
        pytest.skip("mdump is missing: apt-get install libmed-tools")
    mesh = bent_box(nodes)
    io.write(mesh, tmp_path / "box.med")
    asked = {"input": "1\n1\n0\n", "capture_output": True, "text": True, "timeout": 60, "errors": "replace"}
    said = subprocess.run(["mdump", str(tmp_path / "box.med")], check=False, **asked).stdout
    quads = {8: 4, 20: 8, 27: 9}[nodes]
    n_quads = sum(len(q) for name, q in mesh.boundaries.items() if name != "walls")  # those of the sides once more
    assert f"MED_HEXA{nodes} : {mesh.n_hexes}" in said
    assert f"MED_QUAD{quads} : {n_quads}" in said
    assert set(re.findall(r"gro = (\w+)", said)) == {*mesh.boundaries, *mesh.parts}
