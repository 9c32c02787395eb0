"""Working units: a part is scaled by a power of two, and shifted, only where OpenCASCADE or gmsh need it.

Place in the flow: after healing, before dividing. OpenCASCADE's tolerances are absolute (1e-7), so
that a part must be of a size of some units and lie near the origin. ``Part.to_model`` undoes both;
a power of two does it without rounding.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.gp import gp_Trsf, gp_Vec
from OCP.ShapeFix import ShapeFix_ShapeTolerance

from ...arrays import FloatArray
from ..shapes import SOLID, bounds, subshapes
from .tracing import Traced

SMALLEST, GREATEST = 1.0, 1e4
"""Sizes (diagonals of the bounding box) that are left alone."""

FARTHEST = 1e3
"""Distance from the origin, in sizes, up to which a part is left where it is."""


def normalise(traced: Traced) -> tuple[float, FloatArray, float]:
    """Scale and shift the shape in place where that is needed.

    Returns
    -------
    scale : float
        Old units per new unit, a power of two.
    offset : (3,) float64
        Old coordinates of the new origin.
    size : float
        Size of the part, new units.
    """
    box = bounds(traced.shape)
    size = float(np.linalg.norm(box[1] - box[0]))
    scale, offset, move = transform_to_working(traced.shape)
    if move is None:
        return scale, offset, size
    tool = BRepBuilderAPI_Transform(traced.shape, move, True)
    traced.replace(subshapes(tool.Shape(), SOLID)[0], tool.ModifiedShape)
    if scale > 1.0:
        # Tolerances shrink with the shape; OpenCASCADE expects none below its own 1e-7.
        ShapeFix_ShapeTolerance().LimitTolerance(traced.shape, 1e-7, 0.0)
    return scale, offset, size / scale


def transform_to_working(shape: Any) -> tuple[float, FloatArray, Any]:
    """How a shape is to be scaled and shifted.

    Returns
    -------
    scale : float
    offset : (3,) float64
        As for :func:`normalise`.
    move : gp_Trsf or None
        None where the shape can stay as it is.
    """
    box = bounds(shape)
    size = float(np.linalg.norm(box[1] - box[0]))
    scale = 1.0
    if not SMALLEST <= size <= GREATEST:
        scale = 2.0 ** round(math.log2(size / 64.0))
    offset = np.zeros(3)
    middle = box.mean(axis=0)
    if np.abs(middle).max() > FARTHEST * size:
        # Rounded to a whole number of sizes, so that short decimals stay short where they can.
        step = 2.0 ** math.floor(math.log2(size))
        offset = np.round(middle / step) * step
    if scale == 1.0 and not offset.any():
        return scale, offset, None
    shift, stretch = gp_Trsf(), gp_Trsf()
    shift.SetTranslation(gp_Vec(*(-offset)))
    stretch.SetScaleFactor(1.0 / scale)
    return scale, offset, stretch.Multiplied(shift)
