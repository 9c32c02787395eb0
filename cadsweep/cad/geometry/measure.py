"""Area, centroid and volume share of a face, by quadrature on its own surface and parameter curves.

Place in the flow: called by ``extract`` for faces on splines or bounded by splines; OpenCASCADE's own
integrals are exact for the others but were found up to one per cent off for these.

Method: Green's theorem in the parameters. With ``G(u, v)`` the integral of g over u from the
box's left side to u, the integral of g over the face is the line integral of ``G dv`` round its
loops. Both integrals are Gauss-Legendre sums on panels that respect the knots; the panels are halved
until sums of two orders agree, as the area of a flat ellipse's side needs many and most faces few.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from hashlib import blake2b
from typing import Any, NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS

from ...arrays import FloatArray
from ...brep import Loop
from ...sweep import DirectedEdge
from ..shapes import EDGE, explore, surface_range
from .convert import read_curve_2d, read_surface
from .curves import EdgeCurve
from .edge_on_face import EdgeOnFace
from .face_surface import FaceSurface
from .measure_kernels import boundary_sums
from .parametric import Parametric
from .surfaces import Cone, Geometry, Plane, Torus, knots_of
from .vectors import cross_rows


class _Rule(NamedTuple):
    """Gauss-Legendre nodes and weights on [0, 1], and the number of times each panel is divided."""

    nodes: FloatArray
    weights: FloatArray
    n_parts: int

    @property
    def compiled(self) -> FloatArray:
        """Nodes and weights (2, k) in one array."""
        return np.stack([self.nodes, self.weights])


@lru_cache
def _rule(order: int, n_parts: int) -> _Rule:
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return _Rule((nodes + 1) / 2, weights / 2, n_parts)


_ORDERS = (6, 8)
"""Gauss orders that are compared: where 6 and 8 points agree, 8 are exact to rounding."""
_AGREE = 1e-6
"""Difference of the two orders' areas, as a share, that ends the halving; the higher order is far better."""
_MOST_PARTS = 16
"""Pieces of an interval beyond which a surface is not smooth enough for our integrals."""
_MOST_POINTS = 500_000
"""Points of the surface for one sum, beyond which panels are not halved again."""
_PANELS = 4
"""Panels in each direction of a surface without knots, before any is halved."""
_ELEMENTARY_PANELS = 2
"""The same for planes, cones and tori, whose integrands are polynomials and single waves."""
_MOST_PANELS = 48
"""Spans of a spline up to which each is a panel; more are gathered."""
_MOST_KNOWN = 50_000
"""Faces whose sums are kept: a solid that is changed is read anew, and most of its faces are as they were."""

_sums_of: dict[bytes, FloatArray] = {}


class Measure(NamedTuple):
    """Area of a face, its centroid (3,), its share of the solid's volume, and its vector area (3,).

    The share of the volume is a third of the integral of ``x . n``; the vector areas of a closed
    surface, the integrals of n, add up to nothing.
    """

    area: float
    center: FloatArray
    volume: float
    vector: FloatArray


def measure_face(surface: FaceSurface, loops: Sequence[Loop]) -> Measure | None:
    """Integrate over a face; None where an edge has no curve in the parameters."""
    directed = [list(loop.directed) for loop in loops]
    origin = surface.geometry.evaluate(surface.box.mean(axis=0)[None])[0]
    totals = _compiled_sums(surface, directed, origin, close=True)
    if totals is None:
        totals = _general_sums(surface, directed, origin)
    if totals is None:
        return None
    # Loops run with the material on the left seen from outside, hence clockwise in the parameters where
    # these look inwards: that is one sign for area and moments, and two, which cancel, for the volume.
    area, moments, vector_area = totals[0] * surface.outward, totals[1:4] * surface.outward, totals[4:7]
    if not area > 0:
        return None
    volume = (totals[7] + vector_area @ origin) / 3.0
    return Measure(float(area), origin + moments / area, float(volume), vector_area)


def _general_sums(
    surface: FaceSurface, directed: Sequence[Sequence[DirectedEdge]], origin: FloatArray
) -> FloatArray | None:
    """Sums (8,) of the integrands over a face that has no records; None where an edge has no parameter curve."""
    if any(surface.curves[edge].in_parameters[0] is None for loop in directed for edge, _ in loop):
        return None

    def boundary(rule: _Rule) -> tuple[FloatArray, FloatArray]:
        places, steps = [], []
        for loop in directed:
            pieces = [_edge_samples(surface, edge, forward, rule) for edge, forward in loop]
            for piece, following in zip(pieces, pieces[1:] + pieces[:1], strict=True):
                # A degenerate edge (an apex, a pole) is in no loop: its line in the parameters is closed here.
                gap = following.start - piece.end
                places += [piece.uv, piece.end + rule.nodes[:, None] * gap]
                steps += [piece.dv, rule.weights * gap[1]]
        return np.concatenate(places), np.concatenate(steps)

    return _converged(surface, boundary, origin)


