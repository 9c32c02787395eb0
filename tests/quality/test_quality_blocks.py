"""Conformity of a mesh that is known to be blocks: what its blocks say is what all of its faces say."""

from dataclasses import replace

import numpy as np
import pytest

from cadsweep.cells import BlockStructure, fill_hexes, sweep_hexes
from cadsweep.mesh import HexMesh
from cadsweep.quality import check_mesh
from cadsweep.quality.block_faces import match_blocks
from cadsweep.quality.conformity import face_nodes, match_faces
from cadsweep.quality.several import lie_in_parts, part_surfaces

from .quality_meshes import grid_quads

BOXES = [(0, 3, 0, 4, 0, 5), (3, 7, 0, 4, 0, 2), (3, 7, 0, 4, 2, 5), (7, 8, 0, 4, 0, 3)]
"""Columns of a lattice of unit cubes: from x to x, y to y, layer to layer. The last is one quad wide."""


def blocks_of(boxes, lone=()):
    """Points, hexes and blocks of boxes, and of lone cubes (x, y, z) between the nodes of a lattice."""
    size = np.array([10, 6, 8])
    lattice = np.stack(np.meshgrid(*map(np.arange, size), indexing="ij"), axis=-1).reshape(-1, 3)

    def place(x, y, z):
        return (np.asarray(x) * size[1] + y) * size[2] + z

    layered, own = [], []
    for x0, x1, y0, y1, z0, z1 in boxes:
        plane, quads, loops = grid_quads(x1 - x0, y1 - y0)
        at = place(*(plane + [x0, y0]).astype(int).T, np.arange(z0, z1 + 1)[:, None])
        inside = np.setdiff1d(np.arange(len(plane)), np.concatenate(loops))
        layered.append((at, quads, loops))
        own.append(at[1:-1, inside].reshape(-1))
    cubes = [place(x + c[:, 0], y + c[:, 1], z + c[:, 2]) for x, y, z in lone for c in [CUBE]]
    every = np.concatenate([at.reshape(-1) for at, _, _ in layered] + cubes)
    borrowed = np.setdiff1d(every, np.concatenate(own))
    order = np.concatenate([borrowed, *own])
    number = np.full(len(lattice), -1)
    number[order] = np.arange(len(order))
    first_node, first_hex, blocks, hexes = len(borrowed), 0, [], []
    for (at, quads, loops), inner in zip(layered, own, strict=True):
        nodes = number[at]
        blocks.append(
            BlockStructure(
                quads=quads, loops=loops, n_nodes=at.shape[1], bottom=nodes[0], top=nodes[-1],
                rings=nodes[:, np.concatenate(loops)], first_node=first_node, first_hex=first_hex,
            )
        )  # fmt: skip
        assert np.array_equal(blocks[-1].layers(np.arange(len(nodes))), nodes)
        hexes.append(nodes.reshape(-1)[sweep_hexes(quads, at.shape[1], len(at) - 1)])
        first_node += len(inner)
        first_hex += len(hexes[-1])
    return lattice[order].astype(float), np.concatenate([*hexes, *(number[cube][None] for cube in cubes)]), blocks


CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


def mesh_of(points, hexes):
    return HexMesh(points=points, hexes=hexes, boundaries={})


@pytest.mark.parametrize("lone", [(), ((8, 1, 1), (8, 2, 1))])
def test_blocks_have_the_boundary_that_all_faces_have(lone):
    points, hexes, blocks = blocks_of(BOXES, lone)
    found = match_blocks(hexes, len(points), blocks).once
    # The outside of the pieces, less both sides of what they share, of unit area each.
    boxes = [(x1 - x0, y1 - y0, z1 - z0) for x0, x1, y0, y1, z0, z1 in BOXES] + [(1, 1, 1)] * len(lone)
    outside = sum(2 * (a * b + b * c + c * a) for a, b, c in boxes)
    shared = 4 * 5 + 4 * 4 + 4 * 3 + (len(lone) + 1 if lone else 0)
    assert len(found) == outside - 2 * shared
    every = check_mesh(mesh_of(points, hexes))
    told = check_mesh(mesh_of(points, hexes), blocks=blocks)
    assert told.valid
    assert every.valid
    assert (told.euler, told.volume) == (every.euler, every.volume)


def swapped(points, hexes, blocks):
    """A hexahedron of the block has two nodes the other way round."""
    hexes[30, [0, 1]] = hexes[30, [1, 0]]
    return points, hexes, blocks


def torn(points, hexes, blocks):
    """A block has a copy of a node that others share: its hexahedra follow its structure, and a crack is there."""
    node = int(blocks[1].rings[1, 0])
    assert node in blocks[0].rings
    new = len(points)
    rings = np.where(blocks[1].rings == node, new, blocks[1].rings)
    last = blocks[1].first_hex + blocks[1].n_hexes
    hexes[blocks[1].first_hex : last][hexes[blocks[1].first_hex : last] == node] = new
    blocks[1] = replace(blocks[1], rings=rings)
    return np.concatenate([points, points[[node]]]), hexes, blocks


