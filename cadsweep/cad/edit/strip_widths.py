"""How wide the strips of a turned body may be: where their sides stay clear of what they pass.

Place in the flow: asked by :mod:`.strips`.

Method: widths are tried one by one, each as good as the worst of its angles and gaps: a side that leaves a circle
at a sharp angle, or runs next to a feature, a corner or a floor, makes poor hexahedra. Where all fail, widths between
the circles are tried, too, and those that hold a bore.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from operator import itemgetter

import numpy as np

from ...arrays import FloatArray
from .turned import Feature, unlike

N_WIDTHS, N_BETWEEN = 24, 8
"""Widths of a strip that are tried, and between two circles at least."""
BEST_SINE, BEST_GAP, BEST_CORNER = 0.75, 0.4, 0.2
"""What is good enough: the sine of the angle at which a strip's side leaves a circle, the distance of a side from the
feature in half widths of it, and of other places from each other in radii."""
MARGIN = 0.12
"""Distance of a plane from a feature, in its width, at least; twice that within it."""
UNLIKE = 0.05
"""Difference of the radii of two bores that cross, as a share of one, from which on planes alone part them."""
LEAST = 0.25
"""Share of what is good enough below which there is no room for a strip."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Section:
    """What a body looks like along its axis, all of its features in one plane.

    Attributes
    ----------
    across : pair of lists of Feature
        What goes along the first direction, and along the second; points from the axis' foot: across it, then along.
    beside : list of Feature
        What goes along the axis.
    floors : pair of lists of float
        Where what goes along each direction has its floors.
    radii : list of float
        Of all cylinders about the axis.
    bores : list of float
        Those of them that are bores: strips may hold them.
    corners : list of (3,) float64
        Ends of the edges of what goes along the axis and all around it.
    """

    across: tuple[list[Feature], list[Feature]]
    beside: list[Feature]
    floors: tuple[list[float], list[float]]
    radii: list[float]
    bores: list[float]
    corners: list[FloatArray]

    def widths(self) -> tuple[float, float] | None:
        """Half of the width of the strips along the two directions, 0 where there is none; None where none has room."""
        for holds, stops in ((False, [max(self.radii)]), (True, self.radii)):
            choices = [self.choices(way, stops) if self.across[way] else [0.0] for way in (0, 1)]
            scored = ((self.score(pair, holds=holds), *pair) for pair in product(*choices))
            best, first, second = max(scored, key=itemgetter(0))
            if best > LEAST:
                return first, second
        return None

    def choices(self, way: int, stops: Sequence[float]) -> list[float]:
        """Half widths to try along a direction, between the least and every one of some radii."""
        least, n = 1.05 * self.half(way), max(N_BETWEEN, N_WIDTHS // len(stops))
        ends = [least, *(stop for stop in stops if stop > least)]
        return [width for low, high in pairwise(ends) for width in np.linspace(low, high, n).tolist()] or [least]

    def half(self, way: int) -> float:
        """How far what goes along a direction reaches aside."""
        return max(float(np.abs(feature.points[:, 1 - way]).max()) for feature in self.across[way])

    def held(self, widths: Sequence[float]) -> list[float]:
        """Radii of the bores that lie inside of a strip."""
        return [radius for radius in self.bores if radius < max(widths)]

    def heights(self, widest: float, near: float) -> list[float] | None:
        """Where planes go across what crosses a bore in its strips, and between; None where they harm a feature.

        Parameters
        ----------
        widest : float
            Radius of the widest bore in the strips.
        near : float
            Distance up to which two places are one.
        """
        crossed: list[tuple[float, float]] = []
        for way, features in enumerate(self.across):
            for feature in features:
                left, half = _reach(feature.points[:, 1 - way])
                bore = float(np.hypot(*feature.points[:, :2].T).min())
                if all(abs(bore - radius) > near for radius in self.bores):
                    continue
                if abs(left + half) > near or abs(half - bore) < UNLIKE * bore:
                    return None
                if bore > widest + near:
                    continue
                low, high = _reach(feature.points[:, 2])
                crossed.append((low + half, high - half))
        crossed.sort()
        between = [0.5 * (below[1] + above[0]) for below, above in pairwise(crossed) if above[0] - below[1] > near]
        found = unlike([*(at for own in crossed for at in own), *between], near)
        own = [feature for features in self.across for feature in features]
        apart = [feature for feature in self.beside if not surrounds(feature)]
        met = [feature.points[:, 2] - at for feature in own for at in found]
        met += [feature.points[:, k] for feature in apart for k in (0, 1)]
        return found if all(map(_is_clear, met)) else None

    def goes_through(self, way: int, floor: float, widths: Sequence[float]) -> bool:
        """Whether a floor where strips cross goes on through the other one: cells there end on floors of their own."""
        other = 1 - way
        inside = abs(floor) < widths[other] and any(abs(end) > widths[way] for end in self.floors[other])
        return inside and all(_is_clear(f.points[:, way] - floor) for f in (*self.across[other], *self.beside))

    def score(self, widths: Sequence[float], *, holds: bool) -> float:
        """How good a section is, 1 at best: the worst of its angles and its gaps, as shares of what is good enough.

        Where strips may hold bores, all of them do, or none.
        """
        found, held = [1.0], self.held(widths) if holds else []
        for way, width in enumerate(widths):
            if not width:
                continue
            half = self.half(way)
            found.append((width - half) / (BEST_GAP * half))
            for radius in self.radii:
                if radius in held:
                    found.append((width - radius) / (BEST_GAP * radius))
                    continue
                if width >= radius:
                    return 0.0
                found.append(float(np.sqrt(1.0 - (width / radius) ** 2)) / BEST_SINE)
                ends = float(np.sqrt(radius**2 - width**2))
                found += [(ends - abs(f)) / (BEST_CORNER * radius) for f in self.floors[way] if abs(f) < radius]
            if widths[1 - way]:
                near = BEST_CORNER * max(self.radii)
                found += [abs(widths[1 - way] - abs(floor)) / near for floor in self.floors[way]]
            for corner in self.corners:
                found.append(float(abs(abs(corner[1 - way]) - width)) / (BEST_CORNER * half))
            for feature in self.beside:
                if surrounds(feature):
                    continue  # the sides leave through its walls
                low, high = feature.points[:, 1 - way].min(), feature.points[:, 1 - way].max()
                for side in (-width, width):
                    found.append(max(low - side, side - high) / (BEST_CORNER * half))
        return min(found + self.meeting(widths, held, holds=holds))

    def meeting(self, widths: Sequence[float], held: Sequence[float], *, holds: bool) -> list[float]:
        """How far the lines where strips cross keep from circles; a bore that is not held holds them all."""
        corner = float(np.hypot(widths[0], widths[1])) if all(widths) else 0.0
        return [
            (radius - corner if holds and radius in self.bores else abs(radius - corner)) / (BEST_CORNER * radius)
            for radius in self.radii
            if corner and radius not in held
        ]


def _reach(places: FloatArray) -> tuple[float, float]:
    """The least and the greatest place."""
    return float(places.min()), float(places.max())


def _is_clear(places: FloatArray) -> bool:
    """Whether a plane at 0 passes by a feature, its extent given, or goes through well inside."""
    low, high = _reach(places)
    margin = MARGIN * (high - low)
    return not (low - margin < 0.0 < low + 2.0 * margin or high - 2.0 * margin < 0.0 < high + margin)


def surrounds(feature: Feature) -> bool:
    """Whether a feature, its points from the axis' foot, goes all around the axis, as the flats of a hexagon do."""
    angles = np.sort(np.arctan2(feature.points[:, 1], feature.points[:, 0]))
    return bool(np.diff(angles, append=angles[0] + 2.0 * np.pi).max() < 0.5 * np.pi)


__all__ = ["Section", "surrounds"]
