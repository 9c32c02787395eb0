"""Curves and surfaces evaluated from their records, as compiled loops.

Place in the flow: ``face_surface`` and the gaps of ``extract`` call these, :mod:`.feet_kernels` and
:mod:`.measure_kernels` build on them. The layout of the records is told in :mod:`.records`, what the formulas are by
:mod:`.curves` and :mod:`.surfaces`, which these loops are tested against.
"""

from __future__ import annotations

import numpy as np

from .records import CONE, ELLIPSE, EXTRUDED, HYPERBOLA, LINE, PARABOLA, PLANE, SPLINE_SURFACE, TORUS
from .spline_kernels import callee, functions, into_knots, kernel, surface_at

ROOM = (5, 32)
"""Numbers that an evaluation needs room for; OpenCASCADE's splines have a degree of 25 at most."""
_EXTRUDED_CURVE = 6
_REVOLVED_CURVE = 9


@callee
def curve_point(record, t, room, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Point and derivative ``out`` (2, 3) of a curve; the third number of one in the plane is 0."""
    kind, rate = int(record[0]), record[3]
    t = record[2] + rate * t
    if kind == LINE:
        for c in range(3):
            out[0, c] = record[4 + c] + t * record[7 + c]
            out[1, c] = record[7 + c]
    elif kind in (ELLIPSE, HYPERBOLA):
        first, second = (np.cos(t), np.sin(t)) if kind == ELLIPSE else (np.cosh(t), np.sinh(t))
        sign = -1.0 if kind == ELLIPSE else 1.0
        for c in range(3):
            out[0, c] = record[4 + c] + (first * record[7 + c] + second * record[10 + c])
            out[1, c] = first * record[10 + c] + sign * second * record[7 + c]
    elif kind == PARABOLA:
        for c in range(3):
            out[0, c] = record[4 + c] + t * t * record[7 + c] + t * record[10 + c]
            out[1, c] = 2.0 * t * record[7 + c] + record[10 + c]
    else:
        _spline_point(record, t, room, out)
    for c in range(3):
        out[1, c] *= rate


@callee
def _spline_point(record, t, room, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    d, degree, n, width = int(record[1]), int(record[4]), int(record[5]), int(record[6])
    knots = record[8 : 8 + n + degree + 1]
    poles = 8 + n + degree + 1
    t, span = into_knots(knots, degree, n, record[7], t)
    f0, f1, h0, h1 = room[0], room[1], room[2], room[3]
    functions(knots, degree, span, t, f0, f1)
    for c in range(width):
        h0[c] = h1[c] = 0.0
        for j in range(degree + 1):
            pole = record[poles + (span - degree + j) * width + c]
            h0[c] += f0[j] * pole
            h1[c] += f1[j] * pole
    out[0, 2] = out[1, 2] = 0.0
    for c in range(d):
        if width == d:
            out[0, c], out[1, c] = h0[c], h1[c]
        else:
            out[0, c] = h0[c] / h0[d]
            out[1, c] = (h1[c] - h1[d] * out[0, c]) / h0[d]


@callee
def surface_point(record, u, v, room, h, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Point and derivatives by u and v ``out`` (3, 3) of a surface; room for the loops in `room` and `h` (3, 4)."""
    kind = int(record[0])
    if kind == SPLINE_SURFACE:
        p, q, n_u, n_v = int(record[3]), int(record[4]), int(record[5]), int(record[6])
        v_first = 7 + n_u + p + 1
        poles = v_first + n_v + q + 1
        surface_at(
            record[7:v_first], record[v_first:poles], p, q, record[poles:].reshape(n_u, n_v, 4), record[1:3],
            u, v, room, h,
        )  # fmt: skip
        _quotient(h, out)
    elif kind == PLANE:
        for c in range(3):
            out[0, c] = record[3 + c] + u * record[6 + c] + v * record[9 + c]
            out[1, c], out[2, c] = record[6 + c], record[9 + c]
    elif kind in (CONE, TORUS):
        cos, sin = np.cos(u), np.sin(u)
        a, b = record[15], record[16]
        if kind == CONE:
            along, across = np.cos(b), np.sin(b)
            r, height = a + v * across, v * along
        else:
            along, across = b * np.cos(v), -b * np.sin(v)
            r, height = a + along, -across
        for c in range(3):
            radial = cos * record[6 + c] + sin * record[9 + c]
            turned = cos * record[9 + c] - sin * record[6 + c]
            out[0, c] = record[3 + c] + r * radial + height * record[12 + c]
            out[1, c] = r * turned
            out[2, c] = across * radial + along * record[12 + c]
    elif kind == EXTRUDED:
        curve_point(record[_EXTRUDED_CURVE:], u, room, out)
        for c in range(3):
            out[0, c] += v * record[3 + c]
            out[2, c] = record[3 + c]
    else:
        curve_point(record[_REVOLVED_CURVE:], v, room, out)
        cos, sin = np.cos(u), np.sin(u)
        for c in range(3):
            out[0, c] -= record[3 + c]
            out[2, c] = out[1, c]
        _turn(out[0], record[6:9], cos, sin)
        _turn(out[2], record[6:9], cos, sin)
        out[1, 0] = record[7] * out[0, 2] - record[8] * out[0, 1]
        out[1, 1] = record[8] * out[0, 0] - record[6] * out[0, 2]
        out[1, 2] = record[6] * out[0, 1] - record[7] * out[0, 0]
        for c in range(3):
            out[0, c] += record[3 + c]


@callee
def row_room(record):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Room for :func:`surface_row`."""
    return np.empty((2, int(record[5]) if int(record[0]) == SPLINE_SURFACE else 0, 4))


@callee
def surface_row(record, v, room, row):  # type: ignore[no-untyped-def]  # pragma: no cover
    """What all points of a surface with one v share: of a spline the poles of that line, and their derivatives by v."""
    if int(record[0]) != SPLINE_SURFACE:
        return
    p, q, n_u, n_v = int(record[3]), int(record[4]), int(record[5]), int(record[6])
    v_first = 7 + n_u + p + 1
    poles = v_first + n_v + q + 1
    knots = record[v_first:poles]
    s, span = into_knots(knots, q, n_v, record[2], v)
    in_v, by_v = room[2], room[3]
    functions(knots, q, span, s, in_v, by_v)
    for k in range(n_u):
        first = poles + (k * n_v + span - q) * 4
        for c in range(4):
            point = slope = 0.0
            for n in range(q + 1):
                pole = record[first + 4 * n + c]
                point += in_v[n] * pole
                slope += by_v[n] * pole
            row[0, k, c], row[1, k, c] = point, slope


@callee
def row_point(record, row, u, v, room, h, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """:func:`surface_point` on the line of a surface that :func:`surface_row` has made `row` of."""
    if int(record[0]) != SPLINE_SURFACE:
        surface_point(record, u, v, room, h, out)
        return
    p, n_u = int(record[3]), int(record[5])
    knots = record[7 : 7 + n_u + p + 1]
    t, span = into_knots(knots, p, n_u, record[1], u)
    in_u, by_u = room[0], room[1]
    functions(knots, p, span, t, in_u, by_u)
    for c in range(4):
        point = along_u = along_v = 0.0
        for k in range(p + 1):
            pole = row[0, span - p + k, c]
            point += in_u[k] * pole
            along_u += by_u[k] * pole
            along_v += in_u[k] * row[1, span - p + k, c]
        h[0, c], h[1, c], h[2, c] = point, along_u, along_v
    _quotient(h, out)


@callee
def _quotient(h, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Point and derivatives (3, 3) from homogeneous ones (3, 4)."""
    for c in range(3):
        out[0, c] = h[0, c] / h[0, 3]
        out[1, c] = (h[1, c] - h[1, 3] * out[0, c]) / h[0, 3]
        out[2, c] = (h[2, c] - h[2, 3] * out[0, c]) / h[0, 3]


@callee
def _turn(vector, axis, cos, sin):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Turn a vector (3,) about a unit axis, in place."""
    x, y, z = vector[0], vector[1], vector[2]
    along = x * axis[0] + y * axis[1] + z * axis[2]
    vector[0] = along * axis[0] + cos * (x - along * axis[0]) + sin * (axis[1] * z - axis[2] * y)
    vector[1] = along * axis[1] + cos * (y - along * axis[1]) + sin * (axis[2] * x - axis[0] * z)
    vector[2] = along * axis[2] + cos * (z - along * axis[2]) + sin * (axis[0] * y - axis[1] * x)


@kernel
def surface_points(record, uv, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Points, or also derivatives by u and v, ``out`` (1 or 3, m, 3)."""
    room, h, found = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3))
    for m in range(uv.shape[0]):
        surface_point(record, uv[m, 0], uv[m, 1], room, h, found)
        for k in range(out.shape[0]):
            for c in range(3):
                out[k, m, c] = found[k, c]


