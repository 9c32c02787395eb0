"""Periodic faces of cells: cuts that end on the one are carried to the other."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.errors import SurfaceMeshError
from cadsweep.pipeline.complexes.answering import CARRIED

pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad


def test_faces_that_cuts_divide_in_different_places_answer_each_other():
    block = cq.Workplane().box(50, 36, 24).faces(">Z").workplane().center(-14, 4).hole(9)
    block = block.faces(">Z").workplane(origin=(0, 0, 12)).center(10, -6).hole(6, 14)
    block = block.faces("<X").workplane(origin=(-25, 0, 0)).center(6, -3).hole(5, 10)
    mesh = cs.sweep_mesh(block, size=3.0, periodic={"<Y": ">Y"})
    assert mesh.record.way == "cells"
    assert mesh.quality().valid
    (pairs,) = mesh.periodic.values()
    np.testing.assert_allclose(
        np.diff(mesh.points[pairs], axis=1)[:, 0], np.tile([0, 36, 0], (len(pairs), 1)), atol=1e-6
    )
    assert CARRIED in mesh.info["rows"]
    assert any("carried from one periodic face" in note for note in mesh.info["notes"])
    for side in (-18.0, 18.0):
        on = np.flatnonzero(abs(mesh.points[:, 1] - side) < 1e-9)
        assert np.isin(on, pairs).all()
    with pytest.raises(SurfaceMeshError, match="cut there, too"):
        cs.sweep_mesh(block, size=3.0, periodic={"<Y": ">Y"}, without=[CARRIED])
