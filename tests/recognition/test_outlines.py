"""Outlines of both caps divided alike: where they nearly coincide, and so that each vertex has one to answer it."""

import math

import numpy as np
import pytest

import cadsweep as cs
from cadsweep import cad, recognition
from tests.parts.joints import THICK, between


def within(solid, height):
    """Edges inside a cap."""
    cap = {face.id for face in solid.faces if face.kind == "plane" and abs(face.center[2] - height) < 1e-6}
    return [edge for edge in solid.edges if cap.issuperset(edge.faces)]


@pytest.mark.parametrize(("n_sides", "turn"), [(6, 0.0), (6, 13.0), (5, 7.0), (4, 0.0), (8, 40.0)])
def test_a_plate_between_a_prism_and_a_washer_is_a_sweep_once_both_outlines_have_as_many_edges(n_sides, turn):
    part = cs.load(between(n_sides, 10.0, turn))
    (cell,) = [j for j, solid in enumerate(part.solids) if solid.name == "plate"]
    assert not recognition.search_sweeps(part.solids[cell]).sweeps
    divisions = recognition.find_divisions(part.solids[cell])
    divided = cad.divide_edges(part, {cell: divisions})
    plate = divided.solids[cell]
    above, below = (within(plate, (z - part.offset[2]) / part.scale) for z in (0.0, -THICK))
    assert len(above) == len(below) >= n_sides
    (sweep,) = recognition.find_sweeps(plate)
    assert len(sweep.target_faces) == 2
    assert sum(map(len, divisions.values())) == len(plate.edges) - len(part.solids[cell].edges)


def test_edges_are_divided_where_asked_and_in_all_solids_that_have_them():
    part = cs.load(between(6, 10.0))
    (cell,) = [j for j, solid in enumerate(part.solids) if solid.name == "plate"]
    (other,) = [j for j, solid in enumerate(part.solids) if solid.name == "prism"]
    plate, prism = part.solids[cell], part.solids[other]
    edge = next(e for e in plate.edges if plate.edge_keys[e.id] in prism.edge_keys and e.kind == "line")
    divided = cad.divide_edges(part, {cell: {edge.id: [0.25, 0.5]}})
    for now, was in ((divided.solids[cell], plate), (divided.solids[other], prism)):
        assert len(now.edges) == len(was.edges) + 2
        assert [face.key for face in now.faces] == [face.key for face in was.faces]
        assert now.volume == pytest.approx(was.volume, rel=1e-12)
    for fraction in (0.25, 0.5):
        place = edge.curve.evaluate(np.array([fraction]))
        away = np.linalg.norm(divided.solids[cell].vertices - place, axis=1)
        assert np.count_nonzero(away < 1e-9 * plate.size) == 1
    lengths = sorted(e.length for e in divided.solids[cell].edges if e.kind == "line")
    assert sum(math.isclose(length, edge.length / 4, rel_tol=1e-9) for length in lengths) == 2


def test_outlines_that_are_far_apart_are_none_of_each_other():
    part = cs.load(between(6, 16.0))
    (plate,) = [solid for solid in part.solids if solid.name == "plate"]
    assert recognition.find_divisions(plate) is None


def test_the_mesh_follows_both_outlines_with_fewer_hexahedra_than_cuts_leave():
    joint = between(6, 10.0)
    mesh = cs.sweep_mesh(joint)
    cut = cs.sweep_mesh(joint, without=[recognition.ALIKE])
    assert recognition.ALIKE in mesh.info["rows"]
    assert mesh.record.way["plate"] == "sweep"
    assert mesh.info["quality"].min_scaled_jacobian > max(0.6, cut.info["quality"].min_scaled_jacobian)
    assert mesh.n_hexes < cut.n_hexes / 2
    free = sorted(area_of(mesh, name) for name in ("plate_source", "plate_target"))
    assert free == pytest.approx([1600 - 100 * math.pi, 1600 - 150 * math.sqrt(3)], rel=2e-3)


def area_of(mesh, name):
    a, b, c, d = mesh.points[mesh.boundaries[name]].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(c - a, d - b), axis=1).sum() / 2)