def _compiled_sums(
    surface: FaceSurface, directed: Sequence[Sequence[DirectedEdge]], origin: FloatArray, *, close: bool
) -> FloatArray | None:
    """The same by compiled loops; None where the surface or an edge has no record.

    Where `close` is set, gaps between the edges in the parameters are bridged.
    """
    record, edges = surface.record, surface.edge_records
    if record is None or edges is None:
        return None
    uses = [(number, edge, forward) for number, loop in enumerate(directed) for edge, forward in loop]
    curves = [surface.curves[edge].curve for _, edge, _ in uses]
    rows = np.array([edges.row[edge] for _, edge, _ in uses])
    limits = np.array([(curve.first, curve.last) for curve in curves])
    senses = np.array([1.0 if forward else -1.0 for _, _, forward in uses])
    directed_edges = edges.values, edges.starts[rows], np.column_stack([limits, edges.shifts[rows]]), senses
    on_surface = record, _panels(surface, 1), origin
    loops = np.array([number for number, _, _ in uses])
    stops = [_stops(curve) for curve in curves]
    first_stops, all_stops = np.cumsum([0] + [len(own) for own in stops]), np.concatenate(stops)
    n_least = _panels_across(surface)
    told = [*on_surface, *directed_edges, loops, first_stops, all_stops, np.array([close])]
    key = blake2b(b"".join(np.ascontiguousarray(values).tobytes() for values in told)).digest()
    if key in _sums_of:
        return _sums_of[key]

    def sums(order: int, n_parts: int) -> tuple[FloatArray, int]:
        rule = _rule(order, 1)
        totals = np.empty(8)
        n_points = boundary_sums(
            on_surface, rule.compiled, n_parts, n_least, directed_edges, loops, all_stops, first_stops, close, totals
        )
        return totals, n_points

    if len(_sums_of) >= _MOST_KNOWN:
        _sums_of.clear()
    _sums_of[key] = _agreed(sums)
    return _sums_of[key]


def _stops(curve: EdgeCurve) -> FloatArray:
    """Parameters between which an edge is smooth, its ends among them."""
    inner = curve.breaks[(curve.breaks > curve.first) & (curve.breaks < curve.last)]
    return np.concatenate([[curve.first], inner, [curve.last]])


