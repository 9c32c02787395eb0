"""How wide the strips of a turned body may be: where their sides stay clear of what they pass.

Place in the flow: asked by :mod:`.strips`.

Method: widths are tried one by one, each as good as the worst of its angles and gaps: a side that leaves a circle
at a sharp angle, or runs next to a feature, a corner or a floor, makes poor hexahedra.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...arrays import FloatArray
from .turned import Feature

N_WIDTHS = 24
"""Widths of a strip that are tried."""
BEST_SINE, BEST_GAP, BEST_CORNER = 0.75, 0.4, 0.2
"""What is good enough: the sine of the angle at which a strip's side leaves a circle, the distance of a side from the
feature in half widths of it, and of other places from each other in radii."""
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
    corners : list of (3,) float64
        Ends of the edges of what goes along the axis and all around it.
    """

    across: tuple[list[Feature], list[Feature]]
    beside: list[Feature]
    floors: tuple[list[float], list[float]]
    radii: list[float]
    corners: list[FloatArray]

    def widths(self) -> tuple[float, float] | None:
        """Half of the width of the strips along the two directions, 0 where there is none; None where none has room."""
        choices = []
        for way in (0, 1):
            if not self.across[way]:
                choices.append([0.0])
                continue
            half = self.half(way)
            choices.append(np.linspace(1.05 * half, max(self.radii), N_WIDTHS).tolist())
        best, chosen = LEAST, None
        for widths in product(*choices):
            score = self.score(widths)
            if score > best:
                best, chosen = score, widths
        return None if chosen is None else (chosen[0], chosen[1])

    def half(self, way: int) -> float:
        """How far what goes along a direction reaches aside."""
        return max(float(np.abs(feature.points[:, 1 - way]).max()) for feature in self.across[way])

    def score(self, widths: Sequence[float]) -> float:
        """How good a section is, 1 at best: the worst of its angles and its gaps, as shares of what is good enough."""
        found = [1.0]
        for way, width in enumerate(widths):
            if not width:
                continue
            half = self.half(way)
            found.append((width - half) / (BEST_GAP * half))
            for radius in self.radii:
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
        if all(widths):
            meeting = float(np.hypot(widths[0], widths[1]))
            found += [abs(meeting - radius) / (BEST_CORNER * radius) for radius in self.radii]
        return min(found)


def surrounds(feature: Feature) -> bool:
    """Whether a feature, its points from the axis' foot, goes all around the axis, as the flats of a hexagon do."""
    angles = np.sort(np.arctan2(feature.points[:, 1], feature.points[:, 0]))
    return bool(np.diff(angles, append=angles[0] + 2.0 * np.pi).max() < 0.5 * np.pi)


__all__ = ["Section", "surrounds"]
