"""Where nodes stand along edges: layers along the sweep, and ring nodes that follow the source loop.

Place in the flow: the surface stage calls it before any node is placed.

Method: a layer stands at one *place* in [0, 1] for all rails of a loop. Within a span between
stations the places are even but for roundings that are tangent to a cap, graded by `bias`, or the user's
`fractions`. Around the loops, the
nodes of an edge away from the source divide it as the affine image of the source loop's nodes
divides their image: by lengths of the image, which always keep the order and which on an affine
image of the source are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..sweep import Sweep
from .sweep_grid import SweepGrid

Fit = Callable[[FloatArray, FloatArray], FloatArray]
"""``fit(source_ring (b, 3), rings (m, b, 3)) -> (m, 3, 3)``: linear parts A, ``ring ~ ring_0 @ A.T + c``."""

SMOOTH = 0.05
"""Radians from pi below which cap and side are tangent."""
_RIM_BIAS = 2.5
"""Thickness of a rounding's layer at a tangent cap over that at its other end."""
_GREATEST_JUNCTION_STRETCH = 2.0
"""Stretch of neighbouring layers up to which a layer is moved onto a rail's vertex."""
_LEAST_STRETCH, _GREATEST_STRETCH = 0.25, 4.0
"""Stretch of single layers against the rail's: beyond it the order of layers is in danger."""


def graded_places(n: int, bias: float | Sequence[float] | None) -> FloatArray:
    """Places (n + 1,) of n layers of one span, from 0 to 1.

    Parameters
    ----------
    n : int
        Layers of the span.
    bias : float, (float, float) or None
        Thickness of the last layer over the first's (a geometric row), or a pair: the middle's
        thickness over the first's, and over the last's. None: even.
    """
    if bias is None or n == 1:
        sizes = np.ones(n)
    else:
        at = np.linspace(0.0, 1.0, n)
        if isinstance(bias, Sequence):
            first, last = (np.log(b) for b in bias)
            sizes = np.exp(np.interp(at, [0.0, 0.5, 1.0], [-first, 0.0, -last]))
        else:
            sizes = np.exp(at * np.log(bias))
    places = np.concatenate([[0.0], np.cumsum(sizes)]) / sizes.sum()
    places[-1] = 1.0
    return places


def place_layers(
    sweep: Sweep, layout: SweepGrid, *, bias: float | Sequence[float] | None, fractions: Sequence[float] | None
) -> FloatArray:
    """Places of the layers, for every loop.

    Only ratios within a span matter: an edge between two layers divides itself as the places
    between them divide.

    Returns
    -------
    (n_loops, n_layers + 1) float64
        Rising from 0 to 1.
    """
    n_layers, n_loops = layout.n_layers, len(layout.loop_sizes)
    if fractions is not None:
        places = np.asarray(fractions, dtype=float)
        if places.shape != (n_layers + 1,) or places[0] != 0 or places[-1] != 1 or not (np.diff(places) > 0).all():
            raise InputError(f"fractions must be {n_layers + 1} numbers that rise from 0 to 1, one per node layer")
        return np.tile(places, (n_loops, 1))
    stations = _station_layers(sweep, layout)
    table = np.empty((n_loops, n_layers + 1))
    for loop in range(n_loops):
        knots = [0, *stations[loop], n_layers]
        lengths = _span_lengths(sweep, layout, loop, knots)
        ends = np.concatenate([[0.0], np.cumsum(lengths)]) / lengths.sum()
        for (a, b), (start, end) in zip(pairwise(knots), pairwise(ends), strict=True):
            grading = _at_smooth_rim(sweep, loop, (a == 0, b == n_layers)) if bias is None else bias
            inside = _follow_junctions(sweep, layout, loop, (a, b), graded_places(b - a, grading))
            table[loop, a : b + 1] = start + (end - start) * inside
    # A loop without stations follows those that have them, so that a layer is one place on all rails.
    with_stations = [loop for loop in range(n_loops) if stations[loop]]
    if with_stations:
        common = table[with_stations].mean(axis=0)
        for loop in range(n_loops):
            if not stations[loop]:
                table[loop] = common
    return table


def _at_smooth_rim(sweep: Sweep, loop: int, ends: tuple[bool, bool]) -> float | None:
    """Bias of a rounding's span that begins (or ends) where it is tangent to a cap: its layer there is thickest.

    Hexes at such a rim are as good as the angle between the first segments on cap and side.
    """
    if ends == (True, True):
        return None
    rims = [rim for rim, is_end in zip((sweep.source_loops, sweep.target_loops), ends, strict=True) if is_end]
    smooth = any(abs(sweep.solid.edges[e].dihedral - np.pi) < SMOOTH for rim in rims for e, _ in rim[loop])
    if not smooth:
        return None
    return 1 / _RIM_BIAS if ends[0] else _RIM_BIAS


