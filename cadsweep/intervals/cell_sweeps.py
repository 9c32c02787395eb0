"""What is asked of the counts of a part of several cells: how each cell is filled, and what its user wants.

Place in the flow: ``pipeline`` makes them; :mod:`.whole` and :mod:`.equations` read them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..brep import Solid
from ..corner_blocks import CornerBlocks
from ..sweep import LinkingSide, Sweep
from .sizes import Split


@dataclass(frozen=True, kw_only=True, eq=False)
class CellSweep:
    """What the counts of one cell depend on.

    Attributes
    ----------
    fill : Sweep or CornerBlocks
    grids : tuple of LinkingSide
        All faces that are logical rectangles: the linking sides, and caps that are.
    free : tuple of int
        Faces that get free quads; their loops need even sums.
    by_itself : bool
        Whether it is swept and nobody else has its linking sides: then its layers lie on levels, the same all around.
    """

    fill: Sweep | CornerBlocks
    grids: tuple[LinkingSide, ...]
    free: tuple[int, ...] = ()
    by_itself: bool = False

    @property
    def solid(self) -> Solid:
        """The cell."""
        return self.fill.solid


@dataclass(frozen=True, kw_only=True, eq=False)
class KeyDemand:
    """A count demanded of edges together, by key; `label` says who wants it."""

    keys: tuple[int, ...]
    count: int
    label: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Wishes:
    """What the user asks for, working units.

    Attributes
    ----------
    size : float or None
    layers : int or None
        Layers that every cell should have along its own sweep.
    cell_sizes : mapping of cell to float
    edge_sizes : mapping of edge key to float
    most_sizes : mapping of edge key to float
        What edges may have at most, where nothing else makes them finer.
    least_counts : mapping of edge key to int
        Segments that edges should have at least.
    needed_counts : mapping of edge key to int
        Segments that edges have at least.
    demands : sequence of KeyDemand
    alike : sequence of (int, int, bool)
        Edges with as many segments as each other, by key, and whether they run alike.
    splits : sequence of (edge keys, callable)
        Edges that are graded together, and how they share their segments.
    """

    size: float | None = None
    layers: int | None = None
    cell_sizes: Mapping[int, float] = field(default_factory=dict)
    edge_sizes: Mapping[int, float] = field(default_factory=dict)
    most_sizes: Mapping[int, float] = field(default_factory=dict)
    least_counts: Mapping[int, int] = field(default_factory=dict)
    needed_counts: Mapping[int, int] = field(default_factory=dict)
    demands: Sequence[KeyDemand] = ()
    alike: Sequence[tuple[int, int, bool]] = ()
    splits: Sequence[Split] = ()