def measure_closed_area(face: Any) -> float | None:
    """Area of an OpenCASCADE face that may be closed upon itself; None where an edge has no parameter curve."""
    surface = BRep_Tool.Surface_s(face)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    box = np.array([[u0, v0], [u1, v1]])
    geometry = read_surface(surface)
    forward_face = TopoDS.Face_s(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
    curves: dict[int, EdgeOnFace] = {}
    senses = []
    # A seam is met twice, each time with the parameter curve of its side.
    for number, edge in enumerate(explore(forward_face, EDGE)):
        curve = BRep_Tool.CurveOnSurface_s(edge, forward_face, 0.0, 1.0)
        if curve is None:
            return None
        first, last = surface_range(edge, forward_face)
        known = read_curve_2d(curve)
        in_space = EdgeCurve(
            geometry=known, first=first, last=last, breaks=getattr(known, "breaks", np.empty(0)), constant_speed=False
        )
        middle = known.derivatives(np.array([(first + last) / 2.0]))[0][0]
        shift = np.zeros(2)
        for j, period in enumerate(geometry.periods):
            if period is not None:
                # The two sides of a seam lie half a period off the middle and stay there.
                off = (middle[j] - box[:, j].mean()) / period
                shift[j] = -period * np.sign(off) * max(0.0, np.ceil(abs(off) - 0.5 - 1e-6))
        curves[number] = EdgeOnFace(curve=in_space, read=partial(_known, known, shift))
        senses.append(edge.Orientation() == TopAbs_Orientation.TopAbs_FORWARD)
    bounded = FaceSurface(geometry=geometry, outward=1.0, box=box, limits=box, curves=curves)
    origin = geometry.evaluate(box.mean(axis=0)[None])[0]
    totals = _compiled_sums(bounded, [list(enumerate(senses))], origin, close=False)
    if totals is not None:
        return abs(float(totals[0]))

    def boundary(rule: _Rule) -> tuple[FloatArray, FloatArray]:
        pieces = [_edge_samples(bounded, number, forward, rule) for number, forward in enumerate(senses)]
        return np.concatenate([piece.uv for piece in pieces]), np.concatenate([piece.dv for piece in pieces])

    return abs(float(_converged(bounded, boundary, origin)[0]))


def _known(curve: Parametric, shift: FloatArray) -> tuple[Parametric, FloatArray]:
    return curve, shift


def _converged(
    surface: FaceSurface, boundary: Callable[[_Rule], tuple[FloatArray, FloatArray]], origin: FloatArray
) -> FloatArray:
    """Sums (8,) of the integrands over the face, on panels fine enough for the area."""

    def sums(order: int, n_parts: int) -> tuple[FloatArray, int]:
        rule = _rule(order, n_parts)
        uv, dv = boundary(rule)
        used = dv != 0
        n_points = int(used.sum()) * order * (len(_panels(surface, n_parts)) - 1)
        return dv[used] @ _inner(surface, uv[used], origin, rule), n_points

    return _agreed(sums)


def _agreed(sums: Callable[[int, int], tuple[FloatArray, int]]) -> FloatArray:
    """Sums (8,) of a Gauss order on panels in so many parts that a lower order agrees about the area.

    `sums` gives them for an order and a number of parts, and how many points of the surface it took.
    """
    n_parts = 1
    while True:
        (lower, _), (higher, n_points) = (sums(order, n_parts) for order in _ORDERS)
        agree = abs(higher[0] - lower[0]) <= _AGREE * abs(higher[0])
        # Halving doubles the samples of the boundary, and the panels to each of them.
        if agree or n_parts >= _MOST_PARTS or 4 * n_points > _MOST_POINTS:
            return higher
        n_parts *= 2


class _Piece(NamedTuple):
    """Gauss points on a directed edge, their weights times dv, and the parameters at its two ends."""

    uv: FloatArray
    dv: FloatArray
    start: FloatArray
    end: FloatArray


def _edge_samples(surface: FaceSurface, edge: int, forward: bool, rule: _Rule) -> _Piece:
    curve = surface.curves[edge].curve
    in_parameters, shift = surface.curves[edge].in_parameters
    assert in_parameters is not None
    stops = _stops(curve)
    parts = max(1, -(-_panels_across(surface) // (len(stops) - 1))) * rule.n_parts
    stops = np.interp(np.linspace(0, len(stops) - 1, parts * (len(stops) - 1) + 1), np.arange(len(stops)), stops)
    width = np.diff(stops)
    t = (stops[:-1, None] + width[:, None] * rule.nodes).ravel()
    weight = (width[:, None] * rule.weights).ravel()
    uv, slope = in_parameters.derivatives(t, 1)
    ends = in_parameters.derivatives(np.array([curve.first, curve.last]))[0] + shift
    sense = 1.0 if forward else -1.0
    start, end = (ends[0], ends[1]) if forward else (ends[1], ends[0])
    return _Piece(uv + shift, sense * weight * slope[:, 1], start, end)


def _inner(surface: FaceSurface, uv: FloatArray, origin: FloatArray, rule: _Rule) -> FloatArray:
    """Integrals (m, 8) over u, from the box's left side to each of `uv`, of the integrands."""
    stops = _panels(surface, rule.n_parts)
    # Beyond the last panel's end the parameters of an edge may run on by a rounding error.
    ends = np.append(stops[1:-1], np.inf)
    width = np.minimum(uv[:, :1], ends) - stops[:-1]
    some = width > 0
    some[:, 0] = True
    point, panel = np.nonzero(some)  # of each point the panels that lie before it, the first one always
    width = width[point, panel]
    at = np.empty((len(point), len(rule.nodes), 2))
    at[..., 0] = stops[panel, None] + width[:, None] * rule.nodes
    at[..., 1] = uv[point, None, 1]
    values = _integrands(surface, at.reshape(-1, 2), origin).reshape(*at.shape[:2], 8)
    sums = width[:, None] * np.einsum("mgk,g->mk", values, rule.weights)
    return np.asarray(np.add.reduceat(sums, np.flatnonzero(panel == 0), axis=0)) if len(uv) else np.zeros((0, 8))


def _integrands(surface: FaceSurface, uv: FloatArray, origin: FloatArray) -> FloatArray:
    points, by_u, by_v = surface.geometry.derivatives(uv)
    arm = points - origin
    normal = cross_rows(by_u, by_v)
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.concatenate([size, arm * size, normal, np.einsum("md,md->m", arm, normal)[:, None]], axis=1)


def _panels(surface: FaceSurface, n_parts: int) -> FloatArray:
    """Ends of the panels in u, each in `n_parts`: the knots where there are few, else even ones."""
    left, right = surface.box[:, 0]
    knots, _ = knots_of(surface.geometry)
    inner = knots[(knots > left) & (knots < right)]
    if 3 <= len(inner) <= _MOST_PANELS:
        stops = np.concatenate([[left], inner, [right]])
    else:
        n = _n_panels(surface.geometry) if len(inner) < 3 else _MOST_PANELS
        stops = np.unique(np.concatenate([np.linspace(left, right, n + 1), inner if len(inner) < 3 else np.empty(0)]))
    n = len(stops) - 1
    return np.interp(np.linspace(0, n, n * n_parts + 1), np.arange(n + 1), stops)


def _panels_across(surface: FaceSurface) -> int:
    """Panels of an edge at least: as many as the surface has spans beside it."""
    low, high = surface.box[:, 1]
    _, knots = knots_of(surface.geometry)
    n_spans = 1 + int(((knots > low) & (knots < high)).sum())
    return max(_n_panels(surface.geometry), min(n_spans, _MOST_PANELS))


def _n_panels(geometry: Geometry) -> int:
    return _ELEMENTARY_PANELS if isinstance(geometry, (Plane, Cone, Torus)) else _PANELS
