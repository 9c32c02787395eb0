"""From several candidate sweeps to the best mesh: one loop, whoever makes, keeps and measures the mesh.

Place in the flow: after recognition. :mod:`.making` makes a candidate in memory or in blocks; which candidates are
tried, what is smoothed, refused and noted is decided here, so that a part has the same mesh, refusal and notes
whichever way it is made.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .. import cad, rows
from ..blocks.block import FactoredMesh
from ..blocks.block_mesh import BlockMesh
from ..brep import Part, Solid
from ..errors import CadError, CadSweepError, CoarseMeshError, InputError, NotSweepableError
from ..mesh import HexMesh
from ..options import SweepOptions
from ..quality import QualityReport
from ..sweep import Sweep
from .nearness.accuracy import check_curved
from .nearness.nearer import in_the_way
from .refusing import refusal
from .run import Run

log = logging.getLogger(__name__)

GOOD_ENOUGH = 0.1
"""Worst scaled Jacobian at which no other candidate sweep is tried."""

POINTED = 0.01
"""Radians between two edges of a face below which they are tangent: a quad there has no area."""

SMOOTH_BELOW = 0.3
"""Worst scaled Jacobian below which smoothing is tried."""

SECOND_LOOK = 0.25
"""Share of the budget of a search for cells that might be better than what is there: they are mostly found at once."""

COARSE = 0.01
"""Part of the volume that a mesh may lose or gain without a note."""

DOUBTFUL_VOLUME = 1e-4
"""Part of the volume that gaps between faces may leave open without a note; what CAD kernels leave is far below."""

MOST_CANDIDATES = 3
"""Sweeps of one solid that are tried before the first one's error is raised."""


class PostponedError(NotSweepableError):
    """A sweep is poor, and the run says that something else comes before its smoothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Made:
    """One candidate sweep, made and checked; its boundary is `shortfall` times as far off the CAD as it may be.

    `rows` of tables had a share in it.
    """

    factored: FactoredMesh
    report: QualityReport
    mesh: HexMesh | BlockMesh
    shortfall: float
    rows: frozenset[str] = frozenset()

    @property
    def is_near(self) -> bool:
        """Whether the boundary is as near to the CAD as is asked for."""
        return self.shortfall <= 1.0

    @property
    def rank(self) -> tuple[bool, bool, float, float]:
        """What is better sorts later: valid, of good hexahedra, near to the CAD, of better ones."""
        worst = self.report.min_scaled_jacobian
        return self.report.valid, worst >= GOOD_ENOUGH, -max(1.0, self.shortfall), worst

    def noted(self, notes: Sequence[str]) -> Made:
        """The same with more notes."""
        factored = self.factored.noted(notes)
        mesh = replace(self.mesh, info={**self.mesh.info, "notes": factored.info["notes"]})
        return replace(self, factored=factored, mesh=mesh)


Make = Callable[[Part, Sweep, SweepOptions, Run, float], Made]
"""Makes one candidate and refuses it where it is not valid; the last argument is the worst scaled Jacobian of the best
one so far."""


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
        f"two faces touch at ({solid.units.place(touching[2])}) without an edge in common: no hexahedra fit into the "
        "wall between them, which runs out to nothing",
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
    for number, sweep in enumerate(sweeps[:MOST_CANDIDATES]):
        if number and run.is_over():
            break
        try:
            near = (one for one in tried if one.report.valid and one.is_near)
            reached = max((one.report.min_scaled_jacobian for one in near), default=-np.inf)
            with rows.share() as own:
                made = make(part, sweep, options, run, reached)
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
    return best.noted([*volume_notes(best.report, best.factored), *given_up])


def checked(
    factored: FactoredMesh,
    check: Callable[[FactoredMesh], QualityReport],
    options: SweepOptions,
    run: Run,
    reached: float,
) -> tuple[FactoredMesh, QualityReport]:
    """Check a candidate, and mend it where that may be worth its while.

    Parameters
    ----------
    check : callable
        Multiplies out and measures.
    reached : float
        Worst scaled Jacobian of the best candidate so far.

    Raises
    ------
    PostponedError
    """
    report = check(factored)
    if options.smoothing and may_gain(report, options, reached):
        if run.postpones is not None and run.postpones(report.n_hexes):
            raise PostponedError("the sweep is poor, and something else is tried before it is smoothed")
        with run.stage("smoothing"):
            factored = smoothed(factored, partial(run.ends_polishing, asked=options.size is not None))
        if factored.is_changed:
            report = check(factored)
    return factored, report


def may_gain(report: QualityReport, options: SweepOptions, reached: float) -> bool:
    """Whether smoothing is worth its while: the boundary allows a valid mesh, better than what others have reached."""
    if report.min_scaled_jacobian >= SMOOTH_BELOW and not report.n_inverted:
        return False
    least = reached if options.allow_inverted else max(reached, 0.0)
    return report.limit is None or report.limit.value > least


def smoothed(factored: FactoredMesh, is_over: Callable[[], bool] = lambda: False) -> FactoredMesh:
    """Mend the worst places; what was moved is kept beside the factors."""
    from ..smoothing import improve  # most meshes need none

    points = factored.points().reshape(-1, 3)
    structure = factored.structure
    fixed = np.zeros((factored.n_node_layers, structure.n_nodes), dtype=bool)
    fixed[:, np.concatenate(structure.loops)] = True
    fixed[:, factored.kept_nodes] = True
    if not structure.periodic:
        fixed[[0, -1]] = True
    better = improve(points, structure, fixed=fixed.reshape(-1), is_over=is_over)
    return replace(
        factored.noted(better.steps),
        moved_nodes=better.nodes,
        moved_points=(better.positions - factored.offset) / factored.scale,
    )


def refuse(report: QualityReport, options: SweepOptions, part: Part, sweep: Sweep) -> None:
    """Raise what is wrong with a mesh that is not handed over.

    Raises
    ------
    CadSweepError
        The mesh is not valid, or too coarse to be the part, and the user does not allow that.
    """
    if not report.valid and not options.allow_inverted:
        raise refusal(report, part, sweep)
    if options.order > 1:
        check_curved(report.volume / part.scale**3, sweep, options)


def volume_notes(report: QualityReport, factored: FactoredMesh) -> list[str]:
    """Say where the model leaves its volume open, and where a valid mesh is too coarse to be the part."""
    known, doubt = factored.info["cad_volume"], factored.info["cad_volume_doubt"]
    notes = []
    if doubt > DOUBTFUL_VOLUME * known:
        notes.append(
            f"faces of the model miss each other, so that its volume is known to {doubt / known:.1g} of itself only; "
            "the checks allow for that"
        )
    off = report.volume / known - 1.0
    if abs(off) > COARSE + doubt / known:
        notes.append(
            f"the volume is {off:+.1%} off the CAD's, too coarse for its curves: take a smaller size or more layers"
        )
    return notes
