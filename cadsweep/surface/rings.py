"""Rings of a cell whose linking sides are its own: they follow the affine image of its source.

Place in the flow: after ``intervals``; :class:`~.skeleton.Skeleton` takes the nodes, edges by key and sides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..arrays import FloatArray
from ..sweep import Intervals, Sweep
from .cap_heights import keep_heights
from .grading import grade_places
from .sides import RingBuilder
from .spacing import Fit, fit_linear_parts, place_layers
from .sweep_grid import SweepGrid, build_grid
from .target import divide_target_edges


@dataclass(frozen=True, kw_only=True, eq=False)
class Rings:
    """The rings of a sweep, by ids of its solid.

    Attributes
    ----------
    layout : SweepGrid
    points : (n_layers + 1, b, 3) float64
    fractions : dict of int to (n + 1,) float64
        Of the edges around the caps, along the sweep, and inside the target.
    notes : tuple of str
    """

    layout: SweepGrid
    points: FloatArray
    fractions: dict[int, FloatArray]
    notes: tuple[str, ...]


def lay_rings(
    sweep: Sweep,
    intervals: Intervals,
    graded: Mapping[int, FloatArray],
    fixed: Mapping[int, FloatArray],
    *,
    bias: float | Sequence[float] | None = None,
    fractions: Sequence[float] | None = None,
    heights: Mapping[bool, FloatArray] | None = None,
    fit: Fit = fit_linear_parts,
) -> Rings:
    """Place the nodes of all edges around a sweep, and of its sides.

    Parameters
    ----------
    graded : mapping of int to (n + 1,) float64
        Fractions of edges of the source that are not divided evenly.
    fixed : mapping of int to (n + 1,) float64
        The same of edges anywhere, which have them and no others; layers go by those along the sweep.
    bias : float, (float, float) or None
        Grading of the layers within each span between stations: thickness of the last over the first, or a pair, of
        the middle over the first and over the last.
    fractions : (n_layers + 1,) or None
        Explicit places of the layers from 0 to 1, instead of `bias`.
    heights : mapping of bool to (n,) float64, optional
        Of layers along the source (True) and the target that are kept between the rails.
    fit : callable
        ``fit(source_ring (b, 3), rings (m, b, 3))``: linear parts (m, 3, 3) of the affine maps by which ring nodes
        follow the source loop.

    Raises
    ------
    SurfaceMeshError
        The counts do not fit together, or a side cannot be filled; names the face.
    InputError
        Places that are none.
    """
    layout = build_grid(sweep, intervals)
    places = place_layers(sweep, layout, bias=bias, fractions=fractions)
    places = grade_places(layout, places, {e: fixed[e] for e in fixed if e in layout.edges})
    builder = RingBuilder(sweep, layout, places, fit, graded=graded, fixed=fixed)
    builder.build()
    inner = divide_target_edges(sweep, intervals.counts, graded, builder.rings, fit)
    side_faces, node_edges, _ = layout.labels()
    keep_heights(sweep, builder.rings, side_faces, node_edges, heights or {})
    return Rings(
        layout=layout,
        points=builder.rings,
        fractions={**inner, **builder.fractions, **fixed},
        notes=tuple(builder.notes),
    )
