"""Seams of round faces moved to where no other loop of the face touches them.

Place in the flow: :mod:`.solids` calls it before a solid is judged. A bore of a full turn has a seam, an edge where its
parameters begin again, at an angle that means nothing, and is divided there and opposite to it (:mod:`.divide`). Where
another bore that crosses it just touches one of the two lines, the loop of their crossing touches the outline of the
face, which OpenCASCADE takes for crossing wires. The part is sound: another angle will do.

Method: the face is replaced by its two halves from the new angle on, as long as the face is, and OpenCASCADE's maker of
volumes finds what they and the other faces enclose. It is taken where it is one valid solid of the same volume.

:func:`turn_split_rims` is for faces that OpenCASCADE's tool leaves undivided: it does not divide a rim where that has a
vertex already, opposite to the seam, while the other rim has none.

Not handled: spheres, tori and splines; faces that other loops touch at every angle; what nearly touches.
"""

from __future__ import annotations

from collections import Counter
from itertools import chain
from math import pi, radians
from typing import Any

import numpy as np
from OCP.BOPAlgo import BOPAlgo_MakerVolume
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_ConicalSurface, Geom_CylindricalSurface
from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
from OCP.GeomAbs import GeomAbs_CurveType

from ...arrays import FloatArray
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    compound,
    explore,
    index_map,
    listed,
    mapped,
    subshapes,
    surface_range,
    volume_and_center,
)
from ..trial import attempted
from .tracing import Traced
from .validate import faults, is_closed

_TOUCHES = 1e-3
"""Radians between a loop's outermost point and a line of the face below which it touches it."""
_CLEAR = 0.05
"""Radians that a loop must keep from the new lines: about three degrees."""
_ANGLES = [radians(angle) for angle in (45, 135, 30, 60, 120, 150, 90)]
"""Angles from the old seam that are tried, first those off the planes along which bores are cut further."""
_SAMPLES = 129
"""Points of a loop's curve between which its outermost ones are found."""
_SAME_VOLUME = 1e-6
"""Share of the volume by which the solid may differ; that of one whose loops touch is integrated to some 1e-7."""


def turn_touched_seams(traced: Traced) -> list[str]:
    """Move seams that a loop of their face touches, or that it touches opposite to them, in place; notes say so."""
    turns = {j: turns for j, face in enumerate(subshapes(traced.shape, FACE)) if (turns := _find_turns(face))}
    for attempt in range(min((len(angles) for angles in turns.values()), default=0)):
        if _turn(traced, {j: angles[attempt] for j, angles in turns.items()}):
            its = "1 round face is" if len(turns) == 1 else f"{len(turns)} round faces are"
            return [f"{its} divided at another angle than that of the seam, which another loop touches"]
    return []


def turn_split_rims(traced: Traced) -> bool:
    """Divide round faces with a vertex opposite to the seam, in place, at angles that no vertex and no loop is near."""
    found = ((j, _clear_turns(face)) for j, face in enumerate(subshapes(traced.shape, FACE)))
    turns = {j: angles for j, angles in found if angles}
    tried = range(min((len(angles) for angles in turns.values()), default=0))
    return any(_turn(traced, {j: angles[attempt] for j, angles in turns.items()}) for attempt in tried)


def _turn(traced: Traced, turns: dict[int, float]) -> bool:
    """Divide round faces at angles from their seams, in place; False where that makes no valid solid."""
    maker = BOPAlgo_MakerVolume()
    before = index_map(traced.shape, FACE)
    halves = [_halves(face, turns[j]) if j in turns else [face] for j, face in enumerate(mapped(before, FACE))]
    for half in chain.from_iterable(halves):
        maker.AddArgument(half)
    maker.SetIntersect(True)
    maker.SetNonDestructive(True)
    maker.SetRunParallel(False)
    done = attempted(maker.Perform, "dividing round faces beside their seams")
    volume = volume_and_center(traced.shape)[0]
    solids = [] if not done or maker.HasErrors() else subshapes(maker.Shape(), SOLID)
    found = [one for one in solids if abs(volume_and_center(one)[0] - volume) < _SAME_VOLUME * volume]
    if len(found) != 1 or faults(found[0]) or not is_closed(found[0]):
        return False
    after = index_map(found[0], FACE)

    def image(sub: Any) -> Any:
        if sub.ShapeType() != FACE:
            became = _became(maker, sub)
        else:
            pieces = (new for half in halves[before.FindIndex(sub) - 1] for new in _became(maker, half))
            became = [piece for piece in pieces if after.Contains(piece)]
        return compound(became) if became else None

    if any(image(face) is None for face in mapped(before, FACE)):
        return False
    traced.replace(found[0], image)
    return True


