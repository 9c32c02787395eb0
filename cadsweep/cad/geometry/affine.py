"""Curves carried by an affine map: moved in space, or dropped on a plane's own coordinates.

Place in the flow: what is made of curves that were read already needs no second reading from OpenCASCADE.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...arrays import FloatArray
from .nurbs import BSpline
from .parametric import Called, Ellipse, Hyperbola, Line, Parabola, Parametric, Periodic, Reparametrised


def carried(curve: Parametric, linear: FloatArray, offset: FloatArray) -> Parametric:  # noqa: PLR0911
    """The curve ``linear @ curve(t) + offset``, in the same parameter.

    Parameters
    ----------
    curve : Parametric
        In k dimensions.
    linear : (d, k) float64
    offset : (d,) float64

    Examples
    --------
    >>> import numpy as np
    >>> line = Line(origin=np.array([1.0, 2.0, 3.0]), direction=np.array([0.0, 0.0, 2.0]))
    >>> carried(line, np.eye(3), np.array([0.0, 0.0, 1.0])).derivatives(np.array([1.0]))[0].tolist()
    [[1.0, 2.0, 6.0]]
    """
    match curve:
        case Line():
            return Line(origin=linear @ curve.origin + offset, direction=linear @ curve.direction)
        case Ellipse() | Hyperbola():
            return type(curve)(
                center=linear @ curve.center + offset, x_axis=linear @ curve.x_axis, y_axis=linear @ curve.y_axis
            )
        case Parabola():
            return Parabola(
                vertex=linear @ curve.vertex + offset, x_axis=linear @ curve.x_axis, y_axis=linear @ curve.y_axis
            )
        case BSpline():
            return replace(curve, poles=curve.poles @ linear.T + offset)
        case Periodic():
            return replace(curve, spline=replace(curve.spline, poles=curve.spline.poles @ linear.T + offset))
        case Reparametrised():
            return replace(curve, curve=carried(curve.curve, linear, offset))

    def call(parameter: float, order: int) -> tuple[tuple[float, ...], ...]:
        rows = [values[0] @ linear.T for values in curve.derivatives(np.array([parameter]), order)]
        rows[0] = rows[0] + offset
        return tuple(tuple(row.tolist()) for row in rows)

    return Called(function=call)


__all__ = ["carried"]
