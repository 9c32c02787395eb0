"""Outlines of floors and of bosses that run tangent into a rounding, moved half way up it.

Place in the flow: :mod:`.cushions` are laid under what comes of it. At the edge of the plane face itself nothing can
end: what is parted there along the plane meets the rounding at no angle at all. Half way up both meet at 45 degrees::

      |                             |
      |                             |
       \\                            |
        `-.______  floor      ______/...   what stands on a plate
    .....\\ 45 degrees        ,-'
                         ---'

Method: lines and arcs of the outline move aside, away from the middle of a floor and towards that of a boss, by what
a rounding of that radius has turned aside when it stands at 45 degrees.

Not handled: outlines that are rounded in part, roundings of several radii, and corners that stay sharp.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos, pi

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Torus

from ...arrays import FloatArray
from ...brep import Curve, Solid
from ..geometry.curves import EdgeCurve
from ..geometry.parametric import Ellipse, Line, Parametric
from ..shapes import shapes_of
from .axial import hollow_beside, round_axis
from .circles import Piece, Rim

_ASIDE = cos(pi / 4)
"""How far a rounding has moved aside half way up, in its radius."""
_LEAST = 0.3
"""Radius of what is moved towards its middle, in that of the outline, at least."""
_CORNER = 0.2
"""Radians by which an outline turns at a corner, at least."""
_ALIKE = 1e-6
"""Share of its radius by which another rounding's may differ."""
_PLACES = np.linspace(0.0, 1.0, 5)
_RADIUS = {
    GeomAbs_Cylinder: lambda adaptor: adaptor.Cylinder().Radius(),
    GeomAbs_Torus: lambda adaptor: adaptor.Torus().MinorRadius(),
}


@dataclass(frozen=True, kw_only=True, eq=False)
class _Moved:
    """A line or an arc beside an edge."""

    kind: str
    length: float
    curve: Curve


def half_way(solid: Solid, rim: Rim, flat: float) -> Rim | None:
    """An outline at which cells can end: itself, or half way up the rounding that the face goes on into there.

    Parameters
    ----------
    solid : Solid
    rim : Rim
    flat : float
        Radians from pi up to which two faces at an edge are one surface.

    Returns
    -------
    Rim or None
        None where the face goes on into what is no such rounding, or into one in part only.
    """
    if all(abs(solid.edges[e].dihedral - pi) > flat for e in rim.border):
        return rim
    found = [_rounding(solid, rim, e, flat) for e in rim.border]
    radii = [radius for radius in found if radius is not None]
    if len(radii) < len(found) or np.ptp(radii) > _ALIKE * max(map(abs, radii)):
        return None
    up, aside = (1.0 - _ASIDE) * abs(radii[0]), _ASIDE * radii[0]
    if rim.radius + aside < _LEAST * rim.radius:
        return None
    inner, outer = (-up, 0.0) if aside > 0.0 else (0.0, -up)
    center = rim.center + up * rim.normal
    moved = replace(rim, center=center, radius=rim.radius + aside, inner=inner, outer=outer)
    arm = rim.start - rim.center
    arm /= np.linalg.norm(arm)
    if not rim.edges:
        return replace(moved, start=moved.center + moved.radius * arm, length=2.0 * pi * moved.radius)
    pieces = list(_pieces(solid, rim, aside, up))
    if None in pieces:
        return None
    edges = tuple((piece, True) for piece in pieces if piece is not None)
    start = edges[0][0].curve.evaluate(np.zeros(1))[0]
    return replace(moved, start=start, length=sum(piece.length for piece, _ in edges), edges=edges)


def _rounding(solid: Solid, rim: Rim, e: int, flat: float) -> float | None:
    """Radius of the rounding that a face goes on into, below zero where it leans to the middle; None for another."""
    beside = hollow_beside(solid, rim.face, e, flat)
    if not beside:
        return None
    face, edge = solid.faces[beside[0]], solid.edges[e]
    adaptor = BRepAdaptor_Surface(shapes_of(solid).faces[face.id])
    read = _RADIUS.get(adaptor.GetType())
    if read is None:
        return None
    radius = float(read(adaptor))
    points = np.concatenate([solid.edges[k].curve.evaluate(_PLACES) for k in face.edges])
    heights = (points - edge.midpoint) @ rim.normal
    if float(heights.max()) < 1.5 * (1.0 - _ASIDE) * radius:
        return None  # it ends before it is half way up
    upper = points[heights > 0.5 * heights.max()]
    if adaptor.GetType() == GeomAbs_Cylinder:
        out = np.cross(edge.tangents[0], rim.normal)
        out *= np.sign(out @ (edge.midpoint - rim.center))
        aside = float(((upper - edge.midpoint) @ out).mean())
    else:
        axis = round_axis(shapes_of(solid).faces[face.id])
        assert axis is not None, "a torus has one"
        place, along = axis
        far = np.linalg.norm(np.cross([edge.midpoint, *upper] - place, along), axis=1)
        aside = float((far[1:] - far[0]).mean())
    return float(np.sign(aside)) * radius


