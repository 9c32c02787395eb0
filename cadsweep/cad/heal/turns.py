"""Faces whose edges lie whole turns apart in the parameters have all of them within one turn.

Place in the flow: part of healing, before faces are divided. Some programs write the two rims of a turned face a period
apart: every point is right, and OpenCASCADE calls the face valid, but whatever divides it takes its middle for its end.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_Orientation

from ..shapes import EDGE, FACE, WIRE, explore, in_turn, subshapes, surface_range, typed
from .shared_surfaces import change_surface
from .tracing import Traced

_MORE = 1e-3
"""Share of a turn by which a face may go round more than once, by the tolerances of its vertices."""


def gather_turns(traced: Traced) -> None:
    """Bring the curves of faces that go round more than once to where their surfaces begin, in a copy."""
    wide = [(face, periods) for face in subshapes(traced.shape, FACE) if any(periods := _exceeded(face))]
    if not wide:
        return
    tool = BRepBuilderAPI_Copy(traced.shape)
    for face, periods in wide:
        surface = BRep_Tool.Surface_s(face).Copy()
        home = partial(_to_first_turn, surface.Bounds()[::2], periods)
        change_surface(typed(tool.ModifiedShape(face), FACE), surface, home)
    traced.replace(tool.Shape(), tool.ModifiedShape)


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
