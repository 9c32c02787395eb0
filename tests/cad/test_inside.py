"""Whether a place is in the material: what rays tell is what OpenCASCADE's classifier does."""

from __future__ import annotations

from collections.abc import Callable

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_State

import cadsweep as cs
from cadsweep.cad.edit.inside import inside_of
from cadsweep.cad.shapes import shapes_of


def spline_column() -> cq.Workplane:
    """A column on a closed spline, twisted, with a ball hollowed out of it."""
    points = [(5.0, 0.0), (1.0, 2.0), (0.0, 5.0), (-2.0, 1.0), (-5.0, 0.0), (0.0, -4.0)]
    return cq.Workplane().spline(points).close().twistExtrude(12.0, 40.0).cut(cq.Workplane("XY", (0, 0, 6)).sphere(1))


def bored_block() -> cq.Workplane:
    return cq.Workplane().box(10, 8, 6).faces(">Z").workplane().hole(3).faces(">X").workplane().hole(2, 4)


@pytest.mark.parametrize("make", [spline_column, bored_block])
def test_rays_tell_what_the_classifier_does(make: Callable[[], cq.Workplane]) -> None:
    solid = cs.load(make()).solids[0]
    is_inside, classifier = inside_of(solid), BRepClass3d_SolidClassifier(shapes_of(solid).shape)
    low, high = solid.vertices.min(axis=0) - 1.0, solid.vertices.max(axis=0) + 1.0
    places = low + (high - low) * np.random.default_rng(5).random((200, 3))
    on_it = [edge.curve.evaluate(np.array([0.3]))[0] for edge in solid.edges]  # hardly inside: rays do not tell
    for place in [*places, *solid.vertices, *on_it]:
        classifier.Perform(gp_Pnt(*place.tolist()), 1e-9 * solid.size)
        assert is_inside(place) == (classifier.State() == TopAbs_State.TopAbs_IN), place
