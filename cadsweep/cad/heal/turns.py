"""Faces whose edges lie whole turns apart in the parameters have all of them within one turn, which begins with them.

Place in the flow: part of healing, before faces are divided. Some programs write the two rims of a turned face a period
apart: every point is right, and OpenCASCADE calls the face valid, but whatever divides it takes its middle for its end.
A spline of one turn that begins elsewhere than its face loses what is beyond its end when the face is divided: it is
made to begin with the face.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_BSplineSurface
from OCP.TopAbs import TopAbs_Orientation

from ..shapes import EDGE, FACE, WIRE, explore, in_turn, subshapes, surface_range, typed
from .shared_surfaces import change_surface
from .tracing import Traced

_MORE = 1e-3
"""Share of a turn by which a face may go round more than once, by the tolerances of its vertices."""
_BESIDE = 1e-5
"""Share of a turn by which a face may begin beside its surface."""

Move = Callable[[tuple[float, float]], tuple[float, float]]
"""By how much a curve in the parameters is moved, from where its middle is."""


def gather_turns(traced: Traced) -> None:
    """Bring curves of faces that go round more than once to where their surfaces begin, or these there, in a copy."""
    moved: list[tuple[Any, Any, Move]] = []
    for face in subshapes(traced.shape, FACE):
        if any(periods := _exceeded(face)):
            surface = BRep_Tool.Surface_s(face).Copy()
            moved.append((face, surface, partial(_to_first_turn, surface.Bounds()[::2], periods)))
        elif (begun := _begun_with(face)) is not None:
            moved.append((face, *begun))
    if not moved:
        return
    tool = BRepBuilderAPI_Copy(traced.shape)
    for face, surface, home in moved:
        change_surface(typed(tool.ModifiedShape(face), FACE), surface, home)
    traced.replace(tool.Shape(), tool.ModifiedShape)


def _begun_with(face: Any) -> tuple[Any, Move] | None:
    """A spline surface that begins where its face of one turn does, and how far to move the curves; None for others."""
    surface = BRep_Tool.Surface_s(face)
    if not isinstance(surface, Geom_BSplineSurface) or not (surface.IsUPeriodic() or surface.IsVPeriodic()):
        return None
    begun, shift = surface.Copy(), [0.0, 0.0]
    ends, bounds = BRepTools.UVBounds_s(face), surface.Bounds()
    for way, is_periodic in enumerate((surface.IsUPeriodic(), surface.IsVPeriodic())):
        (low, high), (first, last) = ends[2 * way : 2 * way + 2], bounds[2 * way : 2 * way + 2]
        period = last - first
        start = low + _shift(low, first, period)
        is_whole = is_periodic and high - low > (1.0 - _MORE) * period
        if is_whole and min(start - first, last - start) > _BESIDE * period:
            _begin_at(begun, way, start)
            shift[way] = start - low
    return None if begun.Bounds() == bounds else (begun, lambda _: (shift[0], shift[1]))


def _begin_at(surface: Any, way: int, start: float) -> None:
    """Let a periodic spline surface begin at another parameter, in u or in v; every point keeps its own."""
    insert, knots, knot, begin = (
        (surface.InsertUKnot, surface.NbUKnots, surface.UKnot, surface.SetUOrigin),
        (surface.InsertVKnot, surface.NbVKnots, surface.VKnot, surface.SetVOrigin),
    )[way]
    insert(start, 1, 1e-12, False)
    begin(min(range(1, knots() + 1), key=lambda j: abs(knot(j) - start)))


def _to_first_turn(
    begin: tuple[float, float], periods: tuple[float, float], middle: tuple[float, float]
) -> tuple[float, float]:
    u, v = map(_shift, middle, begin, periods)
    return u, v


def _exceeded(face: Any) -> tuple[float, float]:
    """Periods of a face's surface in both parameters; 0 where it has none, or the face is within one."""
    surface = BRep_Tool.Surface_s(face)
    if not (surface.IsUPeriodic() or surface.IsVPeriodic()):
        return (0.0, 0.0)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    u = surface.UPeriod() if surface.IsUPeriodic() else 0.0
    v = surface.VPeriod() if surface.IsVPeriodic() else 0.0
    periods = (u if u1 - u0 > (1.0 + _MORE) * u else 0.0, v if v1 - v0 > (1.0 + _MORE) * v else 0.0)
    return periods if any(periods) and not _is_connected(face, periods) else (0.0, 0.0)


def _is_connected(face: Any, periods: tuple[float, float]) -> bool:
    """Whether every edge of a face begins in its parameters where the one before it ends.

    That of a seam that goes on at another angle half way, as of two cylinders made one, covers more than a turn, too.
    """
    for wire in explore(face, WIRE):
        ends = []
        for edge in in_turn(wire, face):
            curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
            places = [curve.Value(t).Coord() for t in surface_range(edge, face)]
            ends.append(places[::-1] if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else places)
        apart = np.abs([np.subtract(ends[j][0], ends[j - 1][1]) for j in range(len(ends))])
        if len(ends) < len([*explore(wire, EDGE)]) or (2.0 * apart > np.where(periods, periods, np.inf)).any():
            return False
    return True


def _shift(x: float, first: float, period: float) -> float:
    """The least number of whole periods that brings a parameter into the first one, whose ends are both in it."""
    if not period:
        return 0.0
    turns = (x - first) / period
    return float(period * (max(0.0, np.ceil(-turns - _MORE)) - max(0.0, np.ceil(turns - 1.0 - _MORE))))
