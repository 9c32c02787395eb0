"""The target cap: on its surface, its ring bit for bit, unfolded, and by the better way."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.errors import InputError
from cadsweep.projection.target import project_target, relaxed_cap, sweep_normals, unwrapped, worst_corner

from .projection_sections import (
    annulus,
    circle,
    corner_sines,
    disc,
    dome,
    l_shape,
    plate_with_hole,
    random_rotation,
    square,
    square_boundary,
    star,
)


class Plane:
    """z = height in a turned frame, parameters stretched by `stretch`."""

    periods = (None, None)

    def __init__(self, height=0.0, frame=None, stretch=(1.0, 1.0)):
        self.frame = np.eye(3) if frame is None else frame
        self.origin, self.stretch = height * self.frame[2], np.asarray(stretch)

    def evaluate(self, uv):
        return self.origin + (uv * self.stretch) @ self.frame[:2]

    def derivatives(self, uv):
        return tuple(
            np.broadcast_to(s * axis, (len(uv), 3)) for s, axis in zip(self.stretch, self.frame[:2], strict=True)
        )

    def project(self, points):
        return (points - self.origin) @ self.frame[:2].T / self.stretch


class Sphere:
    """Longitude and latitude about `axis`; the seam is at longitude 0."""

    periods = (2 * np.pi, None)

    def __init__(self, radius, axis=2):
        self.radius, self.frame = radius, np.roll(np.eye(3), axis + 1, axis=0)

    def evaluate(self, uv):
        u, v = uv.T
        return self.radius * np.c_[np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)] @ self.frame

    def derivatives(self, uv):
        u, v = uv.T
        by_u = np.c_[-np.sin(u) * np.cos(v), np.cos(u) * np.cos(v), 0 * u]
        by_v = np.c_[-np.cos(u) * np.sin(v), -np.sin(u) * np.sin(v), np.cos(v)]
        return self.radius * by_u @ self.frame, self.radius * by_v @ self.frame

    def project(self, points):
        x, y, z = (points @ self.frame.T).T
        return np.c_[np.arctan2(y, x) % (2 * np.pi), np.arctan2(z, np.hypot(x, y))]


class Cylinder:
    """The angle about y, and y: a plane rolled up."""

    periods = (2 * np.pi, None)

    def __init__(self, radius):
        self.radius = radius

    def evaluate(self, uv):
        u, v = uv.T
        return np.c_[self.radius * np.sin(u), v, self.radius * np.cos(u)]

    def derivatives(self, uv):
        u, nothing = uv[:, 0], np.zeros(len(uv))
        return self.radius * np.c_[np.cos(u), nothing, -np.sin(u)], np.c_[nothing, nothing + 1.0, nothing]

    def project(self, points):
        return np.c_[np.arctan2(points[:, 0], points[:, 2]) % (2 * np.pi), points[:, 1]]

    def roll(self, points):
        return self.evaluate(np.c_[points[:, 0] / self.radius, points[:, 1]])


class Graph:
    """z = f(x, y) with uneven parameters x = u^3 + u."""

    periods = (None, None)

    def __init__(self, height=0.5):
        self.height = height

    @staticmethod
    def _x(u):
        return u**3 + u

    def evaluate(self, uv):
        x, y = self._x(uv[:, 0]), uv[:, 1]
        return np.c_[x, y, 3 + self.height * np.cos(x) * np.cos(y)]

    def derivatives(self, uv):
        x, y = self._x(uv[:, 0]), uv[:, 1]
        dx = 3 * uv[:, 0] ** 2 + 1
        zero = 0 * x
        by_u = np.c_[dx, zero, -self.height * np.sin(x) * np.cos(y) * dx]
        return by_u, np.c_[zero, 1 + zero, -self.height * np.cos(x) * np.sin(y)]

    def project(self, points):
        u = points[:, 0].copy()
        for _ in range(60):
            u -= (self._x(u) - points[:, 0]) / (3 * u**2 + 1)
        return np.c_[u, points[:, 1]]


def sphere_points(xy, radius):
    return np.c_[xy, np.sqrt(radius**2 - (xy**2).sum(axis=1))]


@pytest.mark.parametrize("make", [square, annulus, l_shape, disc])
@pytest.mark.parametrize("stretch", [(1.0, 1.0), (1e-4, 30.0), (-2.0, 1.0)])
@pytest.mark.parametrize("seed", range(3))
def test_an_affine_target_plane_is_met_exactly(make, stretch, seed):
    rng = np.random.default_rng(seed)
    section = make()
    surface = Plane(3.0, random_rotation(rng), stretch)
    A = np.eye(2) + 0.1 * rng.standard_normal((2, 2))
    image = surface.evaluate((section.points[:, :2] @ A.T + 0.5) / surface.stretch)
    cap = project_target(section.points, section.quads, section.loops, image[section.ring], surface=surface)
    assert np.abs(cap.points - image).max() < 1e-12 * 10
    assert (cap.points[section.ring] == image[section.ring]).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_sphere_cap_whatever_its_parametrisation(axis):
    """axis 0: the cap lies on the seam; axis 2: round the pole, where the parameters wind and are of no use."""
    section = square(10)
    ring = sphere_points(section.points[section.ring, :2], 2.0)
    cap = project_target(section.points, section.quads, section.loops, ring, surface=Sphere(2.0, axis))
    assert np.abs(np.linalg.norm(cap.points, axis=1) - 2.0).max() < 1e-9 * 4
    assert (cap.points[section.ring] == ring).all()
    assert cap.min_quality > 0.85
    assert cap.method == ("projected" if axis == 2 else "parametric")
    assert cap.qualities[cap.method] == cap.min_quality


def test_given_parameters_may_jump_across_the_seam():
    section = square(8)
    ring = sphere_points(section.points[section.ring, :2], 2.0)
    surface = Sphere(2.0, 0)
    uv = surface.project(ring)
    assert np.ptp(uv[:, 0]) > 5.0  # the seam runs through the cap
    cap = project_target(section.points, section.quads, section.loops, ring, surface=surface, boundary_uv=uv)
    assert cap.method == "parametric"
    assert cap.min_quality > 0.85


def test_holes_follow_the_outer_loop_across_the_seam():
    period = 2 * np.pi
    outer, hole = circle(16, 1.0), circle(8, 0.3, (0.2, 0.0))
    loops = [np.arange(16), np.arange(16, 24)]
    true = np.r_[outer, hole]
    cut = true.copy()
    cut[:, 0] %= period
    mended, winds = unwrapped(cut, loops, (period, None))
    assert not winds
    shift = mended - true
    assert np.allclose(shift, shift[0], atol=1e-12)
    round_the_axis = np.c_[np.linspace(0, period, 12, endpoint=False), np.zeros(12)]
    assert unwrapped(round_the_axis, [np.arange(12)], (period, None))[1]


@pytest.mark.parametrize("make", [lambda: square(10), annulus])
@pytest.mark.parametrize("height", [0.0, 0.6])
def test_uneven_parameters(make, height):
    section = make()
    surface = Graph(height)
    ring = surface.evaluate(surface.project(section.points[section.ring]))
    cap = project_target(section.points, section.quads, section.loops, ring, surface=surface)
    assert np.abs(cap.points - surface.evaluate(surface.project(cap.points))).max() < 1e-9 * 3
    assert cap.min_quality > 0.7


def test_a_curved_source_goes_to_a_curved_target():
    section = dome(square(10), 0.5)
    surface = Graph(-0.6)
    ring = surface.evaluate(surface.project(section.points[section.ring]))
    cap = project_target(section.points, section.quads, section.loops, ring, surface=surface)
    assert cap.min_quality > 0.7


class TestFoldedCaps:
    """Boundaries so far from affine that the harmonic carry folds quads; moved along the surface they unfold."""

    @staticmethod
    def l_with_longer_arms(factor=3.0):
        section = l_shape(5, 3.0, 1.0)
        points = section.points.copy()
        points[:, :2] = np.where(points[:, :2] > 1, 1 + factor * (points[:, :2] - 1), points[:, :2])
        return section, points[section.ring]

    @staticmethod
    def moved_hole(shift=(1.15, 0.0)):
        section = plate_with_hole(48, 10, 2.0, 0.8, center=(-shift[0], -shift[1]))
        target = plate_with_hole(48, 10, 2.0, 0.32, center=shift)
        return section, target.points[target.ring]

    def check(self, section, ring, least):
        cap = project_target(section.points, section.quads, section.loops, ring + [0, 0, 3], surface=Plane(3.0))
        assert (cap.points[section.ring] == ring + [0, 0, 3]).all()
        assert np.abs(cap.points[:, 2] - 3.0).max() < 1e-9
        assert cap.min_quality == pytest.approx(corner_sines(cap.points, section.quads).min(), abs=1e-12)
        assert cap.method.endswith("+relaxed")
        assert cap.min_quality >= least
        return cap

    def test_l_section_with_longer_arms(self):
        cap = self.check(*self.l_with_longer_arms(), 0.5)
        assert cap.qualities["parametric"] < 0.0

    @pytest.mark.parametrize("shift", [(1.15, 0.0), (0.813, 0.813)])
    def test_a_hole_that_moves_and_shrinks(self, shift):
        cap = self.check(*self.moved_hole(shift), 0.3)
        assert cap.qualities["parametric"] < 0.0

    @pytest.mark.parametrize("side", [1.0, -1.0])
    def test_rolled_up_half_round_a_cap_is_relaxed_as_it_is_flat(self, side):
        section, ring = self.moved_hole((0.813, 0.813))
        flat, surface = np.c_[section.points[:, :2], np.zeros(len(section.points))], Cylinder(4.0 / np.pi)
        flat[section.ring] = np.c_[ring[:, :2], np.zeros(len(ring))]
        quads = section.quads if side > 0.0 else section.quads[:, ::-1]
        lain = relaxed_cap(flat, flat, quads, section.loops, Plane())
        rolled = relaxed_cap(surface.roll(flat), flat, quads, section.loops, surface)
        assert (rolled[section.ring] == surface.roll(flat)[section.ring]).all()
        assert np.abs(surface.evaluate(surface.project(rolled)) - rolled).max() < 1e-12
        wanted = worst_corner(lain, quads, np.tile([0.0, 0.0, side], (len(flat), 1)))
        assert wanted > 0.2
        assert worst_corner(rolled, quads, sweep_normals(rolled, quads, surface)) > wanted - 0.02

    def test_on_a_curved_surface(self):
        section, ring = self.moved_hole((0.6, 0.6))
        radius = 6.0
        surface = Sphere(radius, 0)
        ring = sphere_points(ring[:, :2], radius)
        cap = project_target(section.points, section.quads, section.loops, ring, surface=surface)
        assert np.abs(np.linalg.norm(cap.points, axis=1) - radius).max() < 1e-9 * 4
        assert cap.min_quality > 0.3

    @pytest.mark.parametrize(("make", "target", "least"), [(star, circle, 0.55), (disc, square_boundary, 0.6)])
    def test_star_to_circle_and_circle_to_square(self, make, target, least):
        section = make()
        ring = np.c_[target(len(section.ring), 1.0), np.zeros(len(section.ring))] + [0, 0, 3]
        cap = project_target(section.points, section.quads, section.loops, ring, surface=Plane(3.0))
        assert cap.min_quality > least


def test_one_face_of_a_cap_of_several():
    """A face is handed over as a cap of its own: its nodes, its quads, and its whole boundary, inner edges included."""
    section = square(8)
    middle = section.points[section.quads].mean(axis=1)
    halves = []
    whole = np.full_like(section.points, np.nan)
    image = section.points * [1.2, 1, 1] + [0, 0, 2]
    for side in (middle[:, 0] < 0, middle[:, 0] > 0):
        nodes = np.unique(section.quads[side])
        local = np.searchsorted(nodes, section.quads[side])
        n = len(nodes)
        on_edge = np.abs(np.abs(section.points[nodes, 1]) - 1) < 1e-9
        on_edge |= np.abs(np.abs(section.points[nodes, 0] - np.sign(middle[side][0, 0]) * 0.5) - 0.5) < 1e-9
        loop = np.arange(n)[on_edge]
        center = section.points[nodes].mean(axis=0)
        angle = np.arctan2(*(section.points[nodes[loop]] - center)[:, 1::-1].T)
        loop = loop[np.argsort(angle)]
        cap = project_target(section.points[nodes], local, [loop], image[nodes[loop]], surface=Plane(2.0))
        whole[nodes] = cap.points
        halves.append(cap)
    assert np.abs(whole - image).max() < 1e-12
    assert all(cap.min_quality == pytest.approx(1.0) for cap in halves)


class TestRefusals:
    def test_ring_of_another_length(self):
        section = square()
        with pytest.raises(InputError, match="ring"):
            project_target(section.points, section.quads, section.loops, np.zeros((3, 3)), surface=Plane())

    def test_parameters_of_another_length(self):
        section = square()
        ring = section.points[section.ring]
        with pytest.raises(InputError, match="boundary_uv"):
            project_target(
                section.points, section.quads, section.loops, ring, surface=Plane(), boundary_uv=np.zeros((2, 2))
            )


def test_a_hole_that_stays_while_the_outline_shrinks_is_led_to_good_corners():
    mesh = plate_with_hole()
    ring = mesh.points[np.concatenate(mesh.loops)]
    ring[np.abs(ring[:, :2]).max(axis=1) > 1.5, 0] *= 0.8
    cap = project_target(mesh.points, mesh.quads, mesh.loops, ring, surface=Plane())
    assert cap.qualities["parametric"] < 0.65
    assert cap.min_quality > 0.7


def test_an_affine_image_of_fair_corners_is_left_exact():
    mesh = plate_with_hole()
    ring = mesh.points[np.concatenate(mesh.loops)] * [1.3, 1.0, 1.0]
    cap = project_target(mesh.points, mesh.quads, mesh.loops, ring, surface=Plane())
    assert 0.59 < cap.min_quality < 0.7
    assert np.abs(cap.points - mesh.points * [1.3, 1.0, 1.0]).max() < 1e-12


def test_the_worst_corner_is_the_least_sine_of_an_angle():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    quads = np.array([[0, 1, 2, 3]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    sheared = square + np.outer(square[:, 1], [1.0, 0.0, 0.0])  # corners of 45 and 135 degrees
    assert worst_corner(square, quads, up) == pytest.approx(1.0)
    assert worst_corner(sheared, quads, up) == pytest.approx(np.sqrt(0.5))
    assert worst_corner(sheared, quads, -up) == pytest.approx(-np.sqrt(0.5))
    assert worst_corner(sheared, quads, None) == pytest.approx(np.sqrt(0.5))
    assert worst_corner(sheared, quads, up, np.zeros((1, 4), dtype=bool)) == 1.0
    kite = square.copy()
    kite[2] = 0.4, 0.4, 0.0  # re-entrant there
    alone = np.array([[True, False, False, False]])
    assert worst_corner(kite, quads, up) < 0.0
    assert worst_corner(kite, quads, up, alone) == pytest.approx(1.0)
    assert np.isnan(worst_corner(np.where(square == 1.0, np.nan, square), quads, up))
