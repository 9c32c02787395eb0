"""Solids a little apart, or a little in one another, are meshed as one where ``touch`` closes the gap."""

import numpy as np
import pytest

import cadsweep as cs

cq = pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = pytest.mark.cad


def box(corner, size):
    return cq.Workplane().box(*size, centered=False).translate(corner)


PAIRS = {
    # what stands on a plate of 4 x 4 x 1, how far it is off, the area where they meet
    "whole face": (box((0, 0, 1.002), (4, 4, 1)), 0.0025, 16.0),
    "small on large": (box((1, 1, 1.01), (1, 1, 2)), 0.012, 1.0),
    "too deep": (box((1, 1, 0.998), (2, 2, 1)), 0.0025, 4.0),
}


@pytest.mark.parametrize("pair", PAIRS)
def test_what_touch_closes_is_meshed_as_one_and_checked_within_what_it_moved(pair):
    upper, touch, area = PAIRS[pair]
    plate = box((0, 0, 0), (4, 4, 1))
    whole = cq.Compound.makeCompound([*plate.solids().vals(), *upper.solids().vals()])
    mesh = cs.sweep_mesh(whole, size=0.5, touch=touch)
    assert mesh.quality().valid
    (quads,) = mesh.interfaces.values()
    sides = mesh.points[quads]
    met = 0.5 * np.linalg.norm(np.cross(sides[:, 2] - sides[:, 0], sides[:, 3] - sides[:, 1]), axis=1).sum()
    assert met == pytest.approx(area, abs=touch * 4 * area**0.5)
    volume = sum(solid.Volume() for solid in whole.Solids())
    assert mesh.quality().volume == pytest.approx(volume, abs=touch * (16 + area))