def _became(maker: Any, shape: Any) -> list[Any]:
    return [] if maker.IsDeleted(shape) else listed(maker.Modified(shape)) or [shape]


def _halves(face: Any, turn: float) -> list[Any]:
    """The two halves of a round face from another angle on, over its whole length and without its other loops."""
    surface = BRep_Tool.Surface_s(face).Copy()
    low, _, bottom, top = BRepTools.UVBounds_s(face)
    sense = 1.0 if surface.Position().Direct() else -1.0
    surface.Rotate(surface.Axis(), sense * turn)
    return [
        BRepBuilderAPI_MakeFace(surface.Copy(), start, start + pi, bottom, top, 1e-7).Face()
        for start in (low, low + pi)
    ]


def _find_turns(face: Any) -> list[float]:
    """Radians from the seam of a round face of a full turn to where it may be divided; none where the seam may stay."""
    others = _beside_seam(face)
    outermost = np.concatenate([np.empty(0), *(_outermost(edge, face) for edge in others)]) - _begin(face)
    if not len(outermost) or _apart(outermost, 0.0) > _TOUCHES:
        return []
    return [angle for angle in _ANGLES if _apart(outermost, angle) > _CLEAR]


def _clear_turns(face: Any) -> list[float]:
    """Radians from a seam, opposite to which there is a vertex, to where none and no loop is near; none for others."""
    others = _beside_seam(face)
    if not others:
        return []
    ends = np.concatenate([_ends(edge, face) for edge in others]) - _begin(face)
    if float(np.abs(ends - pi).min()) > _TOUCHES:
        return []
    near = np.concatenate([ends, *(_outermost(edge, face) - _begin(face) for edge in others)])
    return [angle for angle in _ANGLES if _apart(near, angle) > _CLEAR]


def _beside_seam(face: Any) -> list[Any]:
    """The edges but for the seam of a face of a full turn around a cylinder or cone; none of other faces."""
    if not isinstance(BRep_Tool.Surface_s(face), (Geom_CylindricalSurface, Geom_ConicalSurface)):
        return []
    edges = index_map(face, EDGE)
    counts = Counter(edges.FindIndex(edge) for edge in explore(face, EDGE))
    low, high, _, _ = BRepTools.UVBounds_s(face)
    if 2 not in counts.values() or high - low < 2.0 * pi - 1e-6:
        return []
    return [edge for j, edge in enumerate(mapped(edges, EDGE)) if counts[j + 1] == 1]


def _begin(face: Any) -> float:
    """The angle of the seam."""
    return float(BRepTools.UVBounds_s(face)[0])


def _ends(edge: Any, face: Any) -> FloatArray:
    """Angles (2,) around the axis at which the curve of an edge begins and ends."""
    curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
    return np.array([curve.Value(t).X() for t in surface_range(edge, face)])


def _apart(angles: FloatArray, line: float) -> float:
    """Least angle from a line along the axis, or from that opposite to it."""
    return float(np.abs((angles - line + pi / 2) % pi - pi / 2).min())


def _outermost(edge: Any, face: Any) -> FloatArray:
    """Angles at which the curve of an edge turns back around the axis; a straight curve never does."""
    curve = Geom2dAdaptor_Curve(BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0))
    if curve.GetType() == GeomAbs_CurveType.GeomAbs_Line:
        return np.empty(0)
    at = np.linspace(*surface_range(edge, face), _SAMPLES)
    angles = np.array([curve.Value(t).X() for t in at.tolist()])
    if BRep_Tool.IsClosed_s(edge):  # it turns back at its own beginning, too
        angles = np.concatenate([angles, angles[1:2] + (angles[-1] - angles[0])])
    rise = np.diff(angles)
    turns = np.flatnonzero(rise[:-1] * rise[1:] <= 0.0)
    before, after = rise[turns], rise[turns + 1]
    bend = after - before
    # The top of the parabola through three points.
    shift = np.where(np.abs(bend) > 0.0, -(before + after) / np.where(bend == 0.0, 1.0, 2.0 * bend), 0.0)
    return np.asarray(angles[turns + 1] + 0.5 * shift * (before + after) / 2.0)


__all__ = ["turn_split_rims", "turn_touched_seams"]
