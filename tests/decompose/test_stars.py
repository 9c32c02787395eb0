"""A polyhedron that a point sees all of is parted into tetrahedra from there."""

from itertools import product
from pathlib import Path

import pytest

pytest.importorskip("cadquery")

import cadquery as cq

from cadsweep import decompose, load
from cadsweep.cad.edit.cutting import cut_cell
from cadsweep.cad.edit.stars import from_inside
from cadsweep.pipeline.complexes.complexes import recognise
from cadsweep.plan import make_plan

pytestmark = pytest.mark.cad


def cuboctahedron():
    """A cube cut off at all corners as far as the middles of its edges: four edges at every corner."""
    cube = cq.Workplane().box(20, 20, 20)
    for signs in product((-1, 1), repeat=3):
        normal = cq.Vector(*signs)
        beyond = cq.Workplane(cq.Plane(normal * (20 / 3), normal=normal)).rect(60, 60).extrude(20)
        cube = cube.cut(beyond)
    return cube.clean()


def test_triangles_are_tetrahedra_and_squares_four():
    part = load(cuboctahedron())
    (cutter,) = from_inside(part.solids[0])
    cells = cut_cell(part, 0, cutter.tools)
    assert len(cells.solids) == 8 + 4 * 6
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(20**3 * 5 / 6)
    assert {len(cell.vertices) for cell in cells.solids} == {4}
    assert sorted(make_plan(cells, [recognise(cell) for cell in cells.solids]).order) == list(range(32))


@pytest.mark.parametrize(
    "make",
    [
        lambda: cq.Workplane().box(3, 2, 1),  # three edges at every corner
        lambda: cq.Workplane().polyline([(0, 0), (9, 0), (9, 1), (1, 1), (1, 9), (0, 9)]).close().extrude(2),
        lambda: cuboctahedron().cut(cq.Workplane().box(1, 1, 40)),  # a hole in two faces
        lambda: cq.Workplane(cq.Solid.makeCone(5, 0, 8)),
    ],
)
def test_nothing_where_a_star_does_not_help(make):
    assert from_inside(load(make()).solids[0]) == []


def test_the_point_sees_all_faces():
    """Two pyramids of unlike heights on one square, whose middle is next to the lower tip."""
    square = [cq.Vector(x, y, 0) for x, y in ((5, 5), (-5, 5), (-5, -5), (5, -5))]
    faces = [
        cq.Face.makeFromWires(cq.Wire.makePolygon([square[k], square[(k + 1) % 4], cq.Vector(0, 0, z)], close=True))
        for z in (9, 2.0)
        for k in range(4)
    ]
    # An arrowhead: the lower tip points into it.
    part = load(cq.Solid.makeSolid(cq.Shell.makeShell(faces)).fix())
    (solid,) = part.solids
    (cutter,) = from_inside(solid)
    cells = cut_cell(part, 0, cutter.tools)
    assert len(cells.solids) == 8
    assert min(cell.volume for cell in cells.solids) > 0.01 * solid.volume
    assert sum(cell.volume for cell in cells.solids) == pytest.approx(solid.volume)


def test_cells_are_written_of_what_only_a_star_parts():
    icosahedron = Path(__file__).parents[1] / "parts" / "decomposed" / "icosahedron.py"
    assert len(decompose(icosahedron).solids) == 20
