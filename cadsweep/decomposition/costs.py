"""What stands in the way of a cell, in numbers: both searches for cuts go where these are least."""

from __future__ import annotations

from math import pi

from ..arrays import FloatArray
from ..brep import Solid

SHARP = pi / 6
"""Dihedral angle below which an edge makes poor hexahedra."""
SHORT = 0.02
"""Length, as a share of a size, below which an edge asks for small hexahedra."""
BLOCKED, REENTRANT, IMPRINT, CELL, SHARP_EDGE, SHORT_EDGE, CONTRADICTION = 4.0, 1.0, 0.6, 0.35, 0.5, 0.3, 1.5
"""What a cell without sweep, its re-entrant and imprinted edges, any cell, poor edges and contradictions cost."""


DIRECTION = 2.5
"""What every direction beyond the first costs in which holes go through the faces of a cell without sweep."""


def _ways_of_holes(solid: Solid) -> int:
    """Directions of plane faces with holes in them."""
    found: list[FloatArray] = []
    for face in solid.faces:
        if face.kind != "plane" or len(face.loops) < 2:
            continue
        if not any(abs(float(face.normal @ other)) > 1.0 - 1e-9 for other in found):
            found.append(face.normal)
    return len(found)


def cell_cost(solid: Solid, sweeps: bool, *, size: float, flat: float) -> float:
    """What a cell adds to the cost of a complex.

    Parameters
    ----------
    solid : Solid
    sweeps : bool
        Whether it has a sweep.
    size : float
        What its edges are short beside, working units.
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    total = CELL
    for edge in solid.edges:
        total += SHARP_EDGE * (edge.dihedral < SHARP) + SHORT_EDGE * (edge.length < SHORT * size)
    if sweeps:
        return total
    total += BLOCKED + DIRECTION * max(0, _ways_of_holes(solid) - 1)
    for edge in solid.edges:
        if edge.dihedral > pi + flat:
            total += REENTRANT
        elif edge.dihedral > pi - flat:
            total += IMPRINT
    return total
