"""Options two and three at a time, on every kind of part: each mesh is judged by its arrays alone.

What an option does by itself is tested where the option is; here, that it does so beside others, whatever the mesh is
made of. A kind of part or a set of options is one more entry.
"""

from functools import cache

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs

TETRAHEDRA = (
    (0, 1, 3, 4),
    (1, 2, 0, 5),
    (2, 3, 1, 6),
    (3, 0, 2, 7),
    (4, 7, 5, 0),
    (5, 4, 6, 1),
    (6, 5, 7, 2),
    (7, 6, 4, 3),
)
"""Of a hexahedron, at each of its corners: positive where its Jacobian is there."""
FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
WALL, FIRST = "<Y", 0.2


def plate(s):
    return cq.Workplane().box(40, 30, 10).faces(">Z").workplane().center(3 * s, 0).hole(10)


def stepped(s):
    boss = cq.Workplane().box(40, 30, 10).faces(">Z").workplane().center(8 * s, 5).circle(5).extrude(6)
    return boss.faces(">Z[-2]").workplane(centerOption="CenterOfBoundBox").center(-10, -6).rect(8, 8).cutBlind(-4 * s)


def bored(s):
    block = cq.Workplane().box(40, 30, 20).faces(">Z").workplane().center(-10 * s, 0).hole(8)
    return block.faces(">X").workplane(centerOption="CenterOfMass").hole(6, 12)


def pinned(s):
    pin = cq.Workplane().center(5 * s, 0).circle(4).extrude(6).translate((0, 0, -3))
    return cq.Assembly().add(cq.Workplane().box(40, 30, 6).cut(pin), name="base").add(pin, name="pin")


def mixed(s):
    return cq.Assembly().add(bored(s), name="block").add(stepped(s).translate((0, 0, 15)), name="lid")


KINDS = {"one sweep": plate, "columns": stepped, "cells": bored, "assembly": pinned}
SIZE = 4.0


@cache
def model(kind, s=1.0):
    return KINDS[kind](s)


def solids(shape):
    return shape.toCompound().Solids() if isinstance(shape, cq.Assembly) else shape.solids().vals()


def check(mesh, shape):
    """All hexahedra upright, every quad of one or two, the skin closed, and as much inside as the model has."""
    points, hexes = mesh.points, mesh.hexes[:, :8]
    a, b, c, d = (points[hexes[:, list(ids)]] for ids in np.array(TETRAHEDRA).T)
    assert (np.einsum("nci,nci->nc", np.cross(b - a, c - a), d - a) > 0).all()
    quads = np.concatenate([hexes[:, face] for face in FACES])
    _, first, shared = np.unique(np.sort(quads, axis=1), axis=0, return_index=True, return_counts=True)
    assert shared.max() == 2
    skin = quads[first[shared == 1]]
    pairs = np.concatenate([skin[:, [i, (i + 1) % 4]] for i in range(4)])
    assert (np.unique(np.sort(pairs, axis=1), axis=0, return_counts=True)[1] % 2 == 0).all()
    assert len(np.unique(hexes)) == len(np.unique(mesh.points[np.unique(hexes)].round(7), axis=0))
    v = points[skin]
    inside = (np.einsum("ni,ni->n", np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]), v.mean(axis=1)) / 6).sum()
    assert inside == pytest.approx(sum(solid.Volume() for solid in solids(shape)), rel=0.03)


def first_height(mesh):
    """Median length of the edges that leave the wall."""
    on = np.abs(mesh.points[:, 1] + 15) < 1e-6
    edges = np.concatenate([mesh.hexes[:, [i, j]] for f in FACES for i, j in zip(f, np.roll(f, -1), strict=True)])
    leaving = edges[on[edges[:, 0]] & ~on[edges[:, 1]]]
    return np.median(np.linalg.norm(np.diff(mesh.points[leaving], axis=1)[:, 0], axis=1))


@pytest.mark.parametrize("kind", KINDS)
def test_walls_carried_to_another_part_and_raised_to_order_2(kind):
    layers = cs.WallLayers(first=FIRST, growth=1.3, n=3)
    base = cs.sweep_mesh(model(kind), size=SIZE, wall_layers={WALL: layers})
    check(base, model(kind))
    assert first_height(base) == pytest.approx(FIRST, rel=0.05)
    other = cs.sweep_mesh(model(kind, 1.05), like=base, order=2)
    assert other.hexes.shape[1] == 20
    assert (other.hexes[:, :8] == base.hexes).all()
    assert np.abs(other.points[: base.n_nodes] - base.points).max() > 0.01
    check(other, model(kind, 1.05))


@pytest.mark.parametrize("kind", KINDS)
def test_a_bias_on_matched_faces_refined(kind):
    edge = "edges:|X and <Y and <Z"
    base = cs.sweep_mesh(model(kind), size=SIZE, periodic={"<Y": ">Y"}, biases={edge: {"towards": "both", "ratio": 4}})
    check(base, model(kind))
    on = base.points[np.isclose(base.points[:, 1], -15) & np.isclose(base.points[:, 2], base.points[:, 2].min())]
    steps = np.diff(np.sort(on[:, 0]))
    assert steps.max() / steps.min() == pytest.approx(4, rel=0.1)
    fine = cs.refine(base)
    assert fine.n_hexes == 8 * base.n_hexes
    check(fine, model(kind))
    for mesh in (base, fine):
        (pairs,) = mesh.periodic.values()
        ways = mesh.points[pairs[:, 1]] - mesh.points[pairs[:, 0]]
        assert np.allclose(ways, (0, 30, 0), atol=1e-6)
        assert len(pairs) == np.isclose(mesh.points[:, 1], -15).sum()


def test_a_tolerance_on_cells_and_columns_that_touch():
    """Cuts of the block end at an edge of the lid, whose pieces need unlike sizes; the edge above follows them."""
    shape = mixed(1.0)
    mesh = cs.sweep_mesh(shape, size=3.6, tolerance=0.02)
    check(mesh, shape)
    assert mesh.quality().min_scaled_jacobian > 0.3


def test_blocks_under_a_lid_go_along_though_cuts_have_replaced_a_seam():
    """Cuts take the two halves of a bore as one face, and no nodes follow the edges between these."""
    base = cs.sweep_mesh(mixed(1.0), size=SIZE)
    other = cs.sweep_mesh(mixed(1.1), like=base)
    assert np.array_equal(other.hexes, base.hexes)
    assert np.abs(other.points - base.points).max() > 0.5
    check(other, mixed(1.1))
    again = cs.sweep_mesh(mixed(1.0), like=other)
    assert np.abs(again.points - base.points).max() < 0.25 * SIZE
