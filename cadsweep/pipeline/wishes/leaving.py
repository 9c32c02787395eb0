"""What leaves a wall is divided by the heights of its layers: one rule for edges of sweeps, of cells, and of columns.

Place in the flow: :mod:`.walls`, :mod:`.stack_walls` and :mod:`.cell_walls` find which lines leave which walls; here is
how such a line divides itself, and how many segments it needs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Generic, TypeVar

import numpy as np

from ...arrays import FloatArray
from ...asked import WallLayers, layer_heights, wall_layers
from ...brep import Edge, Face, Part, Solid
from ...errors import InputError
from ...options import SweepOptions
from ...surface import Division, turned_round
from ...sweep import Sweep
from .named_faces import Place, faces_called

STRAIGHT_ON = np.radians(135)
"""Angle of a section from which on a wall goes on along its neighbour: its rows could not end there."""
MOST_OF_EDGE = 0.8
"""Part of a line that layers at its ends may take."""
LEAST_SLANT = 0.2
"""Sine of the angle between an edge and the wall that it leaves below which its layers get no longer."""
_LEAST_GROWTH = 1.05
"""Growth of what follows layers that do not grow themselves."""
_MOST_GROWTH = 1e3
"""Growth up to which one is looked for that fills a length."""

_Line = TypeVar("_Line")


@dataclass(kw_only=True, eq=False)
class Leaving(Generic[_Line]):
    """Lines at whose ends layers begin, or rows along walls end: edges by id or key, or heights between two sheets.

    Attributes
    ----------
    ends : dict of line to dict of bool to (n,) float64
        Distances of the layers' nodes from its start (True) and its end.
    growths : dict of line to float
        How what is left grows away from them.
    notes : list of str
    """

    ends: dict[_Line, dict[bool, FloatArray]] = field(default_factory=dict)
    growths: dict[_Line, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def leave(self, line: _Line, own: WallLayers, *, sine: float, at_start: bool) -> FloatArray:
        """Begin layers at an end of a line, which leaves the wall at an angle; gives their nodes' distances."""
        distances = heights_of(own) / max(sine, LEAST_SLANT)
        self.ends.setdefault(line, {})[at_start] = distances
        self.growths[line] = max(own.growth, _LEAST_GROWTH)
        return distances

    def shorten(self, line: _Line, edge: Edge) -> None:
        """Thin the layers where an edge is too short for them."""
        taken = sum(float(d[-1]) for d in self.ends[line].values())
        if taken > MOST_OF_EDGE * edge.length:
            shrink = MOST_OF_EDGE * edge.length / taken
            self.ends[line] = {side: d * shrink for side, d in self.ends[line].items()}
            self.notes.append(f"wall layers are thinner at {edge.label()}, which is too short for them")

    def needed(self, line: _Line, length: float, size: float) -> int:
        """Segments for the layers, and for what is left of the line, growing up to `size`."""
        ends = tuple(self.ends[line].values())
        left = length - sum(float(d[-1]) for d in ends)
        return sum(len(d) for d in ends) + _count_between(left, _last(ends), self.growths[line], size)

    def division(self, line: _Line, length: float, label: str) -> Division:
        """How the line divides itself."""
        begin, end = (self.ends[line].get(side, np.empty(0)) / length for side in (True, False))
        return partial(_layered, begin=begin, end=end, growth=self.growths[line], label=label)


def walls_asked(part: Part, model: Part, options: SweepOptions) -> Iterator[tuple[str, WallLayers, Place]]:
    """The user's words for walls, the layers along them in working units, and each face of a cell that they mean.

    Raises
    ------
    InputError
        A name that no outer face has.
    """
    for word, value in (options.wall_layers or {}).items():
        asked = wall_layers(f"the wall layers of '{word}'", value)
        own = replace(asked, first=asked.first / part.scale)
        places = faces_called(part, model, word)
        if not places:
            raise InputError(f"wall layers of '{word}': it lies between solids, and is no wall")
        yield from ((word, own, place) for place in sorted(places))


def leave_at(solid: Solid, face: Face, edge: Edge, at: Collection[int]) -> Iterator[tuple[bool, float]]:
    """At which ends (True: the start) an edge leaves a wall at such vertices, and the sine of its angle there."""
    for at_start, vertex in ((True, edge.start), (False, edge.end)):
        if vertex in at:
            normal = face.surface.normals(face.surface.project(solid.vertices[vertex][None]))[0]
            yield at_start, abs(float(edge.tangents[0 if at_start else 1] @ normal))


def joints(sweep: Sweep) -> Iterator[tuple[int, tuple[int, bool], tuple[int, bool], float]]:
    """Faces of the source, pairs of their directed edges that follow each other, and the face's angle between them."""
    for f in sweep.source:
        for loop in sweep.solid.faces[f].loops:
            directed = loop.directed
            for j, angle in enumerate(loop.angles):
                yield f, directed[j - 1], directed[j], angle


def heights_of(own: WallLayers) -> FloatArray:
    """Heights (n,) of the nodes of layers over their wall."""
    return layer_heights(np.array([own.first]), np.array([own.growth]), own.n, np.array([np.inf]))[0]


def _last(ends: Iterable[FloatArray]) -> list[float]:
    """Heights of the last layers at the ends of a line."""
    return [float(np.diff(d, prepend=0.0)[-1]) for d in ends if len(d)]


def _count_between(length: float, last: list[float], growth: float, size: float) -> int:
    """Segments that lead on from the last layers, growing up to the size."""
    for n in range(1, 100_000):
        if _grown(n, last, growth, size).sum() >= length:
            return n
    return 100_000


def _grown(n: int, last: list[float], growth: float, most: float) -> FloatArray:
    """Lengths of n segments that grow away from the layers at one end or at both, up to the greatest."""
    steps = growth ** np.arange(1, n + 1, dtype=float)
    rows = [last[0] * steps, *(own * steps[::-1] for own in last[1:])]
    return np.minimum(np.min(rows, axis=0), max(most, min(last)))


def _layered(n: int, *, begin: FloatArray, end: FloatArray, growth: float, label: str) -> FloatArray:
    """Fractions (n + 1,) of an edge with nodes at given fractions from its ends, and growing segments between."""
    n_left = n - len(begin) - len(end)
    if n_left < 1:
        raise InputError(
            f"{label} gets {n} segments, and {n - n_left} wall layers end or begin there: ask for at least "
            f"{n - n_left + 1}"
        )
    if not len(begin):
        return turned_round(_layered(n, begin=end, end=begin, growth=growth, label=label))
    left = 1.0 - begin[-1] - (end[-1] if len(end) else 0.0)
    last = _last((begin, end))
    weights = _grown(n_left, last, growth, np.inf)
    enough = weights.sum() >= left
    # The greatest segment where there are enough; else more growth than was asked for.
    low, high = (0.0, 1.0) if enough else (growth, _MOST_GROWTH)
    for _ in range(100):
        middle = (low + high) / 2
        made = np.minimum(weights, middle) if enough else _grown(n_left, last, middle, np.inf)
        low, high = (middle, high) if made.sum() < left else (low, middle)
    weights = np.minimum(weights, high) if enough else _grown(n_left, last, high, np.inf)
    between = begin[-1] + left * np.cumsum(weights)[:-1] / weights.sum()
    return np.concatenate([[0.0], begin, between, 1.0 - end[::-1], [1.0]])
