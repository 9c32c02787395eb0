"""Edges divided by their curvature: short segments at a thin leading edge, and long ones beside it.

Place in the flow: :mod:`.uneven` asks for it where a side sags around the sweep, before it divides its edges evenly.

Method: a chord of length h under an arc of radius R is off by d where ``h^2 = 8 R d - 4 d^2``; what turns with a
radius below d cannot be off by more. From where the chords are shortest they grow at the rate of all sizes. A side's
two ends are looked at together, since their segments answer each other.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import partial

import numpy as np

from ...arrays import FloatArray
from ...brep import Edge
from ...surface import Division
from ...sweep import Sweep
from ..wishes.local_sizes import GROWTH
from ..wishes.size_divisions import by_density, divided_by

_SAMPLES = 4000
"""Places along an edge at which it is bent: the tip of a blade may be a thousandth of its section."""
UNEVEN = 1.5
"""Length of the longest segment over the shortest from which on it pays to divide an edge unevenly."""


def divide_by_curvature(
    sweep: Sweep, wanted: dict[int, float], distance: float, *, fixed: Collection[int]
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes and divisions of those edges of the caps that are bent in few places.

    Parameters
    ----------
    sweep : Sweep
    wanted : dict of int to float
        Lengths of the segments, working units, that edges are divided in evenly so far, and are too long somewhere.
    distance : float
        Greatest distance of a chord from its edge.
    fixed : collection of int
        Edges that are to stay as they are divided.

    Returns
    -------
    sizes : dict of int to float
    divisions : dict of int to callable
        Of edges of the source; those of the target answer them.
    """
    sizes: dict[int, float] = {}
    divisions: dict[int, Division] = {}
    on_source = {e for loop in sweep.source_loops for e, _ in loop}
    edges = sweep.solid.edges
    for side in sweep.linking_sides:
        if len(side.bottom) != 1 or len(side.top) != 1:
            continue
        (e, forward), (t, t_forward) = side.bottom[0], side.top[0]
        if e not in wanted or e not in on_source or not {e, t}.isdisjoint(fixed):
            continue
        ends = chords(edges[e], distance), chords(edges[t], distance)
        # Lengths on the other end, as they are on this one.
        other = (ends[1] if forward == t_forward else ends[1][::-1]) * edges[e].length / edges[t].length
        least = np.minimum(np.minimum(ends[0], other), wanted[e])
        mean, places = divided_by(grown(least, edges[e].length))
        if places is None or least.max() < UNEVEN * least.min():
            continue
        sizes[e], sizes[t] = mean, mean * edges[t].length / edges[e].length
        divisions[e] = partial(by_density, places=places)
    return sizes, divisions


def chords(edge: Edge, distance: float) -> FloatArray:
    """Lengths (n,) of chords at even places along an edge that are off by `distance`; infinite where it is straight."""
    points = edge.curve.evaluate(np.linspace(0.0, 1.0, _SAMPLES + 1))
    steps = np.diff(points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not (lengths > 0.0).all():
        return np.full(_SAMPLES + 1, np.inf)
    directions = steps / lengths[:, None]
    turns = np.linalg.norm(np.cross(directions[:-1], directions[1:]), axis=1)
    bends = np.pad(turns / (0.5 * (lengths[:-1] + lengths[1:])), 1, mode="edge")
    with np.errstate(divide="ignore"):
        radii = np.maximum(1.0 / bends, distance)
    return np.asarray(np.sqrt(8.0 * radii * distance - 4.0 * distance**2))


def grown(sizes: FloatArray, length: float) -> FloatArray:
    """Sizes at even places of a line that grow from the least ones no faster than all sizes do."""
    at = (GROWTH - 1.0) * np.linspace(0.0, length, len(sizes))
    up = np.minimum.accumulate(sizes - at) + at
    down = (np.minimum.accumulate((sizes + at)[::-1]))[::-1] - at
    return np.asarray(np.minimum(up, down))
