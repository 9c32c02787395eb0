"""Labels that are a quad or two away from a skin like the model."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.fitted import choose_planes, keep_inside
from cadsweep.fitted.counting import count_skin
from cadsweep.fitted.labels import label_quads
from cadsweep.fitted.mending import Skin, Wanted, mend_labels
from cadsweep.fitted.topology import MisfitError, match_topology
from cadsweep.pipeline.fitted_grids import _facets


@pytest.fixture(scope="module")
def labelled():
    """The solid of a bored box, a grid in it, the face of every quad, and the size."""
    solid = cs.load(cq.Workplane().box(8, 12, 6).faces(">Z").workplane().hole(4)).solids[0]
    facets = _facets(solid)
    size = solid.size / 18
    grid = keep_inside(choose_planes(solid, facets, np.eye(3), size), facets, np.eye(3))
    return solid, grid, label_quads(solid, facets, grid.points, grid.quads, size), size


def counted(solid, quads, labels):
    wanted = Wanted.of(solid)
    euler, runs = np.empty_like(wanted.euler), np.empty_like(wanted.runs)
    n = count_skin(*Skin.of(quads), labels, euler, runs)
    return (euler == wanted.euler).all() and (runs == wanted.runs).all() and n == wanted.n_vertices


def test_a_skin_that_is_found_has_the_counts_of_the_model(labelled):
    solid, grid, labels, size = labelled
    match_topology(solid, grid.points, grid.quads, labels, size)
    assert counted(solid, grid.quads, labels)


def test_what_is_alike_stays_as_it_is(labelled):
    solid, grid, labels, _ = labelled
    assert (mend_labels(solid, grid.quads, labels) == labels).all()


def face_at(solid, axis, sign):
    return next(face.id for face in solid.faces if face.kind == "plane" and sign * face.normal[axis] > 0.9)


@pytest.mark.parametrize("n", [1, 2])
def test_quads_of_a_third_face_at_a_corner_are_given_back(labelled, n):
    """A face that reaches round a vertex meets one that it has no edge with, or cuts an edge in two."""
    solid, grid, labels, size = labelled
    top, side = face_at(solid, 2, 1), face_at(solid, 0, 1)
    middles = grid.points[grid.quads].mean(axis=1)
    edge = np.flatnonzero((labels == top) & (middles[:, 0] > middles[labels == top, 0].max() - 1e-9))
    along = edge[np.argsort(np.abs(middles[edge, 1] - np.median(middles[edge, 1])))]
    spoilt = labels.copy()
    spoilt[along[:n]] = face_at(solid, 1, 1)  # beyond the vertex, not beside the edge
    assert not counted(solid, grid.quads, spoilt)
    with pytest.raises(MisfitError):
        match_topology(solid, grid.points, grid.quads, spoilt, size)
    mended = mend_labels(solid, grid.quads, spoilt)
    assert counted(solid, grid.quads, mended)
    assert set(mended[along[:n]].tolist()) <= {top, side}
    match_topology(solid, grid.points, grid.quads, mended, size)


def test_what_no_few_quads_mend_stays_as_it_is(labelled):
    solid, grid, labels, _ = labelled
    spoilt = np.where(labels == face_at(solid, 2, 1), face_at(solid, 0, 1), labels)
    assert (mend_labels(solid, grid.quads, spoilt) == spoilt).all()
