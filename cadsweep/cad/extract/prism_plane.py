"""Cells of a plane and the lines between them, read once: what a prism over them is made of.

Place in the flow: first step of :mod:`.prism`. Lines are numbered anew: those of the rim first, then as the cells have
them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from ...arrays import FloatArray
from ...brep import Edge, Face, Loop, Units
from ..geometry.affine import carried
from ..geometry.angles import MIDDLE, chain_loops, corner_angles
from ..geometry.curves import EdgeCurve
from ..geometry.parametric import Line, Parametric
from ..geometry.surfaces import Plane
from ..geometry.vectors import cross_rows
from ..shapes import compound
from .shared import PartGeometry

Wires: TypeAlias = "Sequence[Sequence[tuple[int, bool]]]"
"""Lines that bound a cell, outer wire first, and whether the cell is on their left."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Overhead:
    """What of a part lies over the lines and the cells of a plane, for messages: lowest first.

    Attributes
    ----------
    edges : sequence of tuple of Edge
        Over every line.
    walls : sequence of tuple of Face
        That stand over it.
    caps : sequence of tuple of Face
        Over every cell.
    units : Units
        What messages give places in.
    """

    edges: Sequence[tuple[Edge, ...]]
    walls: Sequence[tuple[Face, ...]]
    caps: Sequence[tuple[Face, ...]]
    units: Units = field(default_factory=Units)

    @classmethod
    def nothing(cls, n_lines: int, n_cells: int) -> Overhead:
        """Over lines and cells that are of no part."""
        return cls(edges=[()] * n_lines, walls=[()] * n_lines, caps=[()] * n_cells)


@dataclass(frozen=True, kw_only=True, eq=False)
class PlaneCells:
    """Lines and cells of a plane, each by its number.

    Attributes
    ----------
    plane : Plane
    along, up : (3,) float64
        From the bottom of the prism to its top; the same as a unit vector.
    place : dict of int to int
        Number of every line by the one it was given with.
    n_rim : int
        Lines with a cell on one side only, which come first.
    shapes : list of TopoDS_Edge
    beside : list of (int, int)
        Cells on the left and on the right of each line, -1 outside.
    shared : PartGeometry
    curves, lifted : list of EdgeCurve
        Of the lines, and of the same at the top.
    kinds : list of str
    loops : list of list of Loop
        Of every cell, seen from above, outer loop first.
    overhead : Overhead
        By the numbers that lines have here.
    """

    plane: Plane
    along: FloatArray
    up: FloatArray
    place: dict[int, int]
    n_rim: int
    shapes: list[Any]
    beside: list[tuple[int, int]]
    shared: PartGeometry
    curves: list[EdgeCurve]
    lifted: list[EdgeCurve]
    kinds: list[str]
    loops: list[list[Loop]]
    overhead: Overhead

    @property
    def height(self) -> float:
        """Of the prism."""
        return float(np.linalg.norm(self.along))

    def sense(self, j: int) -> float:
        """1 where the cells lie on the left of a line of the rim."""
        return 1.0 if self.beside[j][0] >= 0 else -1.0

    def right(self, tangents: FloatArray) -> FloatArray:
        """To the right of tangents (m, 3), seen from above."""
        return cross_rows(tangents, np.broadcast_to(self.up, tangents.shape))

    def facing(self) -> FloatArray:
        """Normals (n_rim, 3) of the sides over the rim at their middles."""
        senses = np.array([self.sense(j) for j in range(self.n_rim)])
        return senses[:, None] * self.right(self.shared.samples.tangents[: self.n_rim, 1])

    def rail_curve(self, v: int) -> EdgeCurve:
        """The line up from a vertex."""
        line = Line(origin=self.shared.positions[v], direction=self.up)
        return EdgeCurve(geometry=line, first=0.0, last=self.height, constant_speed=True)

    def dropped(self, j: int) -> Callable[[], tuple[Parametric, FloatArray]]:
        """What a line is in the plane's coordinates, for :class:`EdgeOnFace`."""
        frame = self.plane.frame

        def read() -> tuple[Parametric, FloatArray]:
            axes = np.array([frame.x, frame.y])
            return carried(self.curves[j].geometry, axes, -axes @ frame.origin), np.zeros(2)

        return read

    def box(self, loops: Sequence[Loop]) -> FloatArray:
        """Of the ends and middles of a cell's lines, in the plane's coordinates."""
        own = [j for loop in loops for j in loop.edges]
        places = self.plane.project(self.shared.samples.points[own].reshape(-1, 3))
        return np.array([places.min(axis=0), places.max(axis=0)])


def read_plane(  # noqa: PLR0917
    cells: Sequence[Wires],
    lines: Sequence[Any],
    read: Sequence[tuple[EdgeCurve, str]],
    beside: Sequence[tuple[int, int]],
    plane: Plane,
    along: FloatArray,
    overhead: Overhead,
) -> PlaneCells:
    """Read the lines of a plane and chain them to the loops of its cells; as :func:`.prism.extrude_cells` has them."""
    height = float(np.linalg.norm(along))
    up = along / height
    rim = [j for j, own in enumerate(beside) if -1 in own]
    met = (j for cell in cells for wire in cell for j, _ in wire)
    order = list(dict.fromkeys([*rim, *met]))
    place = {j: k for k, j in enumerate(order)}
    shapes = [lines[j] for j in order]
    own = [read[j] for j in order]
    curves = [curve for curve, _ in own]
    shared = PartGeometry(compound(shapes), curves=own)
    return PlaneCells(
        plane=plane,
        along=along,
        up=up,
        place=place,
        n_rim=len(rim),
        shapes=shapes,
        beside=[beside[j] for j in order],
        shared=shared,
        curves=curves,
        lifted=[_lifted(curve, along) for curve in curves],
        kinds=[kind for _, kind in own],
        loops=_loops([[[(place[j], left) for j, left in wire] for wire in cell] for cell in cells], shared, curves, up),
        overhead=Overhead(
            edges=[overhead.edges[j] for j in order],
            walls=[overhead.walls[j] for j in order],
            caps=overhead.caps,
            units=overhead.units,
        ),
    )


def _lifted(curve: EdgeCurve, along: FloatArray) -> EdgeCurve:
    return EdgeCurve(
        geometry=carried(curve.geometry, np.eye(3), along),
        first=curve.first,
        last=curve.last,
        breaks=curve.breaks,
        constant_speed=curve.constant_speed,
    )


def _loops(
    cells: Sequence[Wires], shared: PartGeometry, curves: Sequence[EdgeCurve], up: FloatArray
) -> list[list[Loop]]:
    """The loops of every cell seen from above, outer loop first."""
    frame = {**dict.fromkeys(range(len(curves)), np.broadcast_to(up, (3, 3))), MIDDLE: up[None]}
    ends = [(start, end) for start, end in shared.ends.tolist()]
    tangents = shared.samples.end_tangents
    chains = [[chain for wire in cell for chain in chain_loops(wire, ends, curves, frame, tangents)] for cell in cells]
    flat = [chain for own in chains for chain in own]
    angles = iter(corner_angles(flat, curves, [frame] * len(flat), tangents))
    return [
        [Loop(edges=tuple(j for j, _ in c), forward=tuple(way for _, way in c), angles=next(angles)) for c in own]
        for own in chains
    ]


__all__ = ["Overhead", "PlaneCells", "Wires", "read_plane"]
