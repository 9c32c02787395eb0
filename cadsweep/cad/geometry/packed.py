"""Numbers of OpenCASCADE's curves and splines, read at once from its binary form.

Place in the flow: ``convert`` calls these. Asking for one pole after the other costs some microseconds each, and a gear
has a hundred thousand; OpenCASCADE writes all curves of a part, or a whole surface, in one call.

Format (``BinTools``, fixed by the files that it has to read back; little-endian): after a line of text that ends the
header come, of each, the kind (1 byte), and then: of a line its place and direction; of a circle or ellipse its
centre, in space the normal, both directions, and one or two radii; of a spline rational and periodic (1 byte each; per
direction on a surface), degrees (int16), numbers of poles and knots (int32), the poles with their weights where
rational, and each knot with its multiplicity (int32).
"""

from __future__ import annotations

import io
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from OCP.BinTools import BinTools_Curve2dSet, BinTools_CurveSet, BinTools_SurfaceSet

from ...arrays import FloatArray

LINE, CIRCLE, ELLIPSE = 1, 2, 3
_SPLINE_CURVE = 7
_SPLINE_SURFACE = 9
_SPLINE_HEAD = struct.Struct("<B??hii")
_N_RADII = {LINE: 0, CIRCLE: 1, ELLIPSE: 2}
_KNOT = np.dtype([("value", "<f8"), ("times", "<i4")])


class PackedConic(NamedTuple):
    """A line's place and direction, or a circle's or an ellipse's centre and directions of both axes, and radii."""

    kind: int
    vectors: FloatArray
    radii: tuple[float, ...]


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


def unpack_curves(curves: Sequence[Any], dimension: int) -> tuple[list[PackedConic | PackedCurve], list[int]]:
    """Read lines, circles, ellipses and splines that are not periodic, in space or (`dimension` 2) in the plane.

    Returns the distinct ones, and which of them each curve is: edges and faces may share one.
    """
    collection = BinTools_CurveSet() if dimension == 3 else BinTools_Curve2dSet()
    numbers = [collection.Add(curve) - 1 for curve in curves]
    data = _written(collection)
    found: list[PackedConic | PackedCurve] = []
    at = 0
    while at < len(data):
        read = _spline_at if data[at] == _SPLINE_CURVE else _conic_at
        packed, at = read(data, at, dimension)
        found.append(packed)
    return found, numbers


def _conic_at(data: bytes, at: int, dimension: int) -> tuple[PackedConic, int]:
    kind = data[at]
    n_vectors = 2 if kind == LINE else 1 + dimension
    n = n_vectors * dimension
    values = np.frombuffer(data, "<f8", n + _N_RADII[kind], at + 1)
    vectors = values[:n].reshape(n_vectors, dimension)
    if kind != LINE and dimension == 3:
        vectors = vectors[[0, 2, 3]]  # without the normal
    return PackedConic(kind, vectors.copy(), tuple(values[n:].tolist())), at + 1 + values.nbytes


def _spline_at(data: bytes, at: int, dimension: int) -> tuple[PackedCurve, int]:
    _, rational, _, degree, n_poles, n_knots = _SPLINE_HEAD.unpack_from(data, at)
    width = dimension + rational
    at += _SPLINE_HEAD.size
    poles = np.frombuffer(data, "<f8", n_poles * width, at).reshape(n_poles, width)
    at += poles.nbytes
    weights = poles[:, dimension].copy() if rational else None
    curve = PackedCurve(degree, _knots(data, n_knots, at), poles[:, :dimension].copy(), weights)
    return curve, at + n_knots * _KNOT.itemsize


def unpack_surface(spline: Any) -> PackedSurface:
    """Read a ``Geom_BSplineSurface`` that is not periodic."""
    collection = BinTools_SurfaceSet()
    collection.Add(spline)
    data = _written(collection)
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


def _written(collection: Any) -> bytes:
    stream = io.BytesIO()
    collection.Write(stream)
    return stream.getvalue().split(b"\n", 1)[1]


def _knots(data: bytes, n: int, start: int) -> FloatArray:
    knots = np.frombuffer(data, _KNOT, n, start)
    return np.repeat(knots["value"], knots["times"])
