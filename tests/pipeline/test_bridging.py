"""Parts with tips mesh well: within the distance that `bridge` allows, under the names that they have."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep import cad, rows
from cadsweep.errors import InputError
from cadsweep.options import SweepOptions
from cadsweep.pipeline import write_factors
from cadsweep.pipeline.complexes.complexes import COLUMNS, plan_again, plan_cells
from cadsweep.pipeline.run import Run
from cadsweep.pipeline.tips import TIPS, bridged
from cadsweep.progress import silent
from cadsweep.recognition import ALIKE
from tests.parts.chamfered import chamfered_bolt, chamfered_nut
from tests.parts.joints import bolted, plate

SIZE = 0.8


@pytest.fixture(scope="module", params=[4, 6])
def nut(request):
    part = cs.load(chamfered_nut(request.param))
    return part, cs.sweep_mesh(part, size=SIZE)


def test_no_quad_is_as_flat_as_the_tip(nut):
    _, mesh = nut
    assert mesh.info["quality"].valid
    assert mesh.info["quality"].min_scaled_jacobian > 0.4
    assert TIPS in mesh.info["rows"]
    assert any(note.startswith("tips bridged") for note in mesh.info["notes"])


def test_edges_keep_the_numbers_that_they_had_with_their_tips(nut):
    part, _ = nut
    old, ended = part.solids[0], cad.bridge_tips(part, 0.05)
    for edge in old.edges:
        for found in cad.select_edges(ended, f"edge {edge.id}"):
            middle = ended.solids[0].edges[found].midpoint
            assert edge.curve.distance(middle[None])[0] == pytest.approx(0.0, abs=1e-9 * old.size)


def test_the_volume_is_the_models(nut):
    part, mesh = nut
    assert mesh.info["quality"].volume == pytest.approx(part.solids[0].volume * part.scale**3, rel=5e-3)


def test_every_node_of_a_boundary_is_within_the_bridge_of_its_face(nut):
    part, mesh = nut
    surfaces = [face.surface for face in part.solids[0].faces]
    off = []
    for quads in mesh.boundaries.values():
        points = (mesh.points[np.unique(quads)] - part.offset) / part.scale
        off.append(min(float(np.max(surface.distance(points))) for surface in surfaces))
    assert len(off) == len(surfaces) - 1  # the two halves of the bore have one name
    assert max(off) * part.scale <= 0.05 * SIZE


def test_without_a_bridge_the_mesh_is_on_the_model_and_as_flat_as_the_tip():
    mesh = cs.sweep_mesh(chamfered_nut(6), size=SIZE, bridge=0, decompose=False)
    assert mesh.info["quality"].min_scaled_jacobian < 0.1
    assert TIPS not in mesh.info["rows"]


@pytest.mark.parametrize("options", [{"order": 2}, {"refine": 1}])
def test_what_is_done_to_a_mesh_is_done_to_a_bridged_one(options):
    mesh = cs.sweep_mesh(chamfered_nut(6), size=1.2, **options)
    assert mesh.info["quality"].valid
    assert mesh.info["quality"].min_scaled_jacobian > 0.2


def test_a_bridged_mesh_is_carried_to_another_part(tmp_path):
    mesh = write_factors(chamfered_nut(6), tmp_path / "nut.sweep.npz", size=SIZE)
    for like in (mesh, tmp_path / "nut.sweep.npz"):
        other = cs.sweep_mesh(chamfered_nut(6, height=8.0), like=like)
        assert other.info["quality"].valid
        np.testing.assert_array_equal(other.hexes, mesh.hexes)
        assert np.ptp(other.points[:, 2]) == pytest.approx(8.0)


def test_cuts_go_through_bridged_tips():
    mesh = cs.sweep_mesh(chamfered_bolt(), size=1.5)
    assert mesh.record.way == "cells"
    assert TIPS in mesh.info["rows"]
    assert mesh.info["quality"].min_scaled_jacobian > 0.35


def test_a_bolted_joint_shares_its_nodes_and_has_no_flat_quads():
    mesh = cs.sweep_mesh(bolted())
    assert {TIPS, ALIKE} <= set(mesh.info["rows"])
    assert set(mesh.parts) == {"plate", "nut", "bolt"}
    assert mesh.info["quality"].valid
    assert mesh.info["quality"].min_scaled_jacobian > 0.3
    nodes = {name: np.unique(mesh.hexes[cells]) for name, cells in mesh.parts.items()}
    for one, other in (("plate", "nut"), ("plate", "bolt"), ("nut", "bolt")):
        assert len(np.intersect1d(nodes[one], nodes[other])) > 50


def test_cells_can_be_bridged_after_solids_were_cut():
    part = cs.load(cq.Assembly().add(chamfered_bolt(), name="bolt").add(plate(), name="plate"))
    options = SweepOptions()
    with rows.without([COLUMNS]):
        found = plan_cells(part, Run(on_progress=silent))
    again = plan_again(found, bridged(found.part, options), bridged(part, options))
    assert len(again.part.solids) == len(found.part.solids) > 2
    assert again.part.cuts == found.part.cuts
    assert again.part.owners == found.part.owners
    assert sorted(again.plan.order) == list(range(len(again.part.solids)))
    assert any(cad.has_sharp_corners(solid) for solid in found.part.solids)
    assert not any(cad.has_sharp_corners(solid) for solid in again.part.solids)


def test_a_bridge_is_no_longer_than_the_tolerance():
    mesh = cs.sweep_mesh(chamfered_nut(6), tolerance=0.01, decompose=False)
    assert mesh.info["distance"] <= 0.01
    (note,) = [note for note in mesh.info["notes"] if note.startswith("tips bridged")]
    assert "edges of 0.01," in note


@pytest.mark.parametrize("bridge", [-1.0, np.inf, np.nan, "wide"])
def test_a_bridge_is_a_length_or_nothing(bridge):
    with pytest.raises(InputError, match="bridge"):
        cs.sweep_mesh(chamfered_nut(6), bridge=bridge)