def stray(points, hexes, blocks):
    return np.concatenate([points, [[50.0, 0, 0]]]), hexes, blocks


def claimed(points, hexes, blocks):
    """Two blocks say that the same nodes are inside of them."""
    blocks[0] = replace(blocks[0], first_node=blocks[2].first_node)
    return points, hexes, blocks


def inside_out(points, hexes, blocks):
    """A hexahedron that is in no block has a node that is inside of one."""
    return points, np.concatenate([hexes, hexes[[0]]]), blocks


def twice(points, hexes, blocks):
    """A block comes again, all of its nodes borrowed."""
    thin = blocks[3]
    again = hexes[thin.first_hex : thin.first_hex + thin.n_hexes]
    return points, np.concatenate([hexes, again]), [*blocks, replace(thin, first_hex=len(hexes))]


FAULTS = [swapped, torn, stray, claimed, inside_out, twice]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_every_fault_is_told_as_without_blocks(fault):
    points, hexes, blocks = fault(*blocks_of(BOXES))
    mesh = mesh_of(points, hexes)
    told = check_mesh(mesh, blocks=blocks)
    assert told.problems == check_mesh(mesh).problems
    assert told.valid == (fault is claimed), "only there the mesh itself is sound"


def in_parts(split):
    """Blocks of which some are one part, and a split of the hexahedra into two parts where that is given."""
    points, hexes, blocks = blocks_of(BOXES, ((8, 1, 1),))
    last = blocks[2].first_hex if split is None else split
    parts = {"one": np.arange(last), "other": np.arange(last, len(hexes))}
    use = match_faces(hexes, len(points))
    apart = (use.first // 6 < last) != (use.partner // 6 < last)
    between = {"one__other": face_nodes(hexes, use.first[apart])}
    return HexMesh(points=points, hexes=hexes, boundaries={}, parts=parts, interfaces=between), blocks


@pytest.mark.parametrize("split", [None, 7], ids=["parts of whole blocks", "a block in two parts"])
def test_surfaces_of_parts_and_contacts_are_those_that_each_part_has_alone(split):
    mesh, blocks = in_parts(split)
    for surface in part_surfaces(mesh):
        own = mesh.hexes[mesh.parts[surface.name]]
        assert np.array_equal(surface.quads, face_nodes(own, match_faces(own, mesh.n_nodes).once))
        assert surface.volume == pytest.approx(len(own))
        assert len(surface.named["one__other"]) == len(mesh.interfaces["one__other"])
    assert check_mesh(mesh, blocks=blocks).valid
    lost = replace(mesh, interfaces={"one__other": mesh.interfaces["one__other"][1:]})
    for told in ((), blocks):
        problems = check_mesh(lost, blocks=told).problems
        assert any("1 quads between parts are in no interface" in problem for problem in problems)


def test_blocks_and_all_faces_give_the_same_surfaces():
    mesh, blocks = in_parts(None)
    assert lie_in_parts(mesh, blocks)
    assert not lie_in_parts(*in_parts(7))
    by_blocks = part_surfaces(mesh, match_blocks(mesh.hexes, mesh.n_nodes, blocks))
    for own, other in zip(by_blocks, part_surfaces(mesh), strict=True):
        assert np.array_equal(own.quads, other.quads)


def test_a_third_hexahedron_on_a_face_is_on_the_surface_of_its_own_part():
    mesh, _ = in_parts(None)
    again = np.concatenate([mesh.hexes, mesh.hexes[:1]])
    third = replace(mesh, hexes=again, parts={**mesh.parts, "third": np.array([mesh.n_hexes])}, interfaces={})
    assert [len(own.quads) for own in part_surfaces(third)][-1] == 6


def test_a_cube_on_a_face_between_layers_of_a_thin_block_is_found():
    # All four nodes of that face are the block's ring: nothing but the matching of shared faces sees a third user.
    points, hexes, blocks = blocks_of(BOXES)
    thin = hexes[blocks[3].first_hex]
    upper = len(points) + np.arange(4)
    points = np.concatenate([points, points[thin[4:]] + [0.2, 0.3, 0.4]])
    hexes = np.concatenate([hexes, [np.concatenate([thin[4:], upper])]])
    assert match_blocks(hexes, len(points), blocks) is None
    problems = check_mesh(mesh_of(points, hexes), blocks=blocks).problems
    assert any("more than two hexahedra" in problem for problem in problems)


def test_hexes_are_written_in_place():
    plane, quads, _ = grid_quads(3, 2)
    nodes = np.random.default_rng(0).permutation(5 * len(plane)).reshape(5, -1)
    hexes = np.empty((4 * len(quads), 8), dtype=np.int64)
    fill_hexes(nodes, quads, hexes)
    assert np.array_equal(hexes, nodes.reshape(-1)[sweep_hexes(quads, len(plane), 4)])
