"""From several candidate sweeps to the best mesh: which are tried, kept and noted, and why a solid has none.

Place in the flow: after recognition. A candidate is a complex of one cell (:mod:`.complexes`).
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from .. import cad, rows
from ..brep import Part, Solid
from ..errors import CadError, CadSweepError, CoarseMeshError, InputError, NotSweepableError
from ..options import SweepOptions
from ..quality import QualityReport
from ..sweep import Sweep
from .nearness.nearer import in_the_way
from .origin import AnyMesh, quality_of
from .run import Run, Tries

log = logging.getLogger(__name__)

GOOD_ENOUGH = 0.1
"""Worst scaled Jacobian at which no other candidate sweep is tried."""

POINTED = 0.01
"""Radians between two edges of a face below which they are tangent: a quad there has no area."""

POOR = 0.2
"""Worst scaled Jacobian below which a mesh is so poor that quite another one is tried."""

SMOOTH_BELOW = 0.3
"""Worst scaled Jacobian below which smoothing is tried."""

MOST_SMOOTHED = 5_000
"""Hexahedra of a poor mesh beyond which others are looked for before it is smoothed, which takes longer."""

SECOND_LOOK = 0.25
"""Share of the budget of a search for cells that might be better than what is there: they are mostly found at once."""

MOST_CANDIDATES = 3
"""Sweeps of one solid that are tried before the first one's error is raised."""


class PostponedError(NotSweepableError):
    """A mesh is poor, and the run says that something else comes before its smoothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Made:
    """One candidate sweep, made and checked; its boundary is `shortfall` times as far off the CAD as it may be.

    `rows` of tables had a share in it.
    """

    mesh: AnyMesh
    shortfall: float
    rows: frozenset[str] = frozenset()

    @property
    def report(self) -> QualityReport:
        """What the checks found."""
        return quality_of(self.mesh)

    @property
    def is_near(self) -> bool:
        """Whether the boundary is as near to the CAD as is asked for."""
        return self.shortfall <= 1.0

    @property
    def rank(self) -> tuple[bool, bool, float, float]:
        """What is better sorts later: valid, of good hexahedra, near to the CAD, of better ones."""
        worst = self.report.min_scaled_jacobian
        return self.report.valid, worst >= GOOD_ENOUGH, -max(1.0, self.shortfall), worst


Make = Callable[[Part, Sweep, SweepOptions, Run], Made]
"""Makes one candidate and refuses it where it is not valid."""


def explained(sweep: Sweep, failure: CadSweepError) -> CadSweepError:
    """Find out whether the model or the mesh is to blame: of a solid that runs into itself no mesh is valid."""
    if isinstance(failure, CadError):
        return failure
    caps = (*sweep.source, *sweep.target) if sweep.closed else ()
    return crossing_of(sweep.solid, failure, coincident=caps) or failure


def crossing_of(solid: Solid, failure: CadSweepError, *, coincident: Collection[int] = ()) -> CadError | None:
    """Say which faces of a solid cross, because of which it was refused; None where they keep apart."""
    crossing = cad.find_crossing(solid, coincident=coincident)
    if crossing is None:
        return None
    first, second = (solid.faces[f].label() for f in crossing)
    alone = crossing[0] == crossing[1]
    error = CadError(
        "the model runs into itself, so that no mesh of it is valid",
        where=f"{first}, which crosses itself" if alone else f"{first} and {second}, which cross each other",
        try_="repair it in its CAD program",
    )
    error.__cause__ = failure
    return error


def touching_of(solid: Solid, failure: CadSweepError) -> CadError | None:
    """Say which faces of a solid touch, because of which it was refused; None where they keep apart."""
    touching = cad.find_touching(solid)
    if touching is None:
        return None
    first, second = (solid.faces[f].label() for f in touching[:2])
    error = CadError(
        f"two faces touch at ({solid.units.place(touching[2])}) without an edge in common: the wall between them "
        "runs out to nothing",
        where=f"{first} and {second}",
        try_="move one of them, so that they cross or keep apart",
    )
    error.__cause__ = failure
    return error


def pointed_of(solid: Solid) -> str:
    """The face of a solid that runs out to a point which no hexahedron fits into, and where; empty where none does."""
    for face in solid.faces:
        for loop in face.loops:
            for (e, forward), angle in zip(loop.directed, loop.angles, strict=True):
                if angle < POINTED:
                    place = solid.vertices[solid.edges[e].start if forward else solid.edges[e].end]
                    return (
                        f"{face.label()}, which runs out to a point at ({solid.units.place(place)}) between two edges "
                        "that are tangent to each other"
                    )
    return ""


def foremost(refused: CadSweepError | None, error: CadSweepError) -> CadSweepError:
    """Of what the ways so far and this one say, what says most: of a mesh that was made more than of no recognition.

    Raises
    ------
    CadSweepError
        The input is at fault, and another way does not mend it.
    """
    at_fault = isinstance(error, InputError | CadError) and not isinstance(error, CoarseMeshError)
    if refused is None or isinstance(refused, NotSweepableError):
        if at_fault:
            raise error
        return error
    if at_fault:
        raise refused from error
    return refused


def first_good(
    part: Part,
    sweeps: Sequence[Sweep],
    options: SweepOptions,
    run: Run,
    make: Make,
) -> Made:
    """Make the first candidate that does well, or the best of those tried.

    Raises
    ------
    CadSweepError
        No candidate gave a mesh; says why the first one did not. What is wrong with the user's own wishes is raised
        at once.
    """
    tried: list[Made] = []
    failures: list[CadSweepError] = []
    tries = Tries(run)
    for number, sweep in enumerate(sweeps[:MOST_CANDIDATES]):
        if number and tries.is_over():
            break
        try:
            with rows.share() as own, tries.one():
                made = make(part, sweep, options, run)
        except CadSweepError as error:
            if isinstance(error, InputError | NotSweepableError) and not isinstance(error, CoarseMeshError):
                raise  # what the user asked for cannot be had by another sweep either
            log.info("candidate sweep %d given up: %s", number, error)
            failures.append(error)
            continue
        tried.append(replace(made, rows=frozenset(own)))
        near_enough = made.is_near or in_the_way(options)  # that would be in another sweep's way, too
        if made.report.valid and made.report.min_scaled_jacobian >= GOOD_ENOUGH and near_enough:
            break
    if not tried:
        raise explained(sweeps[0], failures[0])
    best = max(tried, key=lambda made: made.rank)
    rows.took(best.rows)
    given_up = [f"a better ranked sweep was given up: {error.message}" for error in failures]
    if not tried[0].is_near and tried[0].report.valid and best is not tried[0]:
        given_up.append(
            f"a better ranked sweep was passed over: it stays {tried[0].shortfall:.2g} times as far off as is asked for"
        )
    notes = [*best.mesh.info["notes"], *given_up]
    return replace(best, mesh=replace(best.mesh, info={**best.mesh.info, "notes": notes})) if given_up else best
