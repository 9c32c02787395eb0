"""The clock and the voice of one run: seconds by stage, progress, time left, and how a mesh in blocks is measured.

Whoever tries several things asks :class:`Tries`, or :class:`Run` itself, before each of them whether there is time for
another: what was found is taken then, or the last refusal given. What is under way comes to its end, and what the user
asks for is made however long it takes: only choices are left out. Time is the processor's, so that a busy machine gives
the same mesh.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TypeVar

from ..arrays import IntArray
from ..blocks.block_mesh import BlockMesh
from ..blocks.stream import check_blocks
from ..budget import check_budget
from ..estimate import Estimate
from ..options import SweepOptions
from ..progress import Progress, silent
from ..quality import CadReference, QualityAccumulator, QualityReport

Item = TypeVar("Item")

SECONDS = 45.0
"""Seconds of a run after which nothing more is begun: with what is under way then, an answer within a minute."""
TO_END = 15.0
"""Further seconds in which what was begun is to end."""
SEARCH = 20.0
"""Seconds of these for which cuts are looked for."""


def spent() -> float:
    """Seconds that this process and its ended children have worked."""
    ended = os.times()
    return time.process_time() + ended.children_user + ended.children_system


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Seconds by stage, the progress callback, and what all stages must know of what is asked.

    Attributes
    ----------
    on_progress : callable
    measure : callable or None
        Measures the hexahedra of a mesh that stays in blocks, because it is streamed or shared by ranks; None: meshes
        are made in memory.
    decompose_time : float
        Seconds for which cuts may be looked for.
    total : float
        Seconds after which nothing more is begun.
    on_expected : callable or None
        Called with what the mesh is expected to be, each time that more is known of it, and whether that is settled:
        whoever wants no more than to know raises there.
    is_spare : bool
        There is a mesh already: another is given up with the run's time, whatever is wrong with it.
    postpones : callable or None
        Says of a poor mesh whether something else comes before its smoothing; given what was found of it, and the cell
        (n,) of every hexahedron when it asks for that.
    seconds : dict of str to float
    """

    on_progress: Progress
    measure: Callable[[BlockMesh], QualityAccumulator] | None = None
    decompose_time: float = math.inf
    total: float = math.inf
    on_expected: Callable[[Estimate, bool], None] | None = None
    is_spare: bool = False
    postpones: Callable[[QualityReport, Callable[[], IntArray]], bool] | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    _since: list[float] = field(default_factory=list)
    _searched: list[float] = field(default_factory=list)
    _begun: float = field(default_factory=spent)

    @property
    def in_blocks(self) -> bool:
        """Whether meshes stay in blocks."""
        return self.measure is not None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        self.on_progress(name, 0.0)
        start = time.perf_counter()
        if name == "decomposition":
            self._since.append(spent())
        try:
            yield
        finally:
            if name == "decomposition":
                self._searched.append(spent() - self._since.pop())
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start
        self.on_progress(name, 1.0)

    def checks(self, expected: Estimate, options: SweepOptions) -> None:
        """Refuse what is expected to be too large, and say what it is expected to be.

        Raises
        ------
        InputError
        """
        check_budget(expected, max_hexes=options.max_hexes, max_memory=options.max_memory)
        self.expects(expected)

    def expects(self, expected: Estimate, *, settled: bool = False) -> None:
        """Say what the mesh is expected to be; `settled`: its boundary is made and near enough to the CAD."""
        if self.on_expected is not None:
            self.on_expected(expected, settled)

    def is_late(self) -> bool:
        """Whether cuts have been looked for as long as they may be."""
        return self._looked() > self.decompose_time or self.is_over()

    def _looked(self) -> float:
        """Seconds for which cuts have been looked for."""
        return sum(self._searched) + sum(spent() - start for start in self._since)

    def is_over(self, takes: float = 0.0) -> bool:
        """Whether nothing more is to be begun, or nothing that takes that many seconds."""
        return spent() - self._begun > min(self.total, self.total + TO_END - takes)

    def left(self) -> float:
        """Seconds until what was begun is to end."""
        return self.total + TO_END - (spent() - self._begun)

    def ends_smoothing(self, is_valid: bool, *, asked: bool) -> bool:
        """Whether a mesh stays as it is: a valid one of no size that is asked for, and any where there is another."""
        return self.is_over() and (self.is_spare or (is_valid and not asked))

    def ends_refining(self, options: SweepOptions) -> bool:
        """Whether a boundary stays as far off as it is: but for one of a tolerance or a size that is asked for."""
        return options.tolerance is None and options.size is None and self.is_over()

    @staticmethod
    def within(seconds: float) -> Run:
        """A silent run for something that is tried."""
        return Run(on_progress=silent, decompose_time=seconds, total=seconds)

    def for_share(self, share: float) -> Run:
        """The same run with a share of the time that is left for cuts: what they take is taken from the rest, too."""
        looked = self._looked()
        return replace(self, decompose_time=looked + share * max(0.0, self.decompose_time - looked))

    def anew(self) -> Run:
        """The same run with all its time again, for another solid."""
        return replace(self, _since=[], _searched=[], _begun=spent())


@dataclass
class Tries:
    """Things that are tried one after the other, none of which is begun with less time left than the longest took."""

    run: Run
    longest: float = 0.0

    @contextmanager
    def one(self) -> Iterator[None]:
        """Try one of them."""
        began = spent()
        try:
            yield
        finally:
            self.longest = max(self.longest, spent() - began)

    def of(self, items: Iterable[Item]) -> Iterator[Item]:
        """The items while there is time for another; what is done with each is a try."""
        for item in items:
            if self.is_over():
                return
            with self.one():
                yield item

    def is_over(self) -> bool:
        """Whether another one, if it took as long as the longest so far, would end too late."""
        return self.run.is_over(self.longest)


def make_run(
    on_progress: Progress | None,
    decompose_time: float | None,
    *,
    measure: Callable[[BlockMesh], QualityAccumulator] | None = None,
) -> Run:
    """A run for what a user asks."""
    search = SEARCH if decompose_time is None else decompose_time
    return Run(
        on_progress=on_progress or silent,
        measure=measure,
        decompose_time=search,
        total=SECONDS + max(0.0, search - SEARCH),
    )


def measured(mesh: BlockMesh, cad: CadReference | Mapping[str, CadReference] | None, run: Run) -> QualityReport:
    """Measure a mesh that stays in blocks, and check it."""
    assert run.measure is not None, "meshes stay in blocks"
    return check_blocks(mesh, cad, run.measure(mesh))
