"""Sides, edges and rows that are one are found as sorting all of them finds them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cadsweep.arrays import IntArray
from cadsweep.cells import HEX_EDGES, HEX_FACES
from cadsweep.errors import CadSweepError, InputError
from cadsweep.io.compare import check_same
from cadsweep.io.grids import find_grids
from cadsweep.io.labels import label_mesh
from cadsweep.io.pairing import edge_codes, first_rows, neighbours

from .io_meshes import twisted_box


def turned(hexes: IntArray, seed: int) -> IntArray:
    """Hexahedra in another order, each turned about axes of a cube."""
    chance = np.random.default_rng(seed)
    hexes = hexes[chance.permutation(len(hexes))]
    for turn in 6 * [[1, 2, 3, 0, 5, 6, 7, 4], [4, 5, 1, 0, 7, 6, 2, 3]]:
        some = chance.random(len(hexes)) < 0.5
        hexes[some] = hexes[some][:, turn]
    return hexes


def test_what_is_beyond_a_side_has_its_corners_and_is_found_from_there_too():
    mesh = twisted_box(nx=4, ny=3, nz=5)
    hexes = turned(mesh.hexes, 1)
    across = neighbours(hexes, mesh.n_nodes)
    corners = np.sort(hexes[:, HEX_FACES].reshape(-1, 4), axis=1)
    inner = np.flatnonzero(across >= 0)
    assert len(across) - len(inner) == 2 * (4 * 3 + 4 * 5 + 3 * 5)
    assert (corners[across[inner]] == corners[inner]).all()
    assert (across[across[inner]] == inner).all()
    assert (across[inner] // 6 != inner // 6).all()


def test_three_hexahedra_on_one_side_are_refused():
    mesh = twisted_box(nx=1, ny=1, nz=2)
    with pytest.raises(InputError, match="three hexahedra"):
        neighbours(np.concatenate([mesh.hexes, mesh.hexes[:1]]), mesh.n_nodes)


def test_edges_have_one_code_where_they_have_the_same_ends():
    mesh = twisted_box(nx=3, ny=2, nz=2)
    hexes = turned(mesh.hexes, 2)
    codes, counts = edge_codes(hexes, mesh.n_nodes)
    ends = np.sort(hexes[:, HEX_EDGES].reshape(-1, 2), axis=1)
    _, number, many = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    assert len(counts) == len(many)
    assert (counts[codes.ravel()] == many[number.ravel()]).all()
    assert len(set(zip(codes.ravel().tolist(), number.ravel().tolist(), strict=True))) == len(many)


def test_equal_rows_are_named_by_the_first_of_them():
    rows = np.random.default_rng(3).integers(0, 4, (500, 3))
    first = first_rows(rows)
    assert first.tolist() == [next(j for j in range(500) if (rows[j] == row).all()) for row in rows]


def test_a_grid_knows_what_is_beyond_its_turned_hexahedra():
    mesh = twisted_box(nx=4, ny=3, nz=5)
    grids = find_grids(label_mesh(replace(mesh, hexes=turned(mesh.hexes, 4), parts={})))
    assert sorted(grids.shapes[0].tolist()) == [3, 4, 5]
    assert (grids.across == neighbours(grids.hexes, mesh.n_nodes)).all()


def test_a_hexahedron_may_come_back_turned_and_not_mirrored():
    mesh = twisted_box(nx=3, ny=2, nz=2)
    sent = label_mesh(replace(mesh, boundaries={}, parts={}))
    chance = np.random.default_rng(5)
    back = replace(mesh, boundaries={}, parts={})
    for turn in ([1, 2, 3, 0, 5, 6, 7, 4], [4, 5, 1, 0, 7, 6, 2, 3]):
        hexes = np.where(chance.random(mesh.n_hexes)[:, None] < 0.5, back.hexes[:, turn], back.hexes)
        back = replace(back, hexes=hexes)
        check_same(sent, back, ({}, {}), turned=True)
    mirrored = replace(back, hexes=back.hexes[:, [1, 0, 3, 2, 5, 4, 7, 6]])
    exchanged = replace(back, hexes=back.hexes[:, [1, 0, 2, 3, 4, 5, 6, 7]])
    for other in (mirrored, exchanged):
        with pytest.raises(CadSweepError, match="other hexes"):
            check_same(sent, other, ({}, {}), turned=True)
