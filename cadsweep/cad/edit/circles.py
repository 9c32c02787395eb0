"""Outlines at which a solid is re-entrant, or that are imprinted on its plane faces: floors of holes, bosses.

Place in the flow: :mod:`.countersinks` and :mod:`.cushions` put cells under them.

Method: a whole circle is known by its centre and radius; any other outline counts where lines and arcs of it run
around its middle without a notch: round-ended slots, pockets with rounded corners, hexagons, triangles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from ...brep import Curve, Edge, Face, Solid
from .central import SAME

ROUND = 1e-3
"""Share of its radius by which points of a whole circle, its middle taken from 64 of each arc, may be off it."""

MOST_EDGES = 12
"""Edges of an outline that is no circle."""
LEAST_RIMS, MOST_ASKED = 4, 6000
"""Circles, and faces times circles, that cells are laid under: a search makes some dozens of cells, and to tell whether
there is material in a place, a hundred times a circle, takes as long as there are faces."""


class Piece(Protocol):
    """A line or an arc of an outline: an edge, or what lies beside one."""

    @property
    def kind(self) -> str: ...

    @property
    def length(self) -> float: ...

    @property
    def curve(self) -> Curve: ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Rim:
    """A whole circle, or another outline, on a plane face, the material on the other side of the face.

    Attributes
    ----------
    center, normal : (3,) float64
    radius : float
        Of an outline that is no circle: the least distance from its middle.
    start : (3,) float64
        A point of it.
    length : float
    face : Face
    border : tuple of int
        The edges of the face that it is made of.
    edges : tuple of (Piece, bool)
        Its pieces, one after the other counterclockwise about the normal, each with whether it runs that way; none
        for a circle.
    inner, outer : float
        How far above it the face is inside of it, and around it: one is below it where it lies half way up a rounding.
    """

    center: FloatArray
    normal: FloatArray
    radius: float
    start: FloatArray
    length: float
    face: Face
    border: tuple[int, ...]
    edges: tuple[tuple[Piece, bool], ...] = ()
    inner: float = 0.0
    outer: float = 0.0

    @property
    def around(self) -> FloatArray:
        """A point (3,) on its axis, as high as what is around it."""
        place: FloatArray = self.center + self.outer * self.normal
        return place

    @property
    def sunk(self) -> float:
        """How far below what is around it its inside is; none where it is above."""
        return max(0.0, self.outer - self.inner)

    def reach(self, directions: FloatArray) -> FloatArray:
        """How far it reaches (m,) along directions (m, 3), from its middle."""
        if not self.edges:
            return np.full(len(directions), self.radius)
        points = np.concatenate([edge.curve.evaluate(np.linspace(0.0, 1.0, 17)) for edge, _ in self.edges])
        found: FloatArray = ((points - self.center) @ np.transpose(directions)).max(axis=0)
        return found


def find_rims(solid: Solid, flat: float) -> list[Rim]:
    """The circles, the largest first; of a part of many faces no more than it is worth asking for material about.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    rims = sorted(_rims(solid, flat), key=lambda rim: -rim.radius)
    return rims[: max(LEAST_RIMS, MOST_ASKED // len(solid.faces))]


def find_outlines(solid: Solid, flat: float) -> list[Rim]:
    """The circles, and after them all other outlines that run around their middles without a notch."""
    return [*find_rims(solid, flat), *_outlines(solid, flat)]


def _outlines(solid: Solid, flat: float) -> Iterator[Rim]:
    for face in solid.faces:
        if face.kind != "plane":
            continue
        for number, loop in enumerate(face.loops):
            edges = [solid.edges[e] for e in loop.edges]
            kinds = {edge.kind for edge in edges}
            if kinds == {"circle"} or not kinds <= {"line", "circle"} or not 3 <= len(edges) <= MOST_EDGES:
                continue
            if any(edge.dihedral < pi - flat for edge in edges):
                continue
            directed = list(loop.directed)
            if number:  # the outline of a hole in a face runs the other way
                directed = [(e, not forward) for e, forward in reversed(directed)]
            points = np.concatenate([
                solid.edges[e].curve.evaluate(np.linspace(0.0, 1.0, 17) if forward else np.linspace(1.0, 0.0, 17))
                for e, forward in directed
            ])  # fmt: skip
            steps = np.roll(points, -1, axis=0) - points
            steps = steps[np.linalg.norm(steps, axis=1) > SAME * solid.size]
            # Convex: it turns to the left everywhere, and the middle is inside.
            turns = np.cross(steps, np.roll(steps, -1, axis=0)) @ face.normal
            if turns.min() < -SAME * solid.size**2:
                continue
            lengths = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
            center = np.average(0.5 * (points + np.roll(points, -1, axis=0)), axis=0, weights=lengths)
            yield Rim(
                center=center, normal=face.normal, radius=float(np.linalg.norm(points - center, axis=1).min()),
                start=points[0], length=float(lengths.sum()), face=face, border=loop.edges,
                edges=tuple((solid.edges[e], forward) for e, forward in directed),
            )  # fmt: skip


def _rims(solid: Solid, flat: float) -> Iterator[Rim]:
    taken: list[FloatArray] = []
    for face in solid.faces:
        if face.kind != "plane":
            continue
        for loop in face.loops:
            edges = [solid.edges[e] for e in loop.edges]
            if any(edge.kind != "circle" or edge.dihedral < pi - flat for edge in edges):
                continue
            found = _circle(edges)
            if found is None or any(np.abs(found[0] - other).max() < SAME * solid.size for other in taken):
                continue
            taken.append(found[0])
            center, radius = found
            yield Rim(
                center=center, normal=face.normal, radius=radius, start=solid.vertices[edges[0].start],
                length=sum(edge.length for edge in edges), face=face, border=loop.edges,
            )  # fmt: skip


def _circle(edges: Sequence[Edge]) -> tuple[FloatArray, float] | None:
    """Centre and radius, where the edges of a loop are one whole circle."""
    length = sum(edge.length for edge in edges)
    radius = length / (2.0 * pi)
    rows = [edge.curve.evaluate((np.arange(64) + 0.5) / 64) for edge in edges]
    # The middle of a circle is the mean of its points, every arc as heavy as it is long.
    center = np.average([row.mean(axis=0) for row in rows], axis=0, weights=[edge.length for edge in edges])
    off = np.abs(np.linalg.norm(np.concatenate(rows) - center, axis=1) - radius).max()
    return (center, radius) if off < ROUND * radius else None


__all__ = ["Piece", "Rim", "find_outlines", "find_rims"]
