"""What stands on a line of a plane, and loops seen from the other side.

Place in the flow: helpers of :mod:`.prism`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...arrays import FloatArray
from ...brep import Face, Loop, Units
from ..geometry.face_surface import FaceSurface
from ..geometry.parametric import Ellipse, Line, Parametric
from ..geometry.surfaces import Cone, Extruded, Frame, Geometry, Plane
from ..geometry.vectors import cross_rows


def upright_face(  # noqa: PLR0917
    number: int,
    kind: str,
    area: float,
    center: FloatArray,
    normal: FloatArray,
    loops: tuple[Loop, ...],
    surface: FaceSurface,
    units: Units,
    stands_for: tuple[Face, ...],
) -> Face:
    """A face of a prism, with the key of its number."""
    return Face(
        id=number,
        kind=kind,
        area=area,
        center=center,
        normal=normal,
        loops=loops,
        surface=surface,
        key=f"face {number}",
        units=units,
        stands_for=stands_for,
    )


def known_as(curve: Parametric) -> Callable[[], tuple[Parametric, FloatArray]]:
    """What an edge is in the parameters of its face, for :class:`EdgeOnFace`."""
    return lambda: (curve, np.zeros(2))


def renumbered(loop: Loop, ids: dict[int, int]) -> Loop:
    """The loop with the ids that its lines take in the prism."""
    return Loop(edges=tuple(ids[j] for j in loop.edges), forward=loop.forward, angles=loop.angles)


def turned_round(loop: Loop) -> Loop:
    """The loop run the other way round, from the same edge."""
    n = len(loop.edges)
    order = [-k % n for k in range(n)]
    return Loop(
        edges=tuple(loop.edges[k] for k in order),
        forward=tuple(not loop.forward[k] for k in order),
        angles=tuple(loop.angles[(k + 1) % n] for k in order),
    )


def surface_over(curve: Parametric, up: FloatArray) -> tuple[Geometry, float]:
    """The surface over a curve across `up`, its u the curve's parameter, and the sense of its v."""
    if isinstance(curve, Line):
        x = curve.direction / np.linalg.norm(curve.direction)
        return Plane(frame=Frame(origin=curve.origin, x=x, y=up, z=cross_rows(x[None], up[None])[0])), 1.0
    if isinstance(curve, Ellipse):
        radius = float(np.linalg.norm(curve.x_axis))
        if abs(float(np.linalg.norm(curve.y_axis)) - radius) <= 1e-12 * radius:
            x, y = curve.x_axis / radius, curve.y_axis / radius
            z = cross_rows(x[None], y[None])[0]
            return Cone(frame=Frame(origin=curve.center, x=x, y=y, z=z), radius=radius), float(np.sign(z @ up))
    return Extruded(curve=curve, direction=up), 1.0


def limits_of(geometry: Geometry, first: float, last: float) -> FloatArray:
    """Where a surface over a line from `first` to `last` is defined."""
    if isinstance(geometry, Extruded):
        return np.array([[first, -np.inf], [last, np.inf]])
    return np.array([[-np.inf, -np.inf], [np.inf, np.inf]])


__all__ = ["known_as", "limits_of", "renumbered", "surface_over", "turned_round", "upright_face"]
