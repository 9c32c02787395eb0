"""The grid's axes: those of the part, whichever way it is turned."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.fitted import choose_axes
from cadsweep.pipeline.fitted_grids import _facets

from . import castings


def axes_of(part):
    return choose_axes(_facets(cs.load(part).solids[0]))


def stepped():
    """A block with a step, so that every axis has plane faces."""
    return cq.Workplane().box(30, 20, 10).cut(cq.Workplane().box(10, 30, 10).translate((12, 0, 5)))


def test_of_a_part_along_the_models_axes_they_are_these():
    assert (axes_of(stepped()) == np.eye(3)).all()


@pytest.mark.parametrize("angle", [1.7, 30.0, 77.0])
def test_of_a_turned_part_they_turn_with_it(angle):
    turned = stepped().rotate((0, 0, 0), (1, 2, 3), angle)
    towards = {face.normalAt().toTuple() for face in turned.faces().vals()}
    axes = axes_of(turned)
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert np.allclose(np.abs(axes @ np.array(list(towards)).T).max(axis=0), 1.0, atol=1e-9)


def test_round_faces_have_the_direction_of_their_axis():
    rod = cq.Workplane().circle(3).extrude(40).rotate((0, 0, 0), (0, 1, 0), 20)
    along = np.array([np.sin(np.radians(20)), 0.0, np.cos(np.radians(20))])
    assert np.abs(axes_of(rod) @ along).max() == pytest.approx(1.0, abs=1e-6)


def test_faces_at_sixty_degrees_leave_the_models_axes():
    assert (axes_of(cq.Workplane().polygon(6, 20).extrude(10)) == np.eye(3)).all()


def test_a_turned_casting_has_the_grid_that_it_has_as_it_stands():
    """The same grid in other coordinates: as many hexahedra, and as good as rounding lets untangling be."""
    size = 4.0
    straight = cs.sweep_mesh(castings.manifold(), fitted=True, size=size)
    turned = cs.sweep_mesh(castings.manifold().rotate((0, 0, 0), (1, -1, 2), 33), fitted=True, size=size)
    assert turned.n_hexes == straight.n_hexes
    assert turned.quality().min_scaled_jacobian >= 0.1
    assert turned.quality().volume == pytest.approx(straight.quality().volume, rel=1e-3)
