"""A design's mesh carried onto the model: what cannot be carried is known before there is a mesh."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep import cad
from cadsweep.blends import find_blends
from cadsweep.blends.carrying import _runs_of, check_edges
from cadsweep.blends.lines import Line
from cadsweep.blends.patches import find_patches
from cadsweep.errors import SurfaceMeshError


def lever():
    """A plate with a boss, rounded where they meet and along its upper rim."""
    plate = cq.Workplane().box(40, 16, 6).edges("|Y and >Z").fillet(0.8)
    plate = plate.union(cq.Workplane(origin=(0, 0, 3)).circle(5).extrude(6))
    return (
        plate.edges("%CIRCLE and (not |Y) and (not >Z)")
        .edges(cq.selectors.BoxSelector((-6, -6, 2), (6, 6, 4)))
        .fillet(1.0)
    )


@pytest.fixture(scope="module")
def designed():
    """The model, its blends, its design, and which face of the model each face of that is."""
    part = cs.load(lever())
    (solid,) = part.solids
    blends = find_blends(solid)
    design = cad.design_of(part, blends)
    own = np.array([faces[0] for faces in design.model_faces])
    return solid, blends, design, own


def test_edges_of_a_design_can_be_laid_on_the_model(designed):
    solid, blends, design, own = designed
    patch_of = find_patches(solid, blends, design.gone, design.model_faces)
    check_edges(solid, design.gone, patch_of, design.part.solids[0], own)


def test_a_corner_that_the_model_has_beside_its_edge_is_an_end_of_that(designed):
    solid, blends, design, own = designed
    patch_of = find_patches(solid, blends, design.gone, design.model_faces)
    moved = []
    for one in (solid, design.part.solids[0]):
        vertices = one.vertices.copy()
        vertices[(vertices == [20, 8, -3]).all(axis=1), 2] += 0.01
        assert (vertices != one.vertices).any()
        moved.append(replace(one, vertices=vertices))
    loose, built = moved
    check_edges(loose, design.gone, patch_of, built, own)


def test_an_edge_that_the_model_has_not_is_told_with_its_place(designed):
    solid, _, design, own = designed
    alone = np.arange(len(solid.faces))  # no two faces are one patch: where a blend went, they do not meet
    with pytest.raises(SurfaceMeshError, match=r"has an edge at \(.*\) that the model has not"):
        check_edges(solid, design.gone, alone, design.part.solids[0], own)


class Straight:
    """A run between patches 1 and 2 along a line through a height, from one x on."""

    pair = (1, 2)

    def __init__(self, height, start):
        self.height, self.start = height, start

    def distance(self, points):
        return np.hypot(np.maximum(self.start - points[:, 0], 0.0), points[:, 1] - self.height)


def test_no_run_is_left_without_a_line_though_another_one_is_nearer_to_all():
    runs = [Straight(0.0, 0.0), Straight(1.0, 2.0)]
    points = np.array([[0.0, 0.0], [2.0, 0.1], [2.0, 0.1], [3.0, 0.4], [3.0, 0.4], [4.0, 0.0]])
    lines = [Line(nodes=np.array(nodes), pair=(1, 2)) for nodes in ([0, 1], [2, 3], [4, 5])]
    assert all(
        runs[0].distance(points[line.nodes]).mean() < runs[1].distance(points[line.nodes]).mean() for line in lines
    )
    assert _runs_of(None, runs, lines, points) == [0, 1, 0]
