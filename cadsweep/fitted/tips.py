"""Tips of faces: vertices where two edges of a face leave side by side, so that no quad fits between them.

The mesh ends such a face before its tip, where its edges are apart enough for a quad: the node of the vertex goes back
along one of them, and the other begins there, too. What of both is beyond has no lines of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import radians
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid, Surface

_NARROW = radians(15.0)
"""Angle below which a corner of a face is a tip: the best quad there is hardly good enough."""
_ROOM = 0.15
"""How far the edges are apart where the face ends, over the size: about what strips and bridges leave."""
_FARTHEST = 0.5
"""Share of an edge that its end goes back, about at most."""
_SAMPLES = 201
"""Places on an edge at which it is looked how far the other is."""


class Tip(NamedTuple):
    """A face that ends before its tip.

    Attributes
    ----------
    vertex, face : int
    place : (3,) float64
        Where the node of the vertex goes.
    fractions : dict of int to float
        The edges that leave side by side, and where on each its end is then.
    others : tuple of int
        Faces of the vertex that do not come to that place.
    """

    vertex: int
    face: int
    place: FloatArray
    fractions: dict[int, float]
    others: tuple[int, ...]


def find_tips(solid: Solid, angles: Mapping[tuple[int, int], float], size: float) -> list[Tip]:
    """Tips of the faces of a solid, at most one a vertex, from the `angles` of its (vertex, face)."""
    found: dict[int, Tip] = {}
    for (vertex, face), angle in sorted(angles.items(), key=lambda item: item[1]):
        own = [e for e in solid.faces[face].edges if vertex in (solid.edges[e].start, solid.edges[e].end)]
        if angle < _NARROW and len(set(own)) == 2 and vertex not in found:
            edge, other = sorted(set(own), key=lambda e: (-solid.edges[e].length, e))
            found[vertex] = _ended(solid, vertex, face, edge, other, _ROOM * size)
    return list(found.values())


def _ended(solid: Solid, vertex: int, face: int, edge: int, other: int, room: float) -> Tip:  # noqa: PLR0917
    along, beside = solid.edges[edge], solid.edges[other]
    shares = np.linspace(0.0, _FARTHEST, _SAMPLES)
    fractions = shares if along.start == vertex else 1.0 - shares
    places = along.curve.evaluate(fractions)
    others = beside.curve.project(places)
    back = np.abs(others - (0.0 if beside.start == vertex else 1.0))
    apart = np.linalg.norm(beside.curve.evaluate(others) - places, axis=1)
    at = int(np.argmax((apart > room) | (back > _FARTHEST) | (shares == _FARTHEST)))
    here = {f for e in solid.edges if vertex in (e.start, e.end) for f in e.faces}
    return Tip(
        vertex=vertex,
        face=face,
        place=places[at],
        fractions={edge: float(fractions[at]), other: float(others[at])},
        others=tuple(sorted(here - set(along.faces))),
    )


def end_before(solid: Solid, tips: Sequence[Tip]) -> Solid:
    """The solid with the vertices of tips where these end, on all the faces that had them."""
    faces, vertices = list(solid.faces), solid.vertices.copy()
    for tip in tips:
        vertices[tip.vertex] = tip.place
        for face in tip.others:
            faces[face] = replace(faces[face], surface=_Reaching(faces[face].surface, tip.place))
    return replace(solid, faces=tuple(faces), vertices=vertices)


class _Reaching:
    """A surface that a place beside it belongs to, the tip of the face between having gone."""

    def __init__(self, surface: Surface, place: FloatArray) -> None:
        self.surface, self.place = surface, place
        self.evaluate, self.derivatives, self.normals = surface.evaluate, surface.derivatives, surface.normals
        self.project, self.edge_uv = surface.project, surface.edge_uv

    @property
    def periods(self) -> tuple[float | None, float | None]:
        return self.surface.periods

    def distance(self, points: FloatArray, *, close: float = -1.0) -> FloatArray:
        ways = {} if close < 0.0 else {"close": close}
        away = self.surface.distance(points, **ways)
        return np.minimum(away, np.linalg.norm(points - self.place, axis=1))


__all__ = ["Tip", "end_before", "find_tips"]