def _pieces(solid: Solid, rim: Rim, aside: float, up: float) -> Iterator[Piece | None]:
    """The pieces of an outline moved, and arcs around its corners; None for a corner that stays sharp."""
    at = np.array([0.0, 0.5, 1.0])
    rows = [edge.curve.evaluate(at if forward else at[::-1]) for edge, forward in rim.edges]
    ways = [_ends(row, rim.normal) for row in rows]
    for k, (row, (begin, end)) in enumerate(zip(rows, ways, strict=True)):
        before = ways[k - 1][1]
        if np.arccos(np.clip(before @ begin, -1.0, 1.0)) > _CORNER:
            is_round = aside > 0.0 and _has_ball(solid, row[0])
            about = np.cross([before, begin], rim.normal)
            yield _arc(row[0] + up * rim.normal, rim.normal, aside, about) if is_round else None
        out = np.array([np.cross(way, rim.normal) for way in (begin, end)])
        if rim.edges[k][0].kind == "line":
            ends = row[[0, 2]] + aside * out + up * rim.normal
            yield _line(*ends)
            continue
        center = _center(row, out)
        radius = float(np.linalg.norm(row[0] - center)) + aside
        if radius > _ALIKE * solid.size:
            yield _arc(center + up * rim.normal, rim.normal, radius, out)


def _ends(row: FloatArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit tangents at both ends of a line or an arc through three points."""
    begin, end = row[1] - row[0], row[2] - row[1]
    whole = row[2] - row[0]
    # A chord and the tangents at its ends are as far apart as the chord of its half from the chord.
    begin, end, whole = (way / np.linalg.norm(way) for way in (begin, end, whole))
    return _mirrored(whole, begin, normal), _mirrored(whole, end, normal)


def _mirrored(way: FloatArray, about: FloatArray, normal: FloatArray) -> FloatArray:
    """A direction mirrored about another, in the plane of both."""
    across = np.cross(normal, about)
    found: FloatArray = way - 2.0 * (way @ across) * across
    return found


def _center(row: FloatArray, out: FloatArray) -> FloatArray:
    """Centre of an arc from the directions (2, 3) outwards at its ends."""
    chord = row[2] - row[0]
    radius = float(chord @ (out[1] - out[0])) / float((out[1] - out[0]) @ (out[1] - out[0]))
    center: FloatArray = row[0] - radius * out[0]
    return center


def _has_ball(solid: Solid, corner: FloatArray) -> bool:
    """Whether a ball rises from a corner of an outline."""
    near = _ALIKE * solid.size
    ends = {v for v, place in enumerate(solid.vertices) if float(np.linalg.norm(place - corner)) < near}
    balls = (face for face in solid.faces if face.kind == "sphere")
    return any(ends & {solid.edges[e].start, solid.edges[e].end} for face in balls for e in face.edges)


def _line(begin: FloatArray, end: FloatArray) -> Piece:
    length = float(np.linalg.norm(end - begin))
    return _moved("line", Line(origin=begin, direction=(end - begin) / length), length, 1.0)


def _arc(center: FloatArray, normal: FloatArray, radius: float, out: FloatArray) -> Piece:
    """The arc from one direction outwards counterclockwise to another."""
    begin, end = out
    turn = float(np.arctan2(np.cross(begin, end) @ normal, begin @ end)) % (2.0 * pi)
    geometry = Ellipse(center=center, x_axis=radius * begin, y_axis=radius * np.cross(normal, begin))
    return _moved("circle", geometry, turn, radius)


def _moved(kind: str, geometry: Parametric, last: float, speed: float) -> Piece:
    curve = EdgeCurve(geometry=geometry, first=0.0, last=last, constant_speed=True)
    return _Moved(kind=kind, length=speed * last, curve=curve)


__all__ = ["half_way"]
