"""Of the sets of cells that a search finds, the mesh that does well first, or the best of a few.

Place in the flow: between a search for cuts and what it is asked for (:mod:`.decomposing`).

Method: sets of cells are meshed as they are found. Where one is poor the search is told which cells are, and goes on
from there, as though these had no sweep; to smooth a large mesh takes longer, and comes after that.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from operator import itemgetter

import numpy as np

from ... import rows
from ...arrays import IntArray
from ...errors import CadSweepError, InputError
from ...options import SweepOptions
from ...quality import QualityReport
from ..candidates import GOOD_ENOUGH, MOST_SMOOTHED, SMOOTH_BELOW, PostponedError
from ..origin import AnyMesh, worst_of
from ..run import Run, Tries
from ..wishes.shared_hints import resolve_wishes
from .answering import answering
from .cells import expected_cells
from .complex import Complex
from .complexes import with_caps_grown
from .several import mesh_complex

log = logging.getLogger(__name__)

MOST_MESHED = 4
"""Sets of cells that are meshed before the best of them is taken."""
MOST_HEXES = 300_000
"""Hexahedra of the sets of cells that were meshed, from which on no further set is: some 30 s with their polish."""


AGAIN = "cut: poor cells again"
"""The row of cells that are cut further for their hexahedra."""


class BestCells:
    """The best mesh so far, of which cells, and why the first that was given up was.

    Parameters
    ----------
    cut_again : callable
        Tells the search which cells of what it found last are poor.
    options : SweepOptions
    run : Run
    """

    def __init__(self, cut_again: Callable[[Sequence[int]], None], options: SweepOptions, run: Run) -> None:
        self.cut_again, self.options, self.run = cut_again, options, run
        self.tries = Tries(run)
        self.best: AnyMesh | None = None
        self.chosen: Complex | None = None
        self.failure: CadSweepError | None = None
        self.shares: set[str] = set()
        self.n_hexes, self.most_hexes = 0, MOST_HEXES
        self.postponed: list[tuple[float, Complex]] = []

    def of_all(self, solutions: Iterator[Complex], reached: float) -> tuple[AnyMesh | None, CadSweepError | None]:
        """The best mesh, and why the first that was given up was.

        Once chosen, what is poor has its nodes moved on the model's faces if it is better than the worst scaled
        Jacobian that was `reached` before; where none is valid, and there was none before, the first is tried so.
        """
        self.find(solutions)
        if self.postponed and self.worst < SMOOTH_BELOW:
            self.make(max(self.postponed, key=itemgetter(0))[1], self.run)
        is_poor = self.options.smoothing and reached <= self.worst < SMOOTH_BELOW
        if self.chosen is not None and is_poor and not self.tries.is_over():
            self.make(self.chosen, self.run, slide=True)
        if self.best is not None and self.chosen is not None:
            again = [AGAIN] if self.postponed and self.chosen is not self.postponed[0][1] else []
            rows.took({*self.shares, *again, *(f"cut: {cut.family}" for cut in self.chosen.part.cuts if cut.family)})
        return self.best, self.failure

    @property
    def worst(self) -> float:
        """Worst scaled Jacobian of the best mesh."""
        return -np.inf if self.best is None else worst_of(self.best)

    def find(self, solutions: Iterator[Complex]) -> None:
        """Mesh what is found until one does well."""
        for _ in range(MOST_MESHED):
            if (self.best is not None or self.failure is not None) and self.tries.is_over():
                break
            if self.n_hexes > self.most_hexes:
                log.info("no further cells: about %d hexahedra were made", self.n_hexes)
                break
            with self.run.stage("decomposition"):
                came = next(solutions, None)
                if came is None:
                    break
                found = answering(with_caps_grown(came), self.options, self.run)
            same = len(found.part.solids) == len(came.part.solids)
            self.make(found, replace(self.run, postpones=self.postpones(found, same=same)))
            if self.worst >= GOOD_ENOUGH:
                break

    def postpones(self, found: Complex, *, same: bool) -> Callable[[QualityReport, Callable[[], IntArray]], bool]:
        """What has poor cells cut again before they are smoothed, if they are the `same` as the search has."""

        def says(report: QualityReport, hex_cells: Callable[[], IntArray]) -> bool:
            is_large = report.n_hexes > MOST_SMOOTHED and rows.is_on(AGAIN)
            if not is_large or report.min_scaled_jacobian >= GOOD_ENOUGH:
                return False
            if same:
                poor = [own.id for own in report.worst if own.scaled_jacobian < SMOOTH_BELOW]
                self.cut_again(np.unique(hex_cells()[poor]).tolist())
            self.postponed.append((report.min_scaled_jacobian, found))
            return True

        return says

    def make(self, found: Complex, run: Run, *, slide: bool = False) -> None:
        """Mesh cells, and keep the mesh if it is the best, or why it was given up if it is the first that was."""
        wishes = resolve_wishes(found.part, self.options, found.model)
        try:
            with rows.share() as own, self.tries.one():
                mesh = mesh_complex(found, self.options, run, wishes, slide=slide)
        except InputError:
            raise
        except CadSweepError as error:
            self.n_hexes += expected_cells(found.part, found.plan, wishes).n_hexes
            if isinstance(error, PostponedError):
                return
            log.info("%d cells given up: %s", len(found.part.solids), error)
            self.failure, self.chosen = self.failure or error, self.chosen or found
            # Whatever its size, another is tried where none is valid.
            self.most_hexes = max(self.most_hexes, self.n_hexes)
        else:
            self.n_hexes += mesh.n_hexes
            if worst_of(mesh) > self.worst:
                self.best, self.chosen, self.shares = mesh, found, own


__all__ = ["AGAIN", "MOST_MESHED", "BestCells"]
