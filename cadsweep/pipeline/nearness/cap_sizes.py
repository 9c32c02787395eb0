"""Lengths that keep the quads of a curved cap near to it: inside the cap, and along its edges.

Place in the flow: :mod:`.cell_cap_sizes` and :mod:`.uneven` ask for them where quads of a cap sag too much.

Method: a quad that sags s where d is allowed should be shorter by the square root of s / d, and lengths grow from there
at the rate of all sizes. A quad at the rim is as long as the segment that it stands on, whatever is wanted inside: so
edges are divided by the lengths that are wanted along them, short where the cap is bent and long elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial

import numpy as np
import scipy

from ...arrays import FloatArray
from ...surface import Division
from ...sweep import Sweep
from ..wishes.local_sizes import GROWTH
from ..wishes.size_divisions import by_density, divided_by
from .curvature import UNEVEN, grown

InsideSizes = Callable[[FloatArray], FloatArray]
"""Wanted lengths (m,) at points (m, 3) of the source."""

_MOST_FINER = 3.0
"""Factor by which quads and edges of a cap are made shorter than they are in one round."""
_NEARLY = 0.7
"""Share of the length at which a quad would sag too much from which on it may not grow by much, either."""
_NEAR = 16
"""Quads that sag, among those nearest to a place, that the length wanted there grows from."""
_SAMPLES = 400
"""Places along an edge where the length is asked for."""
_LITTLE = 1.05
"""Factor that is not worth a round."""


def sizes_of_quads(
    middles: FloatArray, lengths: FloatArray, factor: FloatArray, before: InsideSizes | None
) -> InsideSizes | None:
    """Wanted lengths at points of caps whose quads, at their middles (m, 3), are to be so many times (m,) shorter.

    None where no quad is to be much shorter: what is off is the rim.
    """
    reach = lengths
    if before is not None:
        # No mesher follows a wish for one spot that is many times shorter than its quads are.
        shorter = np.clip(before(middles), lengths / _MOST_FINER, lengths)
        lengths = np.where(factor > 1.0, shorter, lengths)
    steep = factor > _NEARLY
    if not steep.any():
        return None
    middles, wanted, reach = middles[steep], (lengths / factor)[steep], reach[steep]
    tree = scipy.spatial.cKDTree(middles)

    def sizes(points: FloatArray) -> FloatArray:
        away, near = tree.query(points, k=min(_NEAR, len(wanted)))
        away, near = away.reshape(len(points), -1), near.reshape(len(points), -1)
        # Growing from the quads that sag, so that who asks at a few places does not miss them.
        larger = wanted[near] + (GROWTH - 1.0) * np.maximum(away - reach[near], 0.0)
        return np.asarray(larger.min(axis=1))

    return sizes


def least_of(one: InsideSizes | None, other: InsideSizes | None) -> InsideSizes | None:
    """The lesser of two wishes at every point."""
    if one is None or other is None:
        return one or other
    return lambda points: np.minimum(one(points), other(points))


def sizes_along_rims(
    sweep: Sweep,
    counts: Mapping[int, float],
    divisions: Mapping[int, Division],
    inside: InsideSizes,
    *,
    fixed: Collection[int],
    uneven: bool,
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes and divisions of the edges of caps whose segments are longer than is wanted there.

    Parameters
    ----------
    sweep : Sweep
    counts : mapping of int to float
        Segments of the edges, as far as is known.
    divisions : mapping of int to callable
        How they are divided, where that is not evenly.
    inside : callable
    fixed : collection of int
        Edges that are to stay as they are divided.
    uneven : bool
        Whether edges may be divided unevenly; else they get even segments as short as the shortest.

    Returns
    -------
    sizes : dict of int to float
        Of edges of the source, and of those that answer them.
    divided : dict of int to callable
        Of edges of the source.
    """
    sizes: dict[int, float] = {}
    divided: dict[int, Division] = {}
    answers = _answers(sweep)
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    for e in sorted({e for f in sweep.source for e in sweep.solid.faces[f].edges}):
        if not {e, *answers.get(e, {})}.isdisjoint(fixed):
            continue
        edge = sweep.solid.edges[e]
        n = max(1, round(counts[e]))
        fractions = divisions[e](n) if e in divisions else np.linspace(0.0, 1.0, n + 1)
        lengths = edge.length * np.diff(fractions)
        present = lengths[np.clip(np.searchsorted(fractions, at, side="right") - 1, 0, n - 1)]
        wanted = np.maximum(inside(edge.curve.evaluate(at)), present / _MOST_FINER)
        if (present <= _LITTLE * wanted).all():
            continue
        least = grown(np.minimum(wanted, present), edge.length)
        mean, places = divided_by(least)
        if places is not None and least.max() > UNEVEN * least.min() and uneven:
            divided[e] = partial(by_density, places=places)
        else:
            mean = float(least.min())
        sizes[e] = mean
        sizes |= {other: mean * share for other, share in answers.get(e, {}).items()}
    return sizes, divided


def _answers(sweep: Sweep) -> dict[int, dict[int, float]]:
    """For each edge of the source the edges that are divided like it, and the length of their segments over its own."""
    edges = sweep.solid.edges
    upward = {side.bottom[0][0]: [e for e, _ in side.top] for side in sweep.linking_sides if len(side.bottom) == 1}
    found: dict[int, dict[int, float]] = {}
    for e in {e for f in sweep.source for e in sweep.solid.faces[f].edges}:
        above = upward.get(e, [sweep.target_edges[e][0]] if e in sweep.target_edges else [])
        answer: dict[int, float] = {}
        while above and not set(above) & {e, *answer}:
            share = sum(edges[other].length for other in above) / edges[e].length
            answer |= dict.fromkeys(above, share)
            above = upward.get(above[0], []) if len(above) == 1 else []
        found[e] = answer
    return found
