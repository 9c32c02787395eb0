"""The clock and the voice of one run: seconds by stage, progress, and how a mesh in blocks is measured."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from ..blocks.block_mesh import BlockMesh
from ..blocks.stream import check_blocks
from ..progress import Progress
from ..quality import CadReference, QualityAccumulator, QualityReport


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
    seconds : dict of str to float
    """

    on_progress: Progress
    measure: Callable[[BlockMesh], QualityAccumulator] | None = None
    decompose_time: float = math.inf
    seconds: dict[str, float] = field(default_factory=dict)
    _since: list[float] = field(default_factory=list)

    @property
    def in_blocks(self) -> bool:
        """Whether meshes stay in blocks."""
        return self.measure is not None

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        self.on_progress(name, 0.0)
        start = time.perf_counter()
        if name == "decomposition":
            self._since.append(start)
        try:
            yield
        finally:
            if name == "decomposition":
                self._since.pop()
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start
        self.on_progress(name, 1.0)

    def is_late(self) -> bool:
        """Whether cuts have been looked for as long as the user allows."""
        spent = self.seconds.get("decomposition", 0.0)
        return spent + sum(time.perf_counter() - start for start in self._since) > self.decompose_time


def make_run(
    on_progress: Progress | None,
    decompose_time: float | None,
    *,
    measure: Callable[[BlockMesh], QualityAccumulator] | None = None,
) -> Run:
    """A run for what a user asks."""
    return Run(
        on_progress=on_progress or silent,
        measure=measure,
        decompose_time=math.inf if decompose_time is None else decompose_time,
    )


def silent(stage: str, fraction: float | None) -> None:
    """Progress for those who did not ask."""


def measured(mesh: BlockMesh, cad: CadReference | Mapping[str, CadReference] | None, run: Run) -> QualityReport:
    """Measure a mesh that stays in blocks, and check it."""
    assert run.measure is not None, "meshes stay in blocks"
    return check_blocks(mesh, cad, run.measure(mesh))
