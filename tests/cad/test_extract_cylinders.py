"""Plain cylinders read all at once: the same as one by one by curves in their parameters."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.cad.extract.cylinders import find_cylinders
from cadsweep.cad.extract.sampling import sample_edges, sample_face
from cadsweep.cad.geometry.measure import measure_face


def _drilled() -> cq.Workplane:
    """Bored and counterbored plate, mirrored and turned: frames of both hands, along no axis."""
    plate = cq.Workplane().box(30, 30, 10).edges("|Z").fillet(3).faces(">Z").workplane()
    plate = plate.rect(15, 15, forConstruction=True).vertices().cboreHole(3, 5, 4)
    return plate.mirror("XZ").rotate((0, 0, 0), (1, 2, 3), 40)


def _notched() -> cq.Workplane:
    """A tube whose walls have notches: more than four edges a face, inside and outside."""
    return cq.Workplane().circle(5).circle(4).extrude(9).cut(cq.Workplane().box(20, 2, 4))


@pytest.mark.parametrize("make", [_drilled, _notched])
def test_all_at_once_as_one_by_one(make):
    solid = cs.load(make()).solids[0]
    surfaces, curves = [face.surface for face in solid.faces], [edge.curve for edge in solid.edges]
    samples = sample_edges(curves)
    for curve, points, length in zip(curves, samples.points, samples.lengths, strict=True):
        assert np.array_equal(curve.frames(np.array([0.0, 0.5, 1.0]))[1], points)
        assert curve.length == length
    found = find_cylinders(surfaces)
    assert len(found.faces) == sum(face.kind == "cylinder" for face in solid.faces) > 0
    measures = found.measures([face.loops for face in solid.faces], curves)
    along = found.samples(surfaces, samples)
    for f in found.faces.tolist():
        for own, other in zip(measures[f], measure_face(surfaces[f], solid.faces[f].loops), strict=True):
            np.testing.assert_allclose(own, other, atol=1e-10)
        general = sample_face(surfaces[f], samples)
        for edge, normals in general.normals.items():
            np.testing.assert_allclose(along[f].normals[edge], normals, atol=1e-12)
        assert along[f].gaps.max() == along[f].gap < 1e-12
