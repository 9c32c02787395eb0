"""Whether a solid may be a closed sweep, and whether one that was cut open closes on itself.

Place in the flow: asked by the pipeline before and after ``cad`` cuts a ring open.
"""

from __future__ import annotations

import numpy as np

from ..brep import Solid
from ..sweep import Sweep
from .corners import read_rectangles

NEAR = 1e-5
"""Distance, as a share of the part's size, within which the ends of a rail meet."""


def may_be_ring(solid: Solid) -> bool:
    """Whether all faces are rectangles and close to rings: sides around a closed path, without a cap."""
    if not all(read_rectangles(face) for face in solid.faces):
        return False
    return len(solid.vertices) - len(solid.edges) + len(solid.faces) == 0


def why_not_closed(sweep: Sweep) -> str:
    """Say how a ring that was cut open fails to close on itself; empty where it does."""
    solid = sweep.solid
    for source, target in zip(sweep.source_loops, sweep.target_loops, strict=True):
        a, b = (solid.vertices[solid.first_vertex(loop[0])] for loop in (source, target))
        if np.linalg.norm(a - b) > NEAR * solid.size:
            places = " and ".join(f"({solid.units.place(p)})" for p in (a, b))
            return (
                f"the ring closes with a twist: the edge along it that begins at the first of {places} "
                "ends, once around, at the second, so that no mesh of one section meets itself"
            )
    return ""
