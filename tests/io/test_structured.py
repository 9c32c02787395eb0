"""Structured blocks: PLOT3D with its neutral map, and CGNS zones with i, j and k."""

from __future__ import annotations

import re

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep import io
from cadsweep.errors import InputError
from cadsweep.io.compare import same_quads
from cadsweep.io.grids import find_grids
from cadsweep.io.labels import label_mesh
from cadsweep.mesh import HexMesh

from .io_meshes import box, two_parts

vtk = pytest.importorskip("vtk")


def disc() -> cq.Workplane:
    return cq.Workplane().circle(10).extrude(8)


def closed_ring() -> cq.Workplane:
    return cq.Workplane().rect(2, 2).revolve(360, (8, 0, 0), (8, 1, 0))


def ell() -> cq.Workplane:
    return cq.Workplane().polyline([(0, 0), (6, 0), (6, 2), (2, 2), (2, 5), (0, 5)]).close().extrude(3)


def bored_shaft() -> cq.Workplane:
    turned = cq.Workplane().circle(10).extrude(12).faces(">Z").workplane().circle(6).extrude(12)
    return turned.cut(cq.Workplane("XZ").center(0, 6).circle(2.5).extrude(12, both=True))


def two_boxes() -> cq.Assembly:
    low = cq.Workplane().box(4, 4, 2)
    return cq.Assembly().add(low, name="low").add(cq.Workplane().box(2, 2, 2).translate((0, 0, 2)), name="high")


PARTS = {  # a sweep whose cap has a core; one ring; a concave edge; cells; solids that share nodes
    "disc": (disc, 3.0, 5),
    "ring": (closed_ring, 0.7, 1),
    "ell": (ell, 1.0, 2),
    "cells": (bored_shaft, 4.0, None),
    "solids": (two_boxes, 1.0, 2),
}


@pytest.fixture(scope="module", params=PARTS)
def mesh_and_count(request):
    make, size, count = PARTS[request.param]
    return cs.sweep_mesh(make(), size=size, allow_coarse=True), count


def test_blocks_are_right_handed_boxes_that_hold_every_hexahedron_once(mesh_and_count):
    mesh, count = mesh_and_count
    grids = find_grids(label_mesh(mesh))
    assert count is None or len(grids.shapes) == count
    assert len(grids.shapes) > 5 or count is not None  # the shaft: its core, a ring about it, and the bore's
    assert sorted(grids.order.tolist()) == list(range(mesh.n_hexes))
    np.testing.assert_array_equal(np.sort(grids.hexes), np.sort(mesh.hexes[grids.order]))
    for block, (ni, nj, nk) in enumerate(grids.shapes.tolist()):
        nodes = grids.nodes(block)
        assert nodes.shape == (nk + 1, nj + 1, ni + 1)
        places = mesh.points[nodes]
        steps = [np.diff(places, axis=axis)[:nk, :nj, :ni] for axis in (2, 1, 0)]
        assert (np.einsum("...c,...c", np.cross(steps[0], steps[1]), steps[2]) > 0).all()


def test_cgns_zones_give_the_mesh_back_to_the_bit(mesh_and_count, tmp_path):
    mesh, _ = mesh_and_count
    io.write(mesh, tmp_path / "a.cgns", structured=True)
    back = io.read(tmp_path / "a.cgns")
    np.testing.assert_array_equal(back.points, mesh.points)
    np.testing.assert_array_equal(back.hexes, mesh.hexes)
    for sent, got in ((mesh.boundaries, back.boundaries), (mesh.interfaces, back.interfaces)):
        assert set(sent) == set(got)
        assert all(same_quads(quads, got[name]) for name, quads in sent.items())
    for name, ids in mesh.parts.items():
        np.testing.assert_array_equal(np.sort(ids), back.parts[name])


@pytest.mark.parametrize("with_map", [True, False])
def test_plot3d_gives_cells_and_names_back(mesh_and_count, tmp_path, with_map):
    mesh, _ = mesh_and_count
    io.write(mesh, tmp_path / "a.xyz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.nmf", "a.xyz"]
    if not with_map:
        (tmp_path / "a.nmf").unlink()
    back = io.read(tmp_path / "a.xyz")
    assert back.n_nodes == mesh.n_nodes
    assert cells(back, back.hexes) == cells(mesh, mesh.hexes)
    assert back.quality().valid
    if with_map:
        assert set(back.boundaries) == set(mesh.boundaries)
        for name, quads in mesh.boundaries.items():
            assert cells(back, back.boundaries[name]) == cells(mesh, quads), name
        assert {name: len(ids) for name, ids in back.parts.items()} == {n: len(ids) for n, ids in mesh.parts.items()}


