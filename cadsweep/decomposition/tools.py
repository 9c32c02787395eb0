"""What the search for cuts through solids of any kind (:mod:`.curved`) is given: recognition, plan, cutters, cuts."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from ..brep import Part, Solid
from ..corner_blocks import CornerBlocks
from ..sweep import Sweep

Fill = Sweep | CornerBlocks
"""How a cell is filled with hexahedra."""


class Cutter(Protocol):
    """What parts a cell; `cad` knows how."""

    @property
    def kind(self) -> str: ...

    @property
    def family(self) -> str: ...

    @property
    def reason(self) -> str: ...

    @property
    def price(self) -> float: ...

    @property
    def leads(self) -> bool: ...


class Parted(Protocol):
    """Cells in pieces, before they and their neighbours are imprinted on each other."""

    @property
    def key(self) -> Hashable:
        """Equal for two parts with the same cells."""

    def imprinted(self) -> Part | None:
        """The part with the pieces in it; None where that fails."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tools:
    """What the search is given.

    Attributes
    ----------
    recognise : callable
        ``recognise(solid)``: the sweeps of a cell, none where there are none.
    make_plan : callable
        ``make_plan(part, candidates)``; raises PlanError.
    find_cutters : callable
        ``find_cutters(part, cell, faces)``, the most promising first.
    split : callable
        ``split(part, cell, cutter, others)``: the pieces of the cell, or None; other cells in the way are parted with
        it where that is the cutter's way. Imprinting the part costs ten times as much, and waits until they are new.
    make_alike : callable
        ``make_alike(part, cells)``: the part with edges of cells in the way divided where that gives one of them a
        sweep; None where it gives none.
    on_progress : callable
        Called with the number of cells in the way.
    is_late : callable
        Whether the search must end before its count is used up.
    """

    recognise: Callable[[Solid], list[Fill]]
    make_plan: Callable[[Part, list[list[Fill]]], Any]
    find_cutters: Callable[[Part, int, Sequence[int]], Iterable[Cutter]]
    split: Callable[[Part, int, Any, Sequence[int]], Parted | None]
    make_alike: Callable[[Part, Sequence[int]], Part | None] = lambda part, cells: None
    on_progress: Callable[[int], None] = lambda n: None
    is_late: Callable[[], bool] = lambda: False
