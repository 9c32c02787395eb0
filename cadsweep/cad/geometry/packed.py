"""Poles, weights and knots of OpenCASCADE's splines, read at once from its binary form.

Place in the flow: ``convert`` calls these. Asking for one pole after the other costs some microseconds each, and a gear
has a hundred thousand; OpenCASCADE writes a whole curve or surface in one call.

Format (``BinTools``, fixed by the files that it has to read back; little-endian): after a line of text that ends the
header come the kind (1 byte), rational and periodic (1 byte each; per direction on a surface), degrees (int16), numbers
of poles and knots (int32), the poles with their weights where rational, and each knot with its multiplicity (int32).
"""

from __future__ import annotations

import io
import struct
from typing import Any, NamedTuple

import numpy as np
from OCP.BinTools import BinTools_Curve2dSet, BinTools_CurveSet, BinTools_SurfaceSet

from ...arrays import FloatArray

_SPLINE_CURVE = 7
_SPLINE_SURFACE = 9
_KNOT = np.dtype([("value", "<f8"), ("times", "<i4")])


class PackedCurve(NamedTuple):
    """Degree, knots with repetitions, poles (n, d), and weights (n,) or None."""

    degree: int
    knots: FloatArray
    poles: FloatArray
    weights: FloatArray | None


class PackedSurface(NamedTuple):
    """Degrees and knots in u and v, poles (n_u, n_v, 3), and weights (n_u, n_v) or None."""

    degrees: tuple[int, int]
    u_knots: FloatArray
    v_knots: FloatArray
    poles: FloatArray
    weights: FloatArray | None


def unpack_curve(spline: Any, dimension: int) -> PackedCurve:
    """Read a ``Geom_BSplineCurve`` (`dimension` 3) or ``Geom2d_BSplineCurve`` (2) that is not periodic."""
    data = _written(BinTools_CurveSet() if dimension == 3 else BinTools_Curve2dSet(), spline)
    kind, rational, _, degree, n_poles, n_knots = struct.unpack_from("<B??hii", data)
    assert kind == _SPLINE_CURVE, "the caller hands a spline over"
    width = dimension + rational
    start = struct.calcsize("<B??hii")
    poles = np.frombuffer(data, "<f8", n_poles * width, start).reshape(n_poles, width)
    knots = _knots(data, n_knots, start + poles.nbytes)
    return PackedCurve(degree, knots, poles[:, :dimension].copy(), poles[:, dimension].copy() if rational else None)


def unpack_surface(spline: Any) -> PackedSurface:
    """Read a ``Geom_BSplineSurface`` that is not periodic."""
    data = _written(BinTools_SurfaceSet(), spline)
    form = "<B????hhiiii"
    kind, u_rational, v_rational, _, _, p, q, n_u, n_v, n_u_knots, n_v_knots = struct.unpack_from(form, data)
    assert kind == _SPLINE_SURFACE, "the caller hands a spline over"
    rational = u_rational or v_rational
    start = struct.calcsize(form)
    poles = np.frombuffer(data, "<f8", n_u * n_v * (3 + rational), start).reshape(n_u, n_v, 3 + rational)
    start += poles.nbytes
    u_knots = _knots(data, n_u_knots, start)
    v_knots = _knots(data, n_v_knots, start + n_u_knots * _KNOT.itemsize)
    return PackedSurface((p, q), u_knots, v_knots, poles[..., :3].copy(), poles[..., 3].copy() if rational else None)


def _written(collection: Any, geometry: Any) -> bytes:
    collection.Add(geometry)
    stream = io.BytesIO()
    collection.Write(stream)
    return stream.getvalue().split(b"\n", 1)[1]


def _knots(data: bytes, n: int, start: int) -> FloatArray:
    knots = np.frombuffer(data, _KNOT, n, start)
    return np.repeat(knots["value"], knots["times"])
