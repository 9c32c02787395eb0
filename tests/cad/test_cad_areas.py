"""Flat ellipses and splines: areas by formula, and closed faces that are as large as their halves."""

import numpy as np
import pytest
from scipy.special import ellipe

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

from cadsweep.cad import cut_ring, load  # noqa: E402
from cadsweep.cad.geometry.measure import measure_closed_area  # noqa: E402
from cadsweep.cad.heal.divide import _check_divided  # noqa: E402
from cadsweep.cad.shapes import FACE, compound, index_map  # noqa: E402
from cadsweep.errors import CadError  # noqa: E402

RATIOS = (1.01, 2.0, 5.0, 10.0, 20.0, 50.0)
LONG, HEIGHT = 6.0, 5.0


def perimeter(ratio):
    """Of an ellipse with the half axes LONG and LONG / ratio, by the complete elliptic integral."""
    return 4 * LONG * ellipe(1 - 1 / ratio**2)


def flat_spline(height):
    return cq.Workplane().spline([(6, 0), (0, height), (-6, 0), (0, -height)], periodic=True).close().extrude(5)


def ellipse_ring(ratio, angle):
    """A ring about an axis 15 off the middle of its section."""
    section = cq.Workplane("XZ").center(15, 0).ellipse(LONG, LONG / ratio)
    return section.revolve(angle, (-15, 0, 0), (-15, 1, 0))


@pytest.mark.parametrize("ratio", RATIOS)
def test_side_of_an_elliptic_cylinder_is_perimeter_times_height(ratio):
    solid = load(cq.Workplane().ellipse(LONG, LONG / ratio).extrude(HEIGHT)).solids[0]
    side = sum(face.area for face in solid.faces if face.kind != "plane")
    assert side == pytest.approx(perimeter(ratio) * HEIGHT, rel=1e-6)
    assert solid.volume == pytest.approx(np.pi * LONG**2 / ratio * HEIGHT, rel=1e-9)


@pytest.mark.parametrize("ratio", RATIOS)
def test_elliptic_hole(ratio):
    plate = load(cq.Workplane().rect(20, 20).ellipse(LONG, LONG / ratio).extrude(HEIGHT)).solids[0]
    wall = sum(face.area for face in plate.faces if face.kind != "plane")
    assert wall == pytest.approx(perimeter(ratio) * HEIGHT, rel=1e-6)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("angle", [90, 360])
def test_revolved_ellipse_follows_pappus(ratio, angle):
    way = np.radians(angle) * 15
    part = load(ellipse_ring(ratio, angle))
    solid = part.solids[0]
    assert solid.volume == pytest.approx(np.pi * LONG**2 / ratio * way, rel=1e-9)
    skin = sum(face.area for face in solid.faces if face.kind != "plane")
    assert skin == pytest.approx(perimeter(ratio) * way, rel=1e-6)
    if angle == 360:
        assert cut_ring(part).solids[0].volume == pytest.approx(solid.volume, rel=1e-9)


@pytest.mark.parametrize(
    "shape",
    [
        cq.Workplane().ellipse(6, 0.3).sweep(cq.Workplane("XZ").radiusArc((20, 20), 20)),
        cq.Workplane().ellipse(6, 0.3).workplane(offset=8).ellipse(3, 0.15).loft(),
        cq.Workplane().ellipse(6, 1.2).twistExtrude(10, 60),
        flat_spline(0.3),
        cq.Workplane().rect(20, 20).extrude(5).cut(flat_spline(0.1)),
        cq.Workplane(cq.Solid.makeCone(5, 0, 7)),
        ellipse_ring(20, 90),
    ],
    ids=["sweep", "loft", "twist", "spline", "spline_hole", "cone", "quarter_ring"],
)
def test_a_closed_face_is_as_large_as_its_halves(shape):
    closed = sum(measure_closed_area(face.wrapped) for face in shape.faces().vals())
    assert closed == pytest.approx(sum(face.area for face in load(shape).solids[0].faces), rel=1e-4)


def test_a_half_that_got_lost_is_refused():
    shape = cq.Workplane().ellipse(6, 0.3).extrude(5).val()
    old = index_map(shape.wrapped, FACE)
    halves = load(shape).solids[0].kernel.faces
    curved = next(j for j, face in enumerate(load(shape).solids[0].faces) if face.kind != "plane")
    rest = compound([face for j, face in enumerate(halves) if j != curved])
    with pytest.raises(CadError, match="changed the surface"):
        _check_divided(rest, old)


def test_domed_annular_plate_is_cut_open():
    dome = cq.Workplane("XZ").moveTo(3, 0).lineTo(10, 0).lineTo(10, 1).threePointArc((6.5, 2.2), (3, 2.6)).close()
    part = load(dome.revolve(360, (0, 0, 0), (0, 1, 0)))
    assert cut_ring(part).solids[0].volume == pytest.approx(part.solids[0].volume, rel=1e-9)


def test_a_steep_bump_is_as_large_as_the_triangles_on_it():
    def height(x, y):
        return 5 + 14 * np.exp(-((x + 6) ** 2 + (y - 3) ** 2) / 18)

    at = np.linspace(-31, 31, 21)
    surface = cq.Face.makeSplineApprox([[cq.Vector(x, y, height(x, y)) for y in at] for x in at], tol=1e-4)
    pieces = cq.Workplane(obj=cq.Workplane().rect(50, 34).extrude(40).val().split(surface)).solids().vals()
    part = load(cq.Workplane(obj=min(pieces, key=lambda piece: piece.Center().z)))
    (bump,) = (face for face in part.solids[0].faces if face.kind == "bspline")
    x, y = np.meshgrid(np.linspace(-25, 25, 251), np.linspace(-17, 17, 171), indexing="ij")
    above = (np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3) - part.offset) / part.scale
    places = bump.surface.evaluate(bump.surface.project(above)).reshape(*x.shape, 3)
    one, other = places[1:, 1:] - places[:-1, :-1], places[:-1, 1:] - places[1:, :-1]
    quads = 0.5 * np.linalg.norm(np.cross(one, other), axis=2)
    assert bump.area == pytest.approx(quads.sum(), rel=4e-4)
