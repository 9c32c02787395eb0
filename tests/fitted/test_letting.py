"""Edges that a grid cannot hold: as few as will do are let go, each is told, and the mesh is near them all the same."""

import re

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import NotSweepableError, SurfaceMeshError
from cadsweep.fitted import choose_planes, finding, keep_inside
from cadsweep.fitted.labels import label_quads
from cadsweep.fitted.letting import let_go
from cadsweep.pipeline.fitted_grids import LETTING, _facets

SIZE = 2.0


@pytest.fixture(scope="module")
def box():
    return cq.Workplane().box(8, 12, 6)


@pytest.fixture(scope="module")
def labelled(box):
    """The solid of a box, a grid in it, the face of every quad, and the size."""
    solid = cs.load(box).solids[0]
    facets = _facets(solid)
    size = SIZE / 12 * solid.size
    grid = keep_inside(choose_planes(solid, facets, np.eye(3), size), facets, np.eye(3))
    return solid, grid, label_quads(solid, facets, grid.points, grid.quads, size), size


def face_at(solid, axis, sign):
    return next(face.id for face in solid.faces if sign * face.normal[axis] > 0.9)


def edges_within(solid, of_face):
    return [edge.id for edge in solid.edges if of_face[edge.faces[0]] == of_face[edge.faces[1]]]


def test_where_all_is_found_nothing_goes(labelled):
    solid, grid, labels, size = labelled
    assert let_go(solid, grid.points, grid.quads, labels, size, ()).tolist() == list(range(6))


@pytest.mark.parametrize("axis", [0, 1])
def test_a_face_without_quads_is_one_with_the_face_that_has_them(labelled, axis):
    solid, grid, labels, size = labelled
    top, side = face_at(solid, 2, 1), face_at(solid, axis, 1)
    of_face = let_go(solid, grid.points, grid.quads, np.where(labels == top, side, labels), size, ())
    (edge,) = edges_within(solid, of_face)
    assert set(solid.edges[edge].faces) == {top, side}


def test_an_edge_that_is_named_goes(labelled):
    solid, grid, labels, size = labelled
    asked = [solid.edges[3].faces]
    assert edges_within(solid, let_go(solid, grid.points, grid.quads, labels, size, asked)) == [3]


def test_a_skin_that_is_not_the_models_is_refused(labelled):
    solid, grid, labels, size = labelled
    with pytest.raises(SurfaceMeshError, match="topology"):
        let_go(solid, grid.points, grid.quads, np.zeros_like(labels), size, ())


@pytest.fixture
def loses_the_top(monkeypatch):
    """Grids on which the top of a box is labelled as the side at +x."""

    def spoilt(solid, *args):
        labels = label_quads(solid, *args)
        return np.where(labels == face_at(solid, 2, 1), face_at(solid, 0, 1), labels)

    monkeypatch.setattr(finding, "label_quads", spoilt)
    monkeypatch.setattr(finding, "lay_strips", lambda solid, mesh, size, on_step: mesh)


def test_a_mesh_without_an_edge_is_on_it_all_the_same_and_keeps_the_names(box, loses_the_top):
    mesh = cs.sweep_mesh(box, fitted=True, size=SIZE, names={"lid": "faces:>Z", "wall": "faces:>X"})
    assert mesh.quality().min_scaled_jacobian >= 0.1
    # Nodes slide off a crease by half a cell at most: what is cut off is a triangle of that, all along the edge.
    assert 0.0 <= 8 * 12 * 6 - mesh.quality().volume < 12 * 0.5 * (0.5 * SIZE) ** 2
    assert (mesh.points[mesh.boundaries["lid"]][..., 2] == 3).all()
    assert (mesh.points[mesh.boundaries["wall"]][..., 0] == 4).all()
    (note,) = (note for note in mesh.record.notes if "cannot hold" in note)
    assert re.search(r"edge \d+ \(line", note)
    assert LETTING in mesh.record.rows


def test_without_the_rule_it_is_refused(box, loses_the_top):
    with pytest.raises(NotSweepableError, match="no quad"):
        cs.sweep_mesh(box, fitted=True, size=SIZE, without=[LETTING])
