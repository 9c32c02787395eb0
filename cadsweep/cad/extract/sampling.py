"""Edges and faces at their starts, middles and ends, once for the whole solid.

Place in the flow: ``solids`` reads lengths, tangents, angles and gaps from here.

Method: straight edges, arcs, planes and cylinders are most of what a machined part has, and numpy takes as long for one
point as for a hundred; so all of them are evaluated together, the others one by one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, IntArray
from ..geometry.angles import MIDDLE
from ..geometry.curves import END_FRACTIONS, EdgeCurve, unhooked
from ..geometry.face_surface import FaceSurface
from ..geometry.parametric import Ellipse, Line
from ..geometry.surfaces import Plane

AT = np.array([0.0, 0.5, 1.0])
"""Arc-length fractions of the samples."""


class EdgeSamples(NamedTuple):
    """Every edge at its start, middle and end.

    Attributes
    ----------
    parameters : (n_edges, 3) float64
        The curves' own parameters at `AT`.
    points, tangents : (n_edges, 3, 3) float64
        At `AT`; unit tangents from start to end.
    end_tangents : (n_edges, 2, 3) float64
        Those of ``EdgeCurve.end_tangents``.
    lengths : (n_edges,) float64
    """

    parameters: FloatArray
    points: FloatArray
    tangents: FloatArray
    end_tangents: FloatArray
    lengths: FloatArray

    def take(self, edges: IntArray) -> EdgeSamples:
        """Those of some edges (m,), in their order."""
        return EdgeSamples(*(values[edges] for values in self))


def sample_edges(curves: Sequence[EdgeCurve]) -> EdgeSamples:
    """Evaluate every edge at `AT`."""
    n = len(curves)
    out = EdgeSamples(np.empty((n, 3)), np.empty((n, 3, 3)), np.empty((n, 3, 3)), np.empty((n, 2, 3)), np.empty(n))
    lines = [(j, curve, curve.geometry) for j, curve in enumerate(curves) if isinstance(curve.geometry, Line)]
    if lines:
        straight = [j for j, _, _ in lines]
        origin = np.array([line.origin for _, _, line in lines])
        direction = np.array([line.direction for _, _, line in lines])
        first, last = np.array([(curve.first, curve.last) for _, curve, _ in lines]).T
        # As `EdgeCurve.parameters` has them, so that 0 and 1 give the ends exactly.
        at = first[:, None] * (1.0 - AT) + last[:, None] * AT
        out.parameters[straight] = at
        speed = np.linalg.norm(direction, axis=1)
        out.points[straight] = origin[:, None] + at[..., None] * direction[:, None]
        tangents = direction / speed[:, None]
        out.tangents[straight] = tangents[:, None]
        out.end_tangents[straight] = tangents[:, None]
        out.lengths[straight] = speed * (last - first)
    _sample_arcs([(j, curve) for j, curve in enumerate(curves) if is_arc(curve)], out)
    others = [j for j, curve in enumerate(curves) if not isinstance(curve.geometry, Line) and not is_arc(curve)]
    _sample_others(others, [curves[j] for j in others], out)
    return out


def is_arc(curve: EdgeCurve) -> bool:
    """Whether a curve is an arc of a circle."""
    return isinstance(curve.geometry, Ellipse) and curve.constant_speed


def arc_frames(arcs: Sequence[EdgeCurve]) -> tuple[list[FloatArray], FloatArray, FloatArray]:
    """Centres and both axes of arcs, each (n, 3), and the angles (n,) at which they begin and end."""
    frames = [np.array([getattr(arc.geometry, name) for arc in arcs]) for name in ("center", "x_axis", "y_axis")]
    first, last = np.array([(arc.first, arc.last) for arc in arcs]).T
    return frames, first, last


def _sample_arcs(arcs: Sequence[tuple[int, EdgeCurve]], out: EdgeSamples) -> None:
    """The formulas of `Ellipse` and `EdgeCurve` for all arcs of circles at once."""
    if not arcs:
        return
    own = [j for j, _ in arcs]
    frames, first, last = arc_frames([curve for _, curve in arcs])
    center, x_axis, y_axis = (vectors[:, None] for vectors in frames)
    at = first[:, None] * (1.0 - AT) + last[:, None] * AT
    cos, sin = np.cos(at)[..., None], np.sin(at)[..., None]
    out.parameters[own] = at
    out.points[own] = center + (cos * x_axis + sin * y_axis)
    tangents = cos * y_axis - sin * x_axis
    speed = np.linalg.norm(tangents, axis=2)
    tangents /= speed[..., None]
    out.tangents[own] = tangents
    out.end_tangents[own] = tangents[:, ::2]
    out.lengths[own] = speed[:, 0] * (last - first)


def _sample_others(own: Sequence[int], curves: Sequence[EdgeCurve], out: EdgeSamples) -> None:
    """One question to each curve, at its ends, in its middle, and beside its ends, where it may have hooks."""
    if not own:
        return
    asked = np.concatenate([AT[1:2], END_FRACTIONS])
    frames = [curve.frames(asked) for curve in curves]
    parameters, points, tangents = (np.array(values) for values in zip(*frames, strict=True))
    in_order = [1, 0, 2]  # start, middle, end, as `AT` has them
    out.parameters[own] = parameters[:, in_order]
    out.points[own] = points[:, in_order]
    out.tangents[own] = tangents[:, in_order]
    out.end_tangents[own] = unhooked(curves, tangents[:, 1:3], points[:, 3:])
    out.lengths[own] = [curve.length for curve in curves]


class FaceSamples(NamedTuple):
    """A face along its edges.

    Attributes
    ----------
    normals : mapping of int to (3, 3) float64
        Outward normals at the start, middle and end of each edge; (1, 3) in the middle of the face, under `MIDDLE`.
    gap : float
        Greatest distance between the edges' samples and the surface.
    edge : int
        The edge that it was found on.
    place : (3,) float64
        Where.
    gaps : (n,) float64, or None
        Distances of the edges from the surface, where it is one that they bound themselves; in the order of `normals`.
    """

    normals: Mapping[int, FloatArray]
    gap: float
    edge: int
    place: FloatArray
    gaps: FloatArray | None = None


def sample_face(surface: FaceSurface, edges: EdgeSamples) -> FaceSamples:
    """Normals of a face along its edges, and how far it lies off them."""
    numbers = list(surface.curves)
    points = edges.points[numbers].reshape(-1, 3)
    if isinstance(surface.geometry, Plane):
        normal = surface.normals(surface.box[:1])
        gaps = np.abs((points - surface.geometry.frame.origin) @ normal[0])
        normals = dict.fromkeys(numbers, np.broadcast_to(normal, (3, 3)))
        normals[MIDDLE] = normal
    else:
        uv = surface.edges_uv(numbers, edges.parameters[numbers], edges.points[numbers])
        gaps = np.linalg.norm(surface.evaluate(uv) - points, axis=1)
        normals = dict(zip(numbers, surface.normals(uv).reshape(-1, 3, 3), strict=True))
        normals[MIDDLE] = surface.normals(surface.box.mean(axis=0)[None])
    worst = int(gaps.argmax())
    return FaceSamples(normals, float(gaps[worst]), numbers[worst // 3], points[worst])
