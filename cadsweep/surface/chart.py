"""A plane chart of a face: its outline laid out, the way back onto the surface, and how much it stretches.

Place in the flow: :mod:`.charts` and :mod:`.conformal` make charts, ``quads`` meshes in them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import FloatArray
from ..polygons import is_inside, signed_area
from .background import GROWTH, Background, count_interpolated, make_background
from .crossings import loops_cross

_SAMPLES = 24
"""Places in each direction for a chart's stretch."""


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A face laid out in a plane, counter-clockwise as seen along the sweep.

    Attributes
    ----------
    boundary : tuple of (m, 2) float64
        Places of the boundary nodes, loop by loop.
    boundary_uv : (b, 2) float64
        Their parameters on the surface.
    lift : callable
        Places (m, 2) to points (m, 3) on the surface and their parameters (m, 2).
    isometric : bool
        Lengths in the chart are those on the surface.
    conformal : bool
        Angles in the chart are those on the surface; lengths may be far from it.
    """

    boundary: tuple[FloatArray, ...]
    boundary_uv: FloatArray
    lift: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    isometric: bool = False
    conformal: bool = False

    @cached_property
    def n_interpolated(self) -> float:
        """About how many quads fill it where sizes inside are those of its outline, interpolated."""
        return count_interpolated(self.boundary)

    def stretches(self, places: FloatArray) -> FloatArray:
        """Least and greatest length on the surface (m, 2) of a unit step in the chart at places (m, 2)."""
        if self.isometric:
            return np.ones((len(places), 2))
        step = 1e-4 * float(np.max(np.ptp(self.boundary[0], axis=0)))
        ahead, behind = (
            self.lift(np.concatenate([places + sign * step * axis for axis in np.eye(2)]))[0] for sign in (1.0, -1.0)
        )
        by_x, by_y = ((ahead - behind) / (2 * step)).reshape(2, len(places), 3)
        e, f, g = (by_x**2).sum(axis=1), (by_x * by_y).sum(axis=1), (by_y**2).sum(axis=1)
        mean, spread = (e + g) / 2, np.hypot((e - g) / 2, f)
        return np.sqrt(np.stack([np.maximum(mean - spread, 0.0), mean + spread], axis=1))


def is_simple(loops: Sequence[FloatArray]) -> bool:
    """Whether the outlines turn the right way, and no two of their segments cross."""
    if signed_area(loops[0]) <= 0 or any(signed_area(loop) >= 0 for loop in loops[1:]):
        return False
    return not loops_cross(loops)


def inner_places(chart: Chart) -> FloatArray:
    """Places (m, 2) spread evenly over the inside of a chart."""
    outline = np.concatenate(chart.boundary)
    low, high = outline.min(axis=0), outline.max(axis=0)
    axes = (low + (np.arange(_SAMPLES) + 0.5)[:, None] / _SAMPLES * (high - low)).T
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return grid[is_inside(chart.boundary, grid)]


def worst_squeeze(chart: Chart) -> float:
    """Greatest ratio of a chart's stretches in two directions, over places inside it."""
    places = inner_places(chart)
    if chart.isometric or not len(places):
        return 1.0
    least, greatest = chart.stretches(places).T
    return float(np.max(greatest / np.maximum(least, 1e-9 * greatest.max())))


def surface_background(
    chart: Chart, largest: float, *, sizes: Callable[[FloatArray], FloatArray] | None = None, growth: float = GROWTH
) -> Background:
    """Size field of a chart, from lengths that are wanted on the surface.

    Parameters
    ----------
    chart : Chart
    largest : float
        Greatest length on the surface.
    sizes : callable, optional
        Wanted lengths (n,) at points (n, 3) of the surface.
    growth : float
    """
    if chart.isometric and sizes is None:
        return make_background(chart.boundary, largest=largest, growth=growth)

    def sizes_at(places: FloatArray) -> FloatArray:
        wanted = np.full(len(places), largest) if sizes is None else np.minimum(sizes(chart.lift(places)[0]), largest)
        least, greatest = np.maximum(chart.stretches(places), 1e-12).T
        # Square in the chart is stretched on the surface: the lengths wanted are those of its mean side.
        return np.asarray(wanted / np.sqrt(np.maximum(least, greatest / 4.0) * greatest))

    outline = np.concatenate(chart.boundary)
    at_rim = sizes_at(outline)
    across = float(np.max(np.ptp(outline, axis=0)))
    return make_background(
        chart.boundary, largest=min(4.0 * float(np.max(at_rim)), across), sizes_at=sizes_at, growth=growth
    )