def cells(mesh: HexMesh, rows: np.ndarray) -> list:
    """Cells by the places of their nodes."""
    return sorted(sorted(map(tuple, own)) for own in mesh.points[rows].tolist())


def test_vtk_reads_the_blocks(mesh_and_count, tmp_path):
    mesh, _ = mesh_and_count
    n_blocks = len(find_grids(label_mesh(mesh)).shapes)
    io.write(mesh, tmp_path / "a.xyz")
    grid = vtk.vtkMultiBlockPLOT3DReader()
    grid.SetXYZFileName(str(tmp_path / "a.xyz"))
    grid.AutoDetectFormatOn()
    grid.Update()
    io.write(mesh, tmp_path / "a.cgns", structured=True)
    zones = vtk.vtkCGNSReader()
    zones.SetFileName(str(tmp_path / "a.cgns"))
    zones.UpdateInformation()
    zones.EnableAllBases()
    zones.Update()
    for blocks in (grid.GetOutput(), zones.GetOutput().GetBlock(0)):
        assert blocks.GetNumberOfBlocks() == n_blocks
        own = [blocks.GetBlock(j) for j in range(n_blocks)]
        assert sum(block.GetNumberOfCells() for block in own) == mesh.n_hexes
        sizer = vtk.vtkCellSizeFilter()
        total = 0.0
        for block in own:
            sizer.SetInputData(block)
            sizer.Update()
            volumes = sizer.GetOutput().GetCellData().GetArray("Volume")
            total += sum(volumes.GetValue(j) for j in range(volumes.GetNumberOfTuples()))
        assert total == pytest.approx(mesh.quality().volume, rel=1e-3)


def test_zones_of_other_programs_are_joined_where_they_meet(tmp_path):
    import h5py

    mesh = cs.sweep_mesh(disc(), size=3.0, allow_coarse=True)
    io.write(mesh, tmp_path / "a.cgns", structured=True)
    with h5py.File(tmp_path / "a.cgns", "r+") as file:
        for zone in file["Base"].values():
            if "UserData" in zone:
                del zone["UserData"]
    back = io.read(tmp_path / "a.cgns")
    assert back.n_nodes == mesh.n_nodes
    assert cells(back, back.hexes) == cells(mesh, mesh.hexes)
    assert {name: cells(back, quads) for name, quads in back.boundaries.items()} == {
        name: cells(mesh, quads) for name, quads in mesh.boundaries.items()
    }


def test_named_quads_over_parts_of_sides_are_kept(tmp_path):
    """``corner`` covers three quads of two sides, four parts stand in rows by turns, ``interface`` lies inside."""
    mesh = two_parts()
    io.write(mesh, tmp_path / "a.cgns", structured=True)
    back = io.read(tmp_path / "a.cgns")
    for name, quads in mesh.boundaries.items():
        assert same_quads(quads, back.boundaries[name]), name
    assert set(back.parts) == {"left_only", "left_and_odd_layers", "right_only", "right_and_odd_layers"}


def test_what_is_not_mapped_is_refused_with_the_cap_and_nothing_is_written(tmp_path):
    outline = [(0, 0), (9, 1), (12, 6), (7, 11), (1, 8), (-2, 4)]
    part = cq.Workplane().polyline(outline).close().extrude(3).faces(">Z").workplane().center(5, 5).hole(2.3)
    mesh = cs.sweep_mesh(part, size=0.5)
    for name, options in (("a.xyz", {}), ("a.cgns", {"structured": True})):
        with pytest.raises(InputError, match=r"'part' is not mapped.* structured blocks, more than 64.*'source'") as no:
            io.write(mesh, tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []
    advised = re.search(r"take max_blocks=(\d+)$", str(no.value))
    io.write(mesh, tmp_path / "a.xyz", max_blocks=int(advised[1]))
    assert io.read(tmp_path / "a.xyz").n_hexes == mesh.n_hexes
    with pytest.raises(InputError, match="order=1"):
        io.write(cs.sweep_mesh(ell(), size=2.0, order=2, allow_coarse=True), tmp_path / "a.cgns", structured=True)


def test_a_map_of_another_grid_is_noticed(tmp_path):
    io.write(box(), tmp_path / "a.xyz")
    io.write(box(nx=4), tmp_path / "b.xyz")
    (tmp_path / "b.nmf").replace(tmp_path / "a.nmf")
    with pytest.raises(InputError, match=r"neutral map \(\.nmf\) are not those"):
        io.read(tmp_path / "a.xyz")
