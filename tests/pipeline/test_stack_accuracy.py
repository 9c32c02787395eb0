"""Columns come as near to the CAD as is asked for, also where caps bend that the plane shows as straight strips."""

import numpy as np
import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

import cadsweep as cs

pytestmark = pytest.mark.cad


def saddle():
    """A block over a half bore, with a hole in each of its feet."""
    block = cq.Workplane().box(30, 8, 9, centered=(True, True, False))
    block = block.cut(cq.Workplane("XZ").circle(5).extrude(10, both=True))
    return block.cut(cq.Workplane().pushPoints([(-10, 0), (10, 0)]).circle(1.5).extrude(9))


@pytest.fixture(scope="module")
def columns():
    return cs.sweep_mesh(saddle(), tolerance=0.3, decompose=False)


def test_the_half_bore_is_as_near_as_was_asked_for(columns):
    """Quads sag in their middles and in those of their sides; nothing else of the part is that near to the axis."""
    corners = np.concatenate([columns.points[quads[:, :4]] for quads in columns.boundaries.values()])
    middles = np.concatenate([corners.mean(axis=1), *((corners[:, j] + corners[:, j - 1]) / 2 for j in range(4))])
    from_axis = np.hypot(middles[:, 0], middles[:, 2])
    on_bore = from_axis[(from_axis < 5.0 - 1e-9) & (np.abs(middles[:, 1]) < 4.0 - 1e-9)]
    assert len(on_bore) > 30
    assert 5.0 - on_bore.min() <= 0.3
    assert columns.info["distance"] <= 0.3


def test_cells_take_the_place_of_columns_that_cross_a_bore_sharply(columns):
    mesh = cs.sweep_mesh(saddle(), size=2.0)
    assert mesh.quality().min_scaled_jacobian > max(0.3, columns.quality().min_scaled_jacobian)
    assert len(mesh.boundaries) == len(columns.boundaries)


def test_a_thin_plate_under_a_boss_bends_by_default_and_a_note_says_where_it_does_not():
    plate = cq.Workplane().box(60, 40, 1).faces(">Z").workplane().rect(10, 10).extrude(10)
    mesh = cs.sweep_mesh(plate, decompose=False)
    assert np.isclose(mesh.points[:, 2], 0.0).any()
    assert not any("too stiff" in note for note in mesh.info["notes"])
    coarse = cs.sweep_mesh(plate, decompose=False, size=8.0)
    assert not np.isclose(coarse.points[:, 2], 0.0).any()
    assert any("too stiff" in note for note in coarse.info["notes"])
