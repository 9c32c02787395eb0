"""A conformal chart of a face from another chart of it that is simple but squeezes the face.

Place in the flow: ``charts`` asks for one where a face is far from plane.

Method: the other chart is triangulated so that triangles on the surface are as large as the quads will be; the
triangulation is flattened (:mod:`.flatten`), and places of the new chart go back to the surface through its triangles.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..brep import Surface
from ..errors import SurfaceMeshError
from .chart import Chart, is_simple, surface_background
from .flatten import conformal_map, make_locator
from .gmsh_quads import triangulate

SQUEEZED = 1.8
"""Ratio of a chart's stretches at one place beyond which a conformal one is tried."""


def conformal_chart(surface: Surface, chart: Chart, boundary: FloatArray, largest: float) -> Chart | None:
    """Flatten a face conformally.

    Parameters
    ----------
    surface : Surface
        Of the face.
    chart : Chart
        Of this face, its outline simple.
    boundary : (b, 3) float64
        Points of the chart's boundary nodes.
    largest : float
        Edge length of the triangles.

    Returns
    -------
    Chart or None
        None where the triangulation cannot be had, or the flat outline overlaps itself.
    """
    try:
        inner, triangles = triangulate(chart.boundary, surface_background(chart, largest))
    except SurfaceMeshError:
        return None  # the other chart is as good as it gets
    inner_points, inner_uv = chart.lift(inner)
    points, uv = np.concatenate([boundary, inner_points]), np.concatenate([chart.boundary_uv, inner_uv])
    flat = conformal_map(points, triangles)
    if flat is None:
        return None
    ends = np.cumsum([len(loop) for loop in chart.boundary])
    outline = tuple(np.split(flat[: ends[-1]], ends[:-1]))
    if not is_simple(outline):
        return None
    locate = make_locator(flat, triangles)
    in_space = any(period is not None for period in surface.periods)

    def lift(places: FloatArray) -> tuple[FloatArray, FloatArray]:
        nodes, weights = locate(places)
        if in_space:  # parameters of neighbours may be a period apart
            parameters = surface.project(np.einsum("mk,mkd->md", weights, points[nodes]))
        else:
            parameters = np.einsum("mk,mkd->md", weights, uv[nodes])
        return surface.evaluate(parameters), parameters

    return Chart(boundary=outline, boundary_uv=chart.boundary_uv, lift=lift, conformal=True)