def _follow_junctions(
    sweep: Sweep, layout: SweepGrid, loop: int, span: tuple[int, int], places: FloatArray
) -> FloatArray:
    """Places of the layers of one span, moved to where rails have vertices inside it.

    A T-junction holds a layer at one height of its rail. Where that is not far from where the layer
    would stand anyway, the layer goes there on all rails.
    """
    first, last = span
    lengths: dict[int, dict[int, tuple[int, float]]] = {}  # column: layer: (segments, length)
    for placed in layout.edges.values():
        if not placed.along_loop and placed.loop == loop and first <= placed.layer < last:
            length = sweep.solid.edges[placed.edge].length
            lengths.setdefault(placed.column, {})[placed.layer] = (placed.n_segments, length)
    heights: dict[int, list[float]] = {}
    for rails in lengths.values():
        total = sum(length for _, length in rails.values())
        run = 0.0
        for layer in sorted(rails):
            run += rails[layer][1]
            heights.setdefault(layer + rails[layer][0], []).append(run / total)
    knots, values = [0], [0.0]
    for layer in sorted(heights):
        k, height = layer - first, float(np.mean(heights[layer]))
        if 0 < k < last - first:
            stretch = (height - values[-1]) / (places[k] - places[knots[-1]])
            rest = (1.0 - height) / (1.0 - places[k])
            if all(1 / _GREATEST_JUNCTION_STRETCH <= s <= _GREATEST_JUNCTION_STRETCH for s in (stretch, rest)):
                knots.append(k)
                values.append(height)
    knots.append(last - first)
    values.append(1.0)
    return np.interp(places, places[knots], values)


def _station_layers(sweep: Sweep, layout: SweepGrid) -> list[list[int]]:
    """Layers of the stations of each loop, rising."""
    layers: list[set[int]] = [set() for _ in layout.loop_sizes]
    for station in sweep.stations:
        for edge in station:
            placed = layout.edges[edge]
            if 0 < placed.layer < layout.n_layers:
                layers[placed.loop].add(placed.layer)
    return [sorted(found) for found in layers]


def _span_lengths(sweep: Sweep, layout: SweepGrid, loop: int, knots: Sequence[int]) -> FloatArray:
    """Mean length of the rails of each span of a loop."""
    lengths = np.zeros(len(knots) - 1)
    weights = np.zeros(len(knots) - 1)
    for placed in layout.edges.values():
        if placed.along_loop or placed.loop != loop:
            continue
        span = int(np.searchsorted(knots, placed.layer, side="right")) - 1
        lengths[span] += sweep.solid.edges[placed.edge].length
        weights[span] += placed.n_segments / (knots[span + 1] - knots[span])
    return lengths / np.where(weights > 0, weights, 1.0)


def rescaled(places: FloatArray) -> FloatArray:
    """Rising places (m,) stretched to begin at exactly 0 and end at exactly 1."""
    out = (places - places[0]) / (places[-1] - places[0])
    out[0], out[-1] = 0.0, 1.0
    return out


def finer(fractions: FloatArray, m: int) -> FloatArray:
    """Every step of rising fractions (n + 1,) in m equal ones."""
    n = len(fractions) - 1
    return np.asarray(np.interp(np.arange(n * m + 1) / m, np.arange(n + 1), fractions))


def fit_linear_parts(source_ring: FloatArray, rings: FloatArray) -> FloatArray:
    """Least-squares linear parts (m, 3, 3) of the maps of a source ring (b, 3) onto rings (m, b, 3).

    Across the plane of a planar source ring the map is left at nothing: no node of the ring needs it.
    """
    centred = source_ring - source_ring.mean(axis=0)
    inverse = np.linalg.pinv(centred, rcond=1e-10)
    return np.einsum("jb,mbi->mij", inverse, rings - rings.mean(axis=1, keepdims=True))


def image_lengths(chords: FloatArray, linear_parts: FloatArray) -> FloatArray:
    """Lengths (k, n) of the images of n segments (n, m, 3), each of m chords, under k linear parts."""
    n, m = chords.shape[:2]
    images = chords.reshape(-1, 3) @ linear_parts.transpose(0, 2, 1)
    return np.asarray(np.sqrt(np.einsum("kcd,kcd->kc", images, images)).reshape(-1, n, m).sum(axis=2))


def divide_like(chords: FloatArray, linear_part: FloatArray | None) -> FloatArray:
    """Arc-length fractions (n + 1,) that divide an edge as the image of the source divides itself.

    Parameters
    ----------
    chords : (n, m, 3) float64
        The stretch of source loop that the edge answers to: m short chords for each of n segments.
    linear_part : (3, 3) float64 or None
        Linear part of the affine map; None for the identity.
    """
    parts = np.eye(3)[None]
    lengths = image_lengths(chords, parts)
    images = lengths if linear_part is None else image_lengths(chords, linear_part[None])
    return divide_lengths(lengths[0], images)[0]


def divide_lengths(lengths: FloatArray, images: FloatArray) -> FloatArray:
    """Fractions (k, n + 1) of rows of image lengths (k, n), answering to the source's lengths (n,) or (k, n).

    A map that flattens the source would let nodes fall together: no segment is stretched much more
    or less than the mean.
    """
    stretch = images.sum(axis=1, keepdims=True) / lengths.sum(axis=-1, keepdims=True)
    flat = stretch <= 0
    images = np.where(flat, lengths, images)
    stretch = np.where(flat, 1.0, stretch)
    images = np.clip(images, _LEAST_STRETCH * stretch * lengths, _GREATEST_STRETCH * stretch * lengths)
    fractions = np.zeros((len(images), images.shape[1] + 1))
    np.cumsum(images, axis=1, out=fractions[:, 1:])
    fractions /= fractions[:, -1:].copy()
    return fractions
