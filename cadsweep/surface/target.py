"""How the inner edges of a target cap of several faces divide themselves.

Place in the flow: after the rings, where recognition found which edge of the target answers to which of the source.

Method: as on the rings: an edge divides itself as the affine image of the source edge does.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray, IntArray
from ..sweep import Sweep
from .spacing import Fit, divide_like, finer

_N_CHORDS = 16
"""Chords that stand for a curved edge's segment."""


def divide_target_edges(
    sweep: Sweep, counts: IntArray, fractions: Mapping[int, FloatArray], rings: FloatArray, fit: Fit
) -> dict[int, FloatArray]:
    """Arc-length fractions of the nodes of inner target edges, by target edge id, from its start to its end.

    `fractions` are those of the source's edges that are not divided evenly.
    """
    on_loops = {edge for loop in sweep.source_loops for edge, _ in loop}
    inner = [e for e in sweep.target_edges if e not in on_loops]
    if not inner:
        return {}
    linear = fit(rings[0], rings[-1:])[0]
    found: dict[int, FloatArray] = {}
    for e in inner:
        n = int(counts[e])
        own = fractions.get(e, np.linspace(0.0, 1.0, n + 1))
        fine = sweep.solid.edges[e].curve.evaluate(finer(own, _N_CHORDS))
        along = divide_like(np.diff(fine, axis=0).reshape(n, _N_CHORDS, 3), linear)
        target, same_direction = sweep.target_edges[e]
        found[target] = along if same_direction else (1.0 - along)[::-1]
    return found
