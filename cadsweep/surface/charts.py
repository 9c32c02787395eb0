"""Plane charts of a face that gmsh can mesh, and the way back onto the surface.

Place in the flow: ``quads`` meshes a face in a chart, then lifts the mesh.

Method: a plane is its own chart. Another face is unrolled through its parameters, each scaled by
the mean length of its partial derivative, where that keeps its outline simple; or it is looked at
along its mean normal, and points are brought onto the surface by the nearest one.

Not handled: faces that neither chart shows without overlap (most of a sphere).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face
from ..polygons import signed_area
from ..sweep import DirectedEdge
from .chart import Chart, inner_places, is_simple, worst_squeeze
from .conformal import SQUEEZED, conformal_chart
from .transfinite import join_chains

_NEARLY_FLAT = 1.2
"""Ratio of a view's stretches, from the normals, up to which the view squeezes no more than they say."""


def charts_of(
    face: Face,
    loops: Sequence[Sequence[DirectedEdge]],
    fractions: Mapping[int, FloatArray],
    nodes: Sequence[IntArray],
    known: FloatArray,
    *,
    size: float,
) -> Iterator[Chart]:
    """Charts of a face, the most faithful first.

    Parameters
    ----------
    loops : directed edges, seen along the sweep
    fractions : by edge
        Arc-length fractions of the edges' nodes.
    nodes : boundary nodes of each loop, perhaps turned against `loops` by a few places
    known : (n, 3) float64
        Points of all nodes so far.
    size : float
        Wanted length of the quads.
    """
    points = [known[ids] for ids in nodes]
    if face.kind == "plane":
        # Where the nodes of a plane's outline cross, it is the size that is too coarse; gmsh_quads says so.
        chart = _seen_along(face, points, [face.surface.project(np.concatenate(points))], exact=True)
        if chart is not None:
            yield chart
        return
    uv = [_loop_uv(face, loop, fractions, p) for loop, p in zip(loops, points, strict=True)]
    unrolled = _unrolled(face, points, uv)
    if unrolled is not None and is_simple(unrolled.boundary):
        charts = [unrolled]
    else:
        charts, unrolled = [], None
    seen = _seen_along(face, points, uv, exact=False)
    if seen is not None and is_simple(seen.boundary):
        charts.append(seen)
    charts.sort(key=lambda chart: _distortion(chart, points))
    if charts and _squeeze(charts[0], unrolled, face, points) > SQUEEZED:
        conformal = conformal_chart(face.surface, unrolled or charts[0], np.concatenate(points), size)
        if conformal is not None:
            yield conformal
    yield from charts


def _loop_uv(
    face: Face, loop: Sequence[DirectedEdge], fractions: Mapping[int, FloatArray], points: FloatArray
) -> FloatArray:
    """Parameters of a loop's nodes, in the order of `points`."""
    parts = [face.surface.edge_uv(e, fractions[e])[:: 1 if forward else -1] for e, forward in loop]
    uv = join_chains(parts)[:-1]
    places = face.surface.evaluate(uv)
    # The nodes may have been turned by one place; the parameters follow them.
    turns = [float(np.abs(np.roll(places, -turn, axis=0) - points).max()) for turn in (0, 1)]
    return np.roll(uv, -int(np.argmin(turns)), axis=0)


def _vector_area(points: FloatArray) -> FloatArray:
    origin = points.mean(axis=0)
    return 0.5 * np.cross(points - origin, np.roll(points, -1, axis=0) - origin).sum(axis=0)


def _plane_frame(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def _seen_along(face: Face, points: Sequence[FloatArray], uv: Sequence[FloatArray], *, exact: bool) -> Chart | None:
    """The face seen along its mean normal into the solid; `exact` where it is a plane."""
    normal = -face.normal if exact else sum((_vector_area(p) for p in points), start=np.zeros(3))
    norm = np.linalg.norm(normal)
    if norm <= 1e-6 * face.area and not exact:
        return None
    first, second = _plane_frame(normal / norm)
    origin = points[0].mean(axis=0)
    frame = np.stack([first, second], axis=1)
    surface = face.surface
    if exact and face.tips:  # nodes of its outline are off the plane
        origin = surface.evaluate(surface.project(origin[None]))[0]

    def lift(places: FloatArray) -> tuple[FloatArray, FloatArray]:
        above = origin + places @ frame.T
        parameters = surface.project(above)
        return (above if exact else surface.evaluate(parameters)), parameters

    return Chart(
        boundary=tuple((p - origin) @ frame for p in points),
        boundary_uv=np.concatenate(uv),
        lift=lift,
        isometric=exact,
    )


def _unrolled(face: Face, points: Sequence[FloatArray], uv: Sequence[FloatArray]) -> Chart | None:
    """The face in its parameters, each scaled to measure lengths."""
    surface = face.surface
    border = np.concatenate(uv)
    low, high = border.min(axis=0), border.max(axis=0)
    u, v = np.meshgrid(*(np.linspace(low[j], high[j], 9) for j in (0, 1)), indexing="ij")
    by_u, by_v = surface.derivatives(np.stack([u.ravel(), v.ravel()], axis=1))
    scale = np.array([np.linalg.norm(by_u, axis=1).mean(), np.linalg.norm(by_v, axis=1).mean()])
    if not np.isfinite(scale).all() or (scale <= 0).any():
        return None
    signs = np.ones(2)
    outer = uv[0] * scale
    if signed_area(outer) < 0:
        signs[0] = -1.0
    factor = scale * signs

    def lift(places: FloatArray) -> tuple[FloatArray, FloatArray]:
        parameters = places / factor
        return surface.evaluate(parameters), parameters

    return Chart(boundary=tuple(part * factor for part in uv), boundary_uv=border, lift=lift)


def _squeeze(chart: Chart, unrolled: Chart | None, face: Face, points: Sequence[FloatArray]) -> float:
    """Greatest ratio of a chart's stretches in two directions; of a view that is nearly flat, from the normals."""
    if unrolled is None or chart is unrolled:
        return worst_squeeze(chart)
    places = inner_places(unrolled)
    if not len(places):
        return 1.0
    area = sum((_vector_area(p) for p in points), start=np.zeros(3))
    cosines = -face.surface.normals(unrolled.lift(places)[1]) @ (area / np.linalg.norm(area))
    steepest = float(1.0 / max(1e-9, float(np.min(cosines))))
    # What is seen is lifted to the nearest place of the face, not to the one behind it: that squeezes more.
    return steepest if steepest < _NEARLY_FLAT else worst_squeeze(chart)


def _distortion(chart: Chart, points: Sequence[FloatArray]) -> float:
    """Greatest ratio between the stretches of boundary segments."""
    ratios = []
    for flat, p in zip(chart.boundary, points, strict=True):
        chart_steps = np.linalg.norm(np.roll(flat, -1, axis=0) - flat, axis=1)
        steps = np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1)
        ratios.append(chart_steps / steps)
    stretch: FloatArray = np.concatenate(ratios)
    return float(np.max(stretch) / max(float(np.min(stretch)), 1e-12))
