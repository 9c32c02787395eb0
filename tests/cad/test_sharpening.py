"""A solid built anew without its blends is its sharp twin: no boolean is asked for it."""

from dataclasses import replace
from itertools import combinations

import cadquery as cq
import pytest

import cadsweep as cs
from cadsweep.blends import find_blends
from cadsweep.cad.edit.collapsing import CannotCloseError, collapse
from cadsweep.cad.edit.sharpening import sharpen
from cadsweep.cad.heal.validate import check_closed
from cadsweep.cad.shapes import EDGE, FACE, VERTEX, subshapes, volume_and_center


def pocket():
    """A pocket with upright corners, a floor and a rim that are rounded: patches between convex and concave."""
    inside = cq.Workplane().box(12, 8, 6)
    sharp = cq.Workplane().box(24, 18, 8).cut(inside.translate((0, 0, 2)))
    round_inside = inside.edges("|Z").fillet(2).faces("<Z").edges().fillet(1)
    model = cq.Workplane().box(24, 18, 8).cut(round_inside.translate((0, 0, 2)))
    rim = model.faces(">Z").edges(cq.selectors.BoxSelector((-7, -5, 3), (7, 5, 5)))
    return cq.Workplane(model.val().fillet(0.5, rim.vals())), sharp


def across_an_edge():
    """A blend in an angle, whose ends lie across the edges between the planes and the cylinders that it ends at."""
    outline = (
        cq.Workplane().moveTo(-5, -10).lineTo(1.5, -10).tangentArcPoint((14, -4), relative=False)
        .lineTo(14, 4).threePointArc((8.5, 8.5), (1.5, 10)).lineTo(-5, 10).close().extrude(30)
    )  # fmt: skip
    sharp = cq.Workplane("XZ").polyline([(-5, 0), (30, 0), (30, 4), (0, 4), (0, 20), (-5, 20)]).close()
    sharp = sharp.extrude(15, both=True)
    model = sharp.edges(cq.selectors.NearestToPointSelector((0, 0, 4))).fillet(3)
    return model.intersect(outline), sharp.intersect(outline)


def everything_rounded():
    """Three blends and a ball at every corner."""
    return cq.Workplane().box(10, 8, 6).edges().fillet(1.5), cq.Workplane().box(10, 8, 6)


def mixed_radii():
    """A step whose edges are rounded one over the other, with two radii."""
    sharp = cq.Workplane().box(30, 20, 10).cut(cq.Workplane().box(30, 20, 10).translate((12, 0, 5)))
    model = sharp.edges("|Y").edges(cq.selectors.NearestToPointSelector((-3, 0, 0))).fillet(2)
    top = model.faces(">Z").edges(">X").vals()
    return cq.Workplane(model.val().fillet(1, top)), sharp


@pytest.mark.parametrize("made", [everything_rounded, pocket, across_an_edge, mixed_radii])
def test_what_is_built_is_the_sharp_twin(made):
    model, sharp = made()
    part = cs.load(model)
    (solid,) = part.solids
    blends = find_blends(solid)
    gone = {f for blend in blends for f in blend.faces}
    found = sharpen(solid, blends, {})
    check_closed(found.shape)
    assert gone
    assert set(found.faces) == {face.id for face in solid.faces} - gone
    assert len(subshapes(found.shape, FACE)) == len(found.faces)
    volume = volume_and_center(found.shape)[0] * part.scale**3
    assert volume == pytest.approx(sharp.val().Volume(), rel=1e-6)


@pytest.mark.parametrize("made", [everything_rounded, pocket, across_an_edge, mixed_radii])
def test_nothing_that_is_built_is_the_solids_own(made):
    """What is shared would be changed with it: curves of edges on faces are shifted to close a wire."""
    (solid,) = cs.load(made()[0]).solids
    found = sharpen(solid, find_blends(solid), {})
    own = [*solid.kernel.faces, *solid.kernel.edges, *solid.kernel.vertices]
    built = [shape for kind in (FACE, EDGE, VERTEX) for shape in subshapes(found.shape, kind)]
    assert not any(one.IsPartner(other) for one in own for other in built)


def test_a_vertex_of_a_collapsed_box_is_where_three_faces_meet():
    (solid,) = cs.load(everything_rounded()[0]).solids
    topology = collapse(solid, find_blends(solid))
    assert len(topology.vertices) == 8
    assert len(topology.edges) == 12
    for vertex in topology.vertices:
        pairs = {frozenset(edge.faces) for edge in topology.edges if vertex in edge.ends}
        faces = frozenset.union(*pairs)
        assert pairs == {frozenset(pair) for pair in combinations(faces, 2)}
        assert len(faces) == 3


def test_what_no_faces_close_over_is_named():
    """A side of a box is no blend: its neighbours do not meet where it was."""
    (solid,) = cs.load(cq.Workplane().box(10, 8, 6).edges("|Z").edges(">X and >Y").fillet(1)).solids
    (blend,) = find_blends(solid)
    assert set(sharpen(solid, [blend], {}).faces) == {face.id for face in solid.faces} - set(blend.faces)
    side = next(face.id for face in solid.faces if face.id not in {*blend.faces, *sum(blend.supports, ())})
    with pytest.raises(CannotCloseError) as refused:
        sharpen(solid, [blend, replace(blend, faces=(side,))], {})
    assert refused.value.faces == {side}
