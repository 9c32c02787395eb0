"""Labels that are a quad or two away from a skin like the model."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.fitted import choose_planes, finding, keep_inside
from cadsweep.fitted.labels import label_quads
from cadsweep.fitted.mending import Skin, Wanted, mend_labels
from cadsweep.fitted.topology import MisfitError, match_topology
from cadsweep.pipeline.fitted_grids import LETTING, MENDING, _facets


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
    euler, runs, n = Skin.of(quads).counts(labels, len(solid.faces))
    return (euler == wanted.euler).all() and (runs == wanted.runs).all() and n == wanted.n_vertices


def test_a_skin_that_is_found_has_the_counts_of_the_model(labelled):
    solid, grid, labels, size = labelled
    match_topology(solid, grid.points, grid.quads, labels, size)
    assert counted(solid, grid.quads, labels)


def test_what_changes_around_borders_is_all_that_changes(labelled):
    """Counts of a part of the skin differ by what those of the whole do."""
    solid, grid, labels, _ = labelled
    skin = Skin.of(grid.quads)
    beside = skin.neighbours()
    border = np.flatnonzero((labels[beside] != labels[:, None]).any(axis=1))
    part = skin.part(np.union1d(border, beside[border]))
    assert len(part.own) < len(skin.own)
    changed = labels.copy()
    for quad in border[::7]:
        changed[quad] = changed[beside[quad]].max()
    before, after = ([own.counts(now, len(solid.faces)) for own in (skin, part)] for now in (labels, changed))
    assert (before[0][1] == before[1][1]).all()
    assert (after[0][1] == after[1][1]).all()
    assert (after[0][0] - before[0][0] == after[1][0] - before[1][0]).all()
    assert before[0][2] == before[1][2]
    assert after[0][2] == after[1][2]


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


def test_a_mesh_says_that_labels_were_mended_and_none_are_where_that_is_forbidden(monkeypatch):
    def spoilt(solid, facets, points, quads, size):
        labels = label_quads(solid, facets, points, quads, size)
        top = np.flatnonzero(labels == face_at(solid, 2, 1))
        middles = points[quads[top]].mean(axis=1)
        along = top[np.lexsort((np.abs(middles[:, 1]), -middles[:, 0]))]
        labels[along[:1]] = face_at(solid, 1, 1)
        return labels

    monkeypatch.setattr(finding, "label_quads", spoilt)
    box = cq.Workplane().box(8, 12, 6)
    mesh = cs.sweep_mesh(box, fitted=True, size=1.2)
    assert MENDING in mesh.record.rows
    assert LETTING not in mesh.record.rows
    assert mesh.quality().volume == pytest.approx(8 * 12 * 6)
    without = cs.sweep_mesh(box, fitted=True, size=1.2, without=[MENDING])
    assert MENDING not in without.record.rows
    assert LETTING in without.record.rows
