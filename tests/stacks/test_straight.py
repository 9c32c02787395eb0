"""Stacks with flat caps as products: the same mesh as by heights of every node, in memory, in slabs and on ranks."""

import cadquery as cq
import numpy as np
import pytest
import scipy

import cadsweep as cs
from cadsweep import stacks
from cadsweep.blocks import slabs
from cadsweep.blocks.slabs import SweptBlock
from cadsweep.blocks.stream import measure
from cadsweep.pipeline.columns import stacking
from cadsweep.pipeline.meshing import make_options
from cadsweep.pipeline.routes import mesh_in_blocks
from cadsweep.pipeline.run import make_run
from cadsweep.quality import check

from ..pipeline.pipeline_ranks import distributed, same


def pockets() -> cq.Workplane:
    """Two pockets that are not of one depth and share a level, a boss, and a hole from below that ends in the block."""
    part = cq.Workplane().box(40, 30, 10, centered=(True, True, False))
    part = part.cut(cq.Workplane("XY", (-10, 0, 6)).rect(10, 12).extrude(10))
    part = part.cut(cq.Workplane("XY", (10, 0, 5.5)).circle(5).extrude(10))
    part = part.cut(cq.Workplane("XY", (-10, 0, 0)).circle(2).extrude(3))
    return part.union(cq.Workplane("XY", (0, 10, 9)).circle(2).extrude(3.6))


@pytest.fixture(scope="module")
def part():
    return cs.load(pockets())


@pytest.fixture(scope="module")
def mesh(part):
    return cs.sweep_mesh(part, size=2.0)


def test_products_are_the_mesh_that_is_placed_node_by_node(part, mesh, monkeypatch):
    kinds = []
    build = stacks.build_straight
    monkeypatch.setattr(stacks, "build_straight", lambda *given: kinds.append(build(*given)))  # and none to go on with
    general = cs.sweep_mesh(part, size=2.0)
    modes = [column.modes.shape[1] for column in kinds[0].columns]
    assert max(modes) > 0, "levels of the two pockets differ in height"
    assert min(modes) == 0
    far, at = scipy.spatial.cKDTree(general.points).query(mesh.points)
    assert far.max() <= 1e-12 * 40
    assert len(np.unique(at)) == general.n_nodes == mesh.n_nodes
    assert {frozenset(at[row].tolist()) for row in mesh.hexes} == {frozenset(row.tolist()) for row in general.hexes}
    assert mesh.boundaries.keys() == general.boundaries.keys()
    for name, quads in mesh.boundaries.items():
        rows = {frozenset(row.tolist()) for row in general.boundaries[name]}
        assert {frozenset(at[row].tolist()) for row in quads} == rows


def test_slabs_and_ranks_are_the_mesh_in_memory_bit_for_bit(part, mesh, monkeypatch, tmp_path):
    monkeypatch.setattr(slabs, "SLAB_NODES", 100)
    figures = cs.stream_mesh(part, tmp_path / "stream.vtkhdf", size=2.0)
    assert same(cs.read(tmp_path / "stream.vtkhdf"), mesh)
    assert figures["min_scaled_jacobian"] == mesh.info["quality"].min_scaled_jacobian
    assert figures["sweeps"] == mesh.info["sweeps"]
    distributed(part, tmp_path / "ranks.vtkhdf", n_ranks=3, size=2.0)
    assert same(cs.read(tmp_path / "ranks.vtkhdf"), mesh)


def test_a_stack_in_blocks_keeps_no_node_inside_of_its_columns(part, mesh):
    seen = []

    def measured(blocks):
        seen.append(blocks)
        return measure(blocks, [(block, 0, block.n_layers) for block in blocks.blocks])

    blocks = mesh_in_blocks(part, make_options({"size": 2.0}), make_run(None, None, measure=measured))
    assert all(isinstance(block, SweptBlock) for block in blocks.blocks)
    assert len(blocks.blocks) == mesh.info["sweeps"][0]["columns"]
    inside = sum(block.n_own for block in blocks.blocks)
    assert len(blocks.kept_nodes) + inside == blocks.n_nodes == mesh.n_nodes
    # Of a column of q quads and n layers the rim and two caps are kept, whatever n is.
    assert inside == sum((block.n_layers - 1) * len(block.inside) for block in blocks.blocks) > 0


def test_a_poor_straight_stack_is_smoothed_alike(tmp_path):
    below = cq.Workplane().rect(13, 7).extrude(2).rotate((0, 0, 0), (0, 0, 1), 17)
    block = cq.Workplane().box(20, 20, 6, centered=(True, True, False))
    part = cs.load(block.cut(below).cut(cq.Workplane("XY", (0, 0, 4)).rect(12, 8).extrude(5)))
    mesh = cs.sweep_mesh(part, size=2.0, decompose=False)
    assert any("worst scaled Jacobian" in note for note in mesh.info["notes"])
    figures = cs.stream_mesh(part, tmp_path / "stream.vtkhdf", size=2.0, decompose=False)
    assert same(cs.read(tmp_path / "stream.vtkhdf"), mesh)
    assert figures["notes"] == mesh.info["notes"]


def test_slanted_caps_are_no_straight_stack(monkeypatch):
    made = []
    build = stacks.build_straight
    monkeypatch.setattr(stacking.stacks, "build_straight", lambda *given: made.append(build(*given)) or made[-1])
    wedge = cq.Workplane("XZ").polyline([(0, 0), (6, 0), (6, 3), (0, 2)]).close().extrude(4)
    part = wedge.cut(cq.Workplane("XY", (3, -2, 1)).rect(2, 2).extrude(5))
    mesh = cs.sweep_mesh(part, size=1.0)
    assert mesh.quality().valid
    assert made[-1] is None


def test_only_faces_between_columns_are_matched(part, monkeypatch):
    def match(*_):
        raise AssertionError("all faces were matched")

    monkeypatch.setattr(check, "_general_problems", match)
    assert cs.sweep_mesh(part, size=2.0).info["quality"].valid


def test_columns_stand_straight_under_any_functional(part):
    plain, asked = (cs.sweep_mesh(part, size=2.0, **own) for own in ({}, {"functional": "F", "residual": False}))
    assert np.array_equal(asked.points, plain.points)
    assert any(note.startswith("functional and residual of no effect") for note in asked.info["notes"])


@pytest.mark.parametrize("option", [{"bias": 2.0}, {"fractions": [0.0, 0.5, 1.0]}])
def test_what_columns_have_no_use_for_is_refused(part, option):
    (name,) = option
    with pytest.raises(cs.InputError, match=f"^{name} goes with a plain sweep, and this part is a stack of columns"):
        cs.sweep_mesh(part, size=2.0, **option)