@callee
def cross_and_norms(found, cross):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Cross product of the partial derivatives, its length, and the lengths of both."""
    cross[0] = found[1, 1] * found[2, 2] - found[1, 2] * found[2, 1]
    cross[1] = found[1, 2] * found[2, 0] - found[1, 0] * found[2, 2]
    cross[2] = found[1, 0] * found[2, 1] - found[1, 1] * found[2, 0]
    norm = np.sqrt(cross[0] ** 2 + cross[1] ** 2 + cross[2] ** 2)
    by_u = np.sqrt(found[1, 0] ** 2 + found[1, 1] ** 2 + found[1, 2] ** 2)
    by_v = np.sqrt(found[2, 0] ** 2 + found[2, 1] ** 2 + found[2, 2] ** 2)
    return norm, by_u, by_v


@kernel
def surface_normals(record, outward, box, uv, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Unit normals ``out`` (m, 3), turned by `outward`; at a singular point that of a point nearby, inside the box."""
    room, h, found, cross = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3)), np.empty(3)
    kind = int(record[0])
    if kind in (CONE, TORUS):
        x, y, z = record[6:9], record[9:12], record[12:15]
        handed = (
            (x[1] * y[2] - x[2] * y[1]) * z[0] + (x[2] * y[0] - x[0] * y[2]) * z[1] + (x[0] * y[1] - x[1] * y[0]) * z[2]
        )
        a, b = record[15], record[16]
        for m in range(uv.shape[0]):
            cos, sin = np.cos(uv[m, 0]), np.sin(uv[m, 0])
            if kind == CONE:
                along, across = np.cos(b), -np.sin(b)
                inverted = a + uv[m, 1] * np.sin(b) < 0.0
            else:
                along, across = np.cos(uv[m, 1]), np.sin(uv[m, 1])
                inverted = a != 0.0 and a + b * along < 0.0
            side = outward * np.sign(handed) * (-1.0 if inverted else 1.0)
            for c in range(3):
                out[m, c] = side * (along * (cos * x[c] + sin * y[c]) + across * z[c])
        return
    lengths = np.empty((2, 25))
    for k in range(25):
        u = box[0, 0] + (k // 5) / 4 * (box[1, 0] - box[0, 0])
        v = box[0, 1] + (k % 5) / 4 * (box[1, 1] - box[0, 1])
        surface_point(record, u, v, room, h, found)
        _, lengths[0, k], lengths[1, k] = cross_and_norms(found, cross)
    scale = np.median(lengths[0]) * np.median(lengths[1])
    middle_u, middle_v = (box[0, 0] + box[1, 0]) / 2, (box[0, 1] + box[1, 1]) / 2
    for m in range(uv.shape[0]):
        for share in (0.0, 1e-6, 1e-4, 1e-2):
            u, v = uv[m, 0] + share * (middle_u - uv[m, 0]), uv[m, 1] + share * (middle_v - uv[m, 1])
            surface_point(record, u, v, room, h, found)
            norm, by_u, by_v = cross_and_norms(found, cross)
            for c in range(3):
                out[m, c] = outward * cross[c] / (norm if norm > 0.0 else 1.0)
            if norm > 1e-9 * max(by_u * by_v, scale):
                break


@kernel
def curve_points(records, starts, shifts, parameters, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Points ``out`` (n, m, d) of n curves at parameters (n, m), each with a shift (n, d); records begin at starts."""
    room, found = np.empty(ROOM), np.empty((2, 3))
    for j in range(parameters.shape[0]):
        record = records[starts[j] :]
        for m in range(parameters.shape[1]):
            curve_point(record, parameters[j, m], room, found)
            for c in range(out.shape[2]):
                out[j, m, c] = found[0, c] + shifts[j, c]


@kernel
def borders_apart(record, edges, lines, parameters, on_face, apart):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """How far n edges are from their lines on a surface at parameters (n, m), at most: ``apart`` (n,).

    `edges` are their records in space and where each begins, `lines` those in the parameters, where each begins, and
    their shifts (n, 2); ``on_face`` (n, m, 3) are the points of the lines on the surface.
    """
    in_space, space_starts = edges
    in_parameters, starts, shifts = lines
    room, h, found, curve = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3)), np.empty((2, 3))
    for j in range(parameters.shape[0]):
        greatest = 0.0
        for m in range(parameters.shape[1]):
            curve_point(in_parameters[starts[j] :], parameters[j, m], room, curve)
            surface_point(record, curve[0, 0] + shifts[j, 0], curve[0, 1] + shifts[j, 1], room, h, found)
            curve_point(in_space[space_starts[j] :], parameters[j, m], room, curve)
            squared = 0.0
            for c in range(3):
                on_face[j, m, c] = found[0, c]
                squared += (found[0, c] - curve[0, c]) ** 2
            if not squared <= greatest:
                greatest = squared
            if np.isnan(greatest):
                break
        apart[j] = np.sqrt(greatest)
