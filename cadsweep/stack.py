"""A part as columns of material along one direction: ids, the plane arrangement of its caps, and levels.

Place in the flow: ``cad`` makes an :class:`Arrangement`; ``stacks`` makes a :class:`Stack` of it, then its
:class:`Levels`; what it is meshed with is in :mod:`.stack_mesh`.

::

       +-------+               caps    faces that a line along the direction crosses once
       | boss  |               walls   faces along the direction
    +--+-------+----+  level 2 cells   regions of the plane that the caps' outlines bound; over each of them
    |       .  |    |                  the caps alternate: in, out, in, out ...
    |  A   B.  +-+  |  level 1 column  what lies between a pair (in, out) over one cell
    |       .  . |  |
    +-------+--+-+--+  level 0
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .arrays import FloatArray
from .brep import Solid
from .sweep import LinkingSide, Sweep

_NOISE = 9
"""Digits of a unit vector that are told."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """What of the part stands over an edge of an arrangement: a wall between two of its rims, or one edge of caps.

    Attributes
    ----------
    edge : int
        Edge of the part that the outline follows.
    begin, end : float
        Fractions of its length over the start and the end of the arrangement's edge.
    low, high : int
        Edges of the part at the foot and at the top of the wall; the same where there is no wall.
    """

    edge: int
    begin: float
    end: float
    low: int
    high: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Outline:
    """An edge of an arrangement that is to be made anew, after outlines were laid together.

    Attributes
    ----------
    start, end : int
        Of the vertices that go with it.
    base : int
        Edge of the former arrangement that it follows.
    points : (m, 2) float64 or None
        Its course from start to end; None where it is that edge.
    over : tuple of (int, bool)
        Edges of the part that lie over it, and whether they run the same way.
    claims : tuple of Claim
    """

    start: int
    end: int
    base: int
    points: FloatArray | None
    over: tuple[tuple[int, bool], ...]
    claims: tuple[Claim, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Arrangement:
    """The outlines of all caps on one plane across the direction, as one cap of a prism along it.

    Attributes
    ----------
    prism : Solid
        The shadow of the part extruded along the direction. Its bottom is divided into the cells.
    bottoms, tops : tuple of int
        Faces of the prism under and over each cell.
    top_edges : dict of int to int
        Edge of the bottom to the edge over it.
    caps : tuple of frozenset of int
        For each cell, the faces of the part that lie over it.
    places : (n_cells, 3) float64
        A point inside each cell.
    over : dict of int to tuple of int
        For each edge of the bottom, the edges of the part that lie over it.
    ways : dict of int to tuple of bool
        Whether they run the same way.
    claims : dict of int to tuple of Claim
        Of edges that do not lie exactly under all that lies over them: where it is in truth.
    """

    prism: Solid
    bottoms: tuple[int, ...]
    tops: tuple[int, ...]
    top_edges: dict[int, int]
    caps: tuple[frozenset[int], ...]
    places: FloatArray
    over: dict[int, tuple[int, ...]]
    ways: dict[int, tuple[bool, ...]] = field(default_factory=dict)
    claims: dict[int, tuple[Claim, ...]] = field(default_factory=dict)


def name_direction(direction: FloatArray) -> str:
    """How messages name a direction; what is rounding beside 1 is zero."""
    return ", ".join(f"{c:.3g}" for c in np.round(direction, _NOISE) + 0.0)


@dataclass(frozen=True, kw_only=True)
class StackLimit:
    """What a part allows the hexahedra of its columns.

    Attributes
    ----------
    value : float
        Scaled Jacobian that none can exceed at the place; 1 where nothing limits.
    reason : str
        What is there, and where; empty where nothing limits.
    """

    value: float
    reason: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Stack:
    """One way to mesh a solid as columns between caps at any number of levels.

    Attributes
    ----------
    solid : Solid
    direction : (3,) float64
        Unit vector along which every column runs.
    source, target : tuple of int
        Caps at which columns begin and end, by the height of their centres.
    walls : tuple of int
        Faces along the direction.
    stations : tuple of int
        Edges between two walls that do not run along the direction: layers end at them.
    rounded : tuple of int
        Caps that turn until they run along the direction, at an edge.
    arrangement : Arrangement
    plan : Sweep
        The sweep of the arrangement's prism; its source cap is what is meshed.
    columns : tuple of tuple of (int, int)
        For each cell, the caps (in, out) of its columns, lowest first.
    score : float
        Expected quality, best 1; candidates are listed best first.
    limit : StackLimit
        By the edges of the part, whatever the mesh.
    upright_limit : StackLimit
        By its outlines and caps while columns are upright; smoothing may go beyond it.
    notes : tuple of str

    Examples
    --------
    >>> import cadsweep as cs
    >>> stack = cs.find_sweeps("models/block.step")[0]
    >>> [solid_face.name for solid_face in (stack.solid.faces[i] for i in stack.source)]
    ['base']
    """

    solid: Solid
    direction: FloatArray
    source: tuple[int, ...]
    target: tuple[int, ...]
    walls: tuple[int, ...]
    stations: tuple[int, ...]
    rounded: tuple[int, ...] = ()
    arrangement: Arrangement
    plan: Sweep
    columns: tuple[tuple[tuple[int, int], ...], ...]
    score: float = 0.0
    limit: StackLimit = StackLimit(value=1.0, reason="")
    upright_limit: StackLimit = StackLimit(value=1.0, reason="")
    notes: tuple[str, ...] = ()

    @property
    def closed(self) -> bool:
        """Whether the last layer is the first, as of a ring that was cut open: of columns along a line, never."""
        return False

    @property
    def linking_sides(self) -> tuple[LinkingSide, ...]:
        """The walls, as a sweep names its sides; they are no rectangles."""
        return tuple(LinkingSide(face=f, bottom=(), right=(), top=(), left=()) for f in self.walls)

    @property
    def rims(self) -> dict[int, list[tuple[int, int]]]:
        """For every face, its edges that lie over edges of the arrangement, and these."""
        found: dict[int, list[tuple[int, int]]] = {}
        for own, over in self.arrangement.over.items():
            for edge in over:
                for face in self.solid.edges[edge].faces:
                    found.setdefault(face, []).append((edge, own))
        return found

    @property
    def n_columns(self) -> int:
        """Columns of all cells."""
        return sum(len(columns) for columns in self.columns)


@dataclass(frozen=True, kw_only=True, eq=False)
class Levels:
    """The integers of a stack: on which layer of nodes every cap and station lies.

    Attributes
    ----------
    caps : dict of int to int
    stations : dict of int to int
    heights : (n_layers + 1,) float64
        Height along the direction that each level has in the mean, rising.
    """

    caps: dict[int, int]
    stations: dict[int, int] = field(default_factory=dict)
    heights: FloatArray

    @property
    def n_layers(self) -> int:
        """Layers from the lowest cap to the highest."""
        return len(self.heights) - 1
