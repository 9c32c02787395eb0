"""A sweep that makes poor hexahedra is tried as cells, and the better of both meshes is taken."""

import pytest

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")

from types import SimpleNamespace

import cadquery as cq

from cadsweep import load, sweep_mesh
from cadsweep.pipeline import routes
from cadsweep.pipeline.complexes import best, decomposing
from cadsweep.pipeline.judging import is_pointed

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


@pytest.fixture
def no_cells(monkeypatch):
    def cut(*_, **__):
        raise AssertionError("no cells are looked for")

    monkeypatch.setattr(decomposing, "mesh_decomposed", cut)


def test_nothing_is_tried_where_the_sweep_is_good(no_cells):
    assert sweep_mesh(cq.Workplane().box(4, 3, 2), size=1.0).n_hexes == 24


def wedge(tip, height=2.0):
    """A prism on a triangle whose corner at the origin has a slope `tip`."""
    return cq.Workplane().polyline([(0, 0), (40, 0), (40, 40 * tip)]).close().extrude(height)


def test_nothing_is_tried_where_a_sharp_corner_of_the_part_allows_no_better(no_cells):
    mesh = sweep_mesh(wedge(0.15))
    assert mesh.info["way"] == "sweep"
    assert 0.5 * 0.15 < mesh.info["quality"].min_scaled_jacobian < 0.2


@pytest.mark.parametrize(("x", "is_at_tip"), [(1.0, True), (38.0, False)])
def test_a_sharp_corner_is_to_blame_for_what_lies_at_it(x, is_at_tip):
    worst = SimpleNamespace(center=(x, 0.5 * 0.05 * x, 1.0), radius=1.2)
    assert is_pointed(load(wedge(0.05)).solids[0], SimpleNamespace(worst=[worst])) == is_at_tip
