"""A sweep that makes poor hexahedra is tried as cells, and the better of both meshes is taken."""

import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

import cadquery as cq

from cadsweep import sweep_mesh
from cadsweep.pipeline import routes
from cadsweep.pipeline.complexes import best, decomposing

pytestmark = pytest.mark.cad


@pytest.fixture
def nothing_is_good_enough(monkeypatch):
    """Every sweep counts as poor, and no scaled Jacobian of cells is above one."""
    monkeypatch.setattr(routes, "is_as_good", lambda *_: False)
    monkeypatch.setattr(best, "GOOD_ENOUGH", 1.1)


def test_cells_take_the_place_of_a_worse_sweep(nothing_is_good_enough):
    """One lattice of coarse quads on an L is a compromise at its inner corner; two boxes are not."""
    part = cq.Workplane().polyline([(0, 0), (12, 0), (12, 4), (4, 4), (4, 12), (0, 12)]).close().extrude(6)
    mesh, swept = (sweep_mesh(part, size=2.3, decompose=decompose) for decompose in (True, False))
    assert any(note.startswith("cut ") for note in mesh.info["notes"])
    assert mesh.info["quality"].min_scaled_jacobian > swept.info["quality"].min_scaled_jacobian


def test_a_sweep_stays_where_there_are_no_cells(nothing_is_good_enough):
    """A box has nothing to be cut at."""
    mesh = sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0)
    assert mesh.n_hexes == 24
    assert not any(note.startswith("cut") for note in mesh.info["notes"])


def test_nothing_is_tried_where_the_sweep_is_good(monkeypatch):
    def cut(*_):
        raise AssertionError("no cells are looked for")

    monkeypatch.setattr(decomposing, "mesh_decomposed", cut)
    assert sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0).n_hexes == 24
