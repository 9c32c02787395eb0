"""Rails that wind around each other: where a layer stands abreast on all of them, which is not at equal lengths.

Place in the flow: before nodes are placed, what :mod:`.grading` is asked for besides the user's wishes.

Method: the wall of a spring whose section turns as it goes runs along its inside, then along its outside. At equal
lengths two such rails are far apart along the spring, and the layer between them leans until it folds. Where both
rails of a linking side are parameter lines of its surface, equal parameters are abreast; layers are even, or graded, in
the mean of the lengths that all rails have to there.

Not handled: rails of several edges, stations, sides that are no such surfaces; these stay even in length.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from ..sweep import DirectedEdge, LinkingSide, Sweep
from .grading import Division
from .spacing import graded_places

SAMPLES = 257
"""Places along a rail, between which it is followed by chords."""
LEANING = 0.5
"""How far one rail may be ahead of the next at equal lengths, over their distance: a layer leans by that tangent."""
APART = 1e-3
"""Share of a side's parameters by which its rails may be off two parameter lines from end to end."""


def rails_abreast(sweep: Sweep, bias: float | Sequence[float] | None = None) -> dict[int, Division]:
    """How rails divide themselves so that layers stand square, by edge id; empty where equal lengths are as good.

    Parameters
    ----------
    sweep : Sweep
    bias : float, (float, float) or None
        Of the layers, as :func:`.spacing.graded_places` takes it.
    """
    solid = sweep.solid
    if sweep.stations or sweep.closed or all(solid.edges[e].kind in ("line", "circle") for e in sweep.rails):
        return {}
    shares: dict[DirectedEdge, FloatArray] = {}
    leaning = 0.0
    for side in sweep.linking_sides:
        ends = _along(solid, side)
        if ends is None:
            return {}
        for rail, share in ends.items():
            if np.abs(shares.setdefault(rail, share) - share).max() > APART:
                return {}
        leaning = max(leaning, _leaning(solid, ends))
    if leaning < LEANING:
        return {}
    mean = np.mean([*shares.values()], axis=0)
    return {
        e: partial(_divided, mean=mean, share=share, forward=forward, bias=bias)
        for (e, forward), share in shares.items()
    }


def _along(solid: Solid, side: LinkingSide) -> dict[DirectedEdge, FloatArray] | None:
    """Shares (SAMPLES,) of the lengths of a side's two rails at even parameters; None where they are no such lines."""
    if len(side.left) != 1 or len(side.right) != 1:
        return None
    at = np.linspace(0.0, 1.0, SAMPLES)
    rails = (side.left[0], side.right[0])
    surface = solid.faces[side.face].surface
    uv = np.array([surface.edge_uv(e, at if forward else at[::-1]) for e, forward in rails])
    span = uv[:, -1] - uv[:, 0]
    along = int(np.abs(span[0]).argmax())
    first, across = uv[:, :, along], uv[:, :, 1 - along]
    between = float(np.abs(across[1] - across[0]).max())
    is_line = np.ptp(across, axis=1).max() <= APART * between
    is_together = np.ptp(first[:, [0, -1]], axis=0).max() <= APART * abs(span[0, along])
    places = (first - first[:, :1]) / span[:, along, None]
    if not (is_line and is_together and (np.diff(places, axis=1) > 0.0).all()):
        return None
    return {rail: np.interp(at, own, at) for rail, own in zip(rails, places, strict=True)}


def _leaning(solid: Solid, ends: dict[DirectedEdge, FloatArray]) -> float:
    """How far one rail is ahead of the other at equal lengths, at most, over their distance abreast."""
    (left, right), (ahead, behind) = ends.keys(), ends.values()
    places = [
        solid.edges[e].curve.evaluate(share if forward else 1.0 - share)
        for (e, forward), share in ((left, ahead), (right, behind))
    ]
    apart = np.linalg.norm(places[1] - places[0], axis=1)
    length = 0.5 * (solid.edges[left[0]].length + solid.edges[right[0]].length)
    return float((np.abs(ahead - behind) * length / np.maximum(apart, 1e-12 * length)).max())


def _divided(
    n: int, *, mean: FloatArray, share: FloatArray, forward: bool, bias: float | Sequence[float] | None
) -> FloatArray:
    """Fractions (n + 1,) of a rail where the mean of all is divided evenly, or graded."""
    found = np.interp(graded_places(n, bias), mean, share)
    return found if forward else 1.0 - found[::-1]


__all__ = ["rails_abreast"]
