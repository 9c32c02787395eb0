"""Surfaces of faces, in numpy: points, derivatives, normals and nearest points, thousands at a time.

Place in the flow: ``extract`` turns the surfaces of OpenCASCADE into the geometries below, and
``face_surface`` bounds and orients them into what ``brep.Face.surface`` holds.

Method: planes, cylinders, cones, spheres and tori by their formulas, nearest points in closed form;
extruded and revolved surfaces from their basis curve; B-splines by :mod:`cadsweep.cad.nurbs`.
Nearest points on the last three by Gauss-Newton from the best of a grid (see ``face_surface``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from .nurbs import BSplineSurface
from .parametric import Parametric

Periods = tuple[float | None, float | None]
TWO_PI = 2.0 * np.pi


class Geometry(Protocol):
    """An unbounded surface in its own parameters."""

    @property
    def periods(self) -> Periods:
        """Periods in u and v, None where the surface is not periodic."""
        ...

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives by u and by v, each (m, 3)."""
        ...

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3)."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Frame:
    """An orthonormal frame; ``handedness`` is -1 where x, y, z is left-handed."""

    origin: FloatArray
    x: FloatArray
    y: FloatArray
    z: FloatArray

    @property
    def handedness(self) -> float:
        """1 or -1."""
        return float(np.sign(np.dot(np.cross(self.x, self.y), self.z)))

    def local(self, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coordinates of `points` (m, 3) in the frame, each (m,)."""
        d = points - self.origin
        return d @ self.x, d @ self.y, d @ self.z

    def radial(self, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unit vector at angle u about z, and its derivative, each (m, 3)."""
        cos, sin = np.cos(u)[:, None], np.sin(u)[:, None]
        return cos * self.x + sin * self.y, cos * self.y - sin * self.x


@dataclass(frozen=True, kw_only=True, eq=False)
class Plane:
    """``origin + u x + v y``."""

    frame: Frame
    periods: Periods = (None, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.frame.origin + uv[:, :1] * self.frame.x + uv[:, 1:] * self.frame.y

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        shape = (len(uv), 3)
        return self.evaluate(uv), np.broadcast_to(self.frame.x, shape), np.broadcast_to(self.frame.y, shape)

    @cached_property
    def _normal(self) -> FloatArray:
        # numpy takes twenty times as long for one pair of vectors.
        (a, b, c), (d, e, f) = self.frame.x.tolist(), self.frame.y.tolist()
        x, y, z = b * f - c * e, c * d - a * f, a * e - b * d
        length = sqrt(x * x + y * y + z * z)
        return np.array([x / length, y / length, z / length])

    def unit_normals(self, uv: FloatArray) -> FloatArray:
        """Direction of the cross product of the partial derivatives."""
        return np.broadcast_to(self._normal, (len(uv), 3))

    def project(self, points: FloatArray) -> FloatArray:
        """Nearest parameters."""
        a, b, _ = self.frame.local(points)
        return np.column_stack([a, b])


@dataclass(frozen=True, kw_only=True, eq=False)
class Cone:
    """``origin + (radius + v sin a) radial(u) + v cos a z``; a cylinder where the half angle a is 0."""

    frame: Frame
    radius: float
    half_angle: float = 0.0
    periods: Periods = (TWO_PI, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.derivatives(uv)[0]

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        v = uv[:, 1:]
        sin, cos = np.sin(self.half_angle), np.cos(self.half_angle)
        radial, turned = self.frame.radial(uv[:, 0])
        r = self.radius + v * sin
        return self.frame.origin + r * radial + (v * cos) * self.frame.z, r * turned, sin * radial + cos * self.frame.z

    def unit_normals(self, uv: FloatArray) -> FloatArray:
        """Direction of the cross product of the partial derivatives, also at the apex (from the side of the body)."""
        radial, _ = self.frame.radial(uv[:, 0])
        normal = np.cos(self.half_angle) * radial - np.sin(self.half_angle) * self.frame.z
        side = np.where(self.radius + uv[:, 1] * np.sin(self.half_angle) < 0, -1.0, 1.0)
        return self.frame.handedness * side[:, None] * normal


@dataclass(frozen=True, kw_only=True, eq=False)
class Torus:
    """``origin + (major + minor cos v) radial(u) + minor sin v z``; a sphere where major is 0."""

    frame: Frame
    major: float
    minor: float
    periods: Periods = (TWO_PI, TWO_PI)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.derivatives(uv)[0]

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        radial, turned = self.frame.radial(uv[:, 0])
        cos, sin = np.cos(uv[:, 1:]), np.sin(uv[:, 1:])
        r = self.major + self.minor * cos
        z = self.frame.z
        return (
            self.frame.origin + r * radial + (self.minor * sin) * z,
            r * turned,
            self.minor * (cos * z - sin * radial),
        )

    def unit_normals(self, uv: FloatArray) -> FloatArray:
        """Direction of the cross product of the partial derivatives, also at the poles."""
        radial, _ = self.frame.radial(uv[:, 0])
        cos, sin = np.cos(uv[:, 1:]), np.sin(uv[:, 1:])
        side = np.where(self.major + self.minor * cos < 0, -1.0, 1.0) if self.major else 1.0
        return self.frame.handedness * side * (cos * radial + sin * self.frame.z)


ELEMENTARY = Plane | Cone | Torus
"""Surfaces of which the nearest parameters have a closed form: planes, cylinders, cones, spheres and tori."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Extruded:
    """``curve(u) + v direction``."""

    curve: Parametric
    direction: FloatArray
    periods: Periods = (None, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.curve.derivatives(uv[:, 0])[0] + uv[:, 1:] * self.direction

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        points, by_u = self.curve.derivatives(uv[:, 0], 1)
        return points + uv[:, 1:] * self.direction, by_u, np.broadcast_to(self.direction, by_u.shape)


@dataclass(frozen=True, kw_only=True, eq=False)
class Revolved:
    """``curve(v)`` turned by the angle u about the line through ``origin`` along the unit vector ``axis``."""

    curve: Parametric
    origin: FloatArray
    axis: FloatArray
    periods: Periods = (TWO_PI, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self._turn(self.curve.derivatives(uv[:, 1])[0] - self.origin, uv[:, 0]) + self.origin

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        arm, by_v = self.curve.derivatives(uv[:, 1], 1)
        arm = self._turn(arm - self.origin, uv[:, 0])
        return arm + self.origin, np.cross(self.axis, arm), self._turn(by_v, uv[:, 0])

    def _turn(self, vectors: FloatArray, angles: FloatArray) -> FloatArray:
        cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
        along = (vectors @ self.axis)[:, None] * self.axis
        return along + cos * (vectors - along) + sin * np.cross(self.axis, vectors)


@dataclass(frozen=True, kw_only=True, eq=False)
class Spline:
    """A B-spline surface; on a periodic one the parameters are brought into its knots."""

    spline: BSplineSurface
    periods: Periods = (None, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.spline.evaluate(uv, periods=self._wrapping)

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        return self.spline.derivatives(uv, periods=self._wrapping)

    @cached_property
    def _wrapping(self) -> FloatArray:
        return np.array([0.0 if period is None else period for period in self.periods])


@dataclass(frozen=True, kw_only=True, eq=False)
class Offset:
    """A surface at a signed distance along the normal of another.

    Its partial derivatives are those of the basis plus central differences of the normal (good to
    some 1e-10), which spares the second derivatives of every kind of basis.
    """

    basis: Geometry
    distance: float
    step: tuple[float, float]

    @property
    def periods(self) -> Periods:
        """Those of the basis."""
        return self.basis.periods

    def unit_normals(self, uv: FloatArray) -> FloatArray:
        """The normal of the basis, which the offset shares."""
        _, by_u, by_v = self.basis.derivatives(uv)
        cross = np.cross(by_u, by_v)
        norm = np.linalg.norm(cross, axis=1, keepdims=True)
        return cross / np.where(norm > 0, norm, 1.0)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.basis.evaluate(uv) + self.distance * self.unit_normals(uv)

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        points, by_u, by_v = self.basis.derivatives(uv)
        partials = []
        for j, partial in enumerate((by_u, by_v)):
            h = np.zeros(2)
            h[j] = self.step[j]
            slope = (self.unit_normals(uv + h) - self.unit_normals(uv - h)) / (2 * self.step[j])
            partials.append(partial + self.distance * slope)
        return points + self.distance * self.unit_normals(uv), partials[0], partials[1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Called:
    """A surface known only through a function of u and v (any other kind of OpenCASCADE surface)."""

    function: Callable[[float, float], tuple[tuple[float, float, float], ...]]
    periods: Periods = (None, None)

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points."""
        return self.derivatives(uv)[0]

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives."""
        rows = np.array([self.function(float(u), float(v)) for u, v in uv], dtype=float).reshape(-1, 3, 3)
        return rows[:, 0], rows[:, 1], rows[:, 2]


def knots_of(geometry: Geometry) -> tuple[FloatArray, FloatArray]:
    """Parameters in u and in v between which the surface is smooth; none where there is no such place."""
    none: FloatArray = np.empty(0)
    if isinstance(geometry, Offset):
        return knots_of(geometry.basis)
    if isinstance(geometry, Spline):
        return np.unique(geometry.spline.u_knots), np.unique(geometry.spline.v_knots)
    if isinstance(geometry, Extruded):
        return np.asarray(getattr(geometry.curve, "breaks", none)), none
    if isinstance(geometry, Revolved):
        return none, np.asarray(getattr(geometry.curve, "breaks", none))
    return none, none


def grid_points(geometry: Geometry, u: FloatArray, v: FloatArray) -> FloatArray:
    """Points (len(u) * len(v), 3) of a grid of parameters, v running faster."""
    if isinstance(geometry, Spline) and geometry.periods == (None, None):
        return geometry.spline.evaluate_grid(u, v).reshape(-1, 3)
    return geometry.evaluate(np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2))
