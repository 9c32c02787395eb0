"""Edges that imprinting leaves, too short to be meant: solids whose outlines nearly coincide.

Place in the flow: called by :mod:`.joining` on the finished cells; what it finds becomes notes. Two boxes in line, one
of them moved sideways by a hundredth of a millimetre, divide each other's faces so far from their edges, and the mesh
gets elements of that size there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from ...arrays import FloatArray
from ...brep import Part
from ..shapes import EDGE, subshapes
from .gaps import WIDEST

_AS_SHORT = 2.0
"""An edge that is not this much shorter than the shortest of its solid before is no doing of the imprint."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """A short edge of several cells: its length, its middle, and the cells."""

    length: float
    place: FloatArray
    cells: tuple[int, ...]


def find_steps(part: Part, shapes: Sequence[Any], size: float) -> list[Step]:
    """Find edges shorter than any gap that is meant, which the solids did not have before.

    Parameters
    ----------
    part : Part
        Imprinted.
    shapes : sequence of TopoDS_Solid
        Its cells as they were before.
    size : float
        Of the part, working units.
    """
    found: dict[int, Step] = {}
    for cell, (solid, shape) in enumerate(zip(part.solids, shapes, strict=True)):
        short = [edge for edge in solid.edges if edge.length < WIDEST * size]
        if not short:
            continue
        before = min(_length(edge) for edge in subshapes(shape, EDGE))
        for edge in short:
            if _AS_SHORT * edge.length < before:
                key = int(solid.edge_keys[edge.id])
                known = found.get(key)
                cells = (cell,) if known is None else (*known.cells, cell)
                found[key] = Step(length=edge.length, place=np.asarray(edge.midpoint), cells=cells)
    return sorted(found.values(), key=lambda step: step.length)


def _length(edge: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.LinearProperties_s(edge, properties)
    return float(properties.Mass())
