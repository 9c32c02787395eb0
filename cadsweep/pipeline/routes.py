"""The ways to a mesh, in the order in which they are tried: what a part is decides which of them applies.

=============== ======================================= ================================================
way             where it applies                        what it makes
=============== ======================================= ================================================
one sweep       one solid                               the best of its sweeps, factored
stack           one solid that no sweep gives a mesh of columns between caps along one direction
design          one solid with blends                   that of the solid without them, laid on its faces
cells           one solid that none of these fits well  cells of cuts on one skeleton
fitted grid     one solid that all others refuse, or    a grid, its skin laid on the faces
                of which they make a mesh far worse
several solids  more than one solid                     cells that touch on one skeleton, others beside
=============== ======================================= ================================================

A way is imported when it is taken: columns and cells are two thirds of the package, and most parts need neither.
"""

from __future__ import annotations

import logging
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from .. import cad, rows
from ..blocks.block_mesh import BlockMesh
from ..blocks.joined import neighbours_of
from ..brep import Part
from ..errors import (
    CadSweepError,
    InputError,
    InvertedHexError,
    NotSweepableError,
    SurfaceMeshError,
)
from ..mesh import HexMesh
from ..options import SweepOptions
from ..quality import QualityReport
from ..sweep import Sweep
from ..trial import noting
from .attempts import find_candidates
from .candidates import (
    GOOD_ENOUGH,
    MOST_SMOOTHED,
    SECOND_LOOK,
    SMOOTH_BELOW,
    Made,
    PostponedError,
    crossing_of,
    first_good,
    foremost,
    touching_of,
)
from .judging import FAR_WORSE, is_as_good, is_of_placing, is_pointed, is_poor, reached_by
from .origin import AnyMesh, made_of, quality_of, with_last, worst_of
from .parts import load
from .run import Run
from .tips import AFTER, flattened, mesh_bridged_or_plain, mesh_marked_or_bare
from .wishes.local_sizes import noting_large, with_largest_size

log = logging.getLogger(__name__)

SWEEP, COLUMNS, DESIGN, CELLS, FITTED = (f"way: {way}" for way in ("sweep", "columns", "design", "cells", "fitted"))
"""The ways to a mesh of one solid by name."""
INSTEAD = "fitted: instead of a poor mesh"
"""The row of fitted grids that are tried though another way made a mesh."""
LEAVING_OUT = (INSTEAD, AFTER)
"""Rows by which a part has a mesh that leaves out edges of it where it has another: others cannot have that."""

_MENDABLE = (NotSweepableError, InvertedHexError, SurfaceMeshError)
"""Refusals of one way that leave others to be tried, or proposed."""

GOOD_DESIGN = 0.5
"""Worst scaled Jacobian at which no design is tried: two quads of one hexahedron on a rounding leave less, mostly."""
_MOST_CARRIED, _MOST_POOR = 300_000, 1_000_000
"""Hexahedra of a fair mesh, and of a poor one, beyond which its design is not tried: that is carried node by node."""
DESIGN_LOOK = 0.5
"""Share of the budget, and of the time, of a search for cells of the design: the rest is for the solid as it is."""
_MOST_LOOKED_AT = 60
"""Faces of a solid up to which OpenCASCADE is asked more than once: whether those of a refused one cross or touch, and
whether cells are better than columns; both take seconds for more."""


def open_part(source: Any, options: SweepOptions, run: Run) -> Part:
    """Load what the user gives."""
    with run.stage("cad"):
        part = load(
            source,
            params=None if options.params is None else dict(options.params),
            part=options.part,
            only=options.only,
            skip=options.skip,
            touch=options.touch,
            cut_overlaps=options.cut_overlaps,
            on_progress=lambda share: run.on_progress("cad", share),
        )
        if options.names:
            part = cad.give_names(part, options.names)
        if options.suppress:
            part = cad.suppress(part, options.suppress)
        return flattened(part, options)


def mesh_in_memory(source: Any, options: SweepOptions, run: Run) -> HexMesh:
    """Mesh a part by the first way that applies."""
    assert not run.in_blocks, "nobody asked for blocks"
    mesh = mesh_part(source, options, run)
    assert isinstance(mesh, HexMesh)
    return mesh


def mesh_in_blocks(source: Any, options: SweepOptions, run: Run) -> BlockMesh:
    """The same mesh, which stays in blocks as far as it is made of sweeps or straight columns."""
    assert run.in_blocks, "somebody measures them"
    from .complexes.groups import as_blocks

    return as_blocks(mesh_part(source, options, run))


def mesh_part(source: Any, options: SweepOptions, run: Run) -> AnyMesh:
    """Mesh a part by the first way that applies, in memory or in blocks; its notes say what OpenCASCADE failed in."""
    with noting() as given_up, rows.without(options.without), rows.share() as shares:
        mesh = _mesh_part(source, options, run)
    return replace(mesh, info={**mesh.info, "notes": [*mesh.info["notes"], *given_up], "rows": tuple(sorted(shares))})


def _mesh_part(source: Any, options: SweepOptions, run: Run) -> AnyMesh:
    part = open_part(source, options, run)
    options = with_largest_size(part, options)
    part = noting_large(part, options)
    chosen = options.only is not None or options.skip is not None
    # These are about the source, which is open now.
    options = replace(options, params=None, part=None, names=None, suppress=None)
    if options.fitted and (options.cuts or neighbours_of(part)):
        raise InputError("fitted=True goes without cuts and without contacts: a fitted grid fills a solid by itself")
    if options.cuts:
        from .complexes.decomposing import mesh_user_cut

        return mesh_user_cut(part, options, run)
    if len(part.solids) > 1 or chosen:  # one that is left of several keeps its name
        from .complexes.assemblies import mesh_assembly

        return mesh_assembly(part, options, run, mesh_solid)
    return mesh_solid(part, options, run)


class _Before(NamedTuple):
    """What has come of the ways before one: why they were refused, the best mesh; and its share of a search's time."""

    refused: CadSweepError | None = None
    best: AnyMesh | None = None
    share: float = 1.0


def mesh_solid(part: Part, options: SweepOptions, run: Run) -> AnyMesh:
    """Mesh a part of one solid by the first way that does well, or by the best of all.

    Raises
    ------
    CadSweepError
        None makes a mesh; says what would.
    """
    if options.fitted:
        rows.took([FITTED])
        return _mesh_fitted(part, options, run, _Before())
    try:
        by_ways = partial(mesh_bridged_or_plain, mesh_it=_by_ways, last=[FITTED], slow=[DESIGN, CELLS])
        return mesh_marked_or_bare(part, options, run, by_ways, last=[FITTED])
    except _MENDABLE as refused:
        from .remedies import find_remedy, proposing

        looked_at = len(part.solids[0].faces) <= _MOST_LOOKED_AT
        crossed = crossing_of(part.solids[0], refused) if looked_at else None
        if crossed is not None:
            raise crossed from refused
        if isinstance(refused, NotSweepableError):
            raise proposing(part, options, refused, _mesh_plainly) from refused
        raise refused.about(try_=find_remedy(part, options, refused, _mesh_plainly) or refused.try_) from refused


def _by_ways(part: Part, options: SweepOptions, run: Run, share: float = 1.0, *, is_own: bool = True) -> AnyMesh:
    """As :func:`mesh_solid`, with a refusal that proposes nothing; cuts are looked for that share of their time.

    Not `is_own`: the part is made of the user's, whose faces are looked at by themselves.
    """
    refused: CadSweepError | None = None
    if not rows.is_on(SWEEP):
        refused = NotSweepableError("no sweep was looked for", try_="switch a row of the table 'way' on again")
    best: AnyMesh | None = None
    shares: set[str] = set()
    enough = False
    left = list(WAYS)
    first = replace(run, postpones=partial(_postpones, part, options))
    is_searched = False
    while left:
        row = left.pop(0)
        is_early = SWEEP in left  # before a poor sweep is smoothed
        if not _is_tried(row, part, options, run, _Before(refused, best), enough=enough):
            continue
        if row == CELLS and is_searched and best is not None:
            continue  # they were looked for before the sweep was smoothed
        if best is None and row == CELLS and not is_early and is_own:
            _refuse_touching(part, refused, run)  # no cells fit in there, and to find that out takes a search
        try:
            with rows.share() as own:
                before = _Before(refused, best, 0.0 if enough else SECOND_LOOK if is_early and row == CELLS else share)
                is_searched |= row == CELLS
                own_run = first if row == SWEEP else replace(run, is_spare=run.is_spare or best is not None)
                mesh = WAYS[row](part, options, own_run, before)
        except PostponedError:
            left, first = [DESIGN, COLUMNS, CELLS, SWEEP, CELLS, FITTED], run
            continue
        except CadSweepError as error:
            # A refusal of the design speaks of faces that nobody knows, one of a grid says less than what came before,
            # and what is tried before a sweep is smoothed leaves that to say why.
            if best is not None or row in {DESIGN, FITTED} or is_early:
                log.info("no %s: %s", row.removeprefix("way: "), error)
                continue
            refused = foremost(refused, error)
            continue
        if best is None or worst_of(mesh) > worst_of(best):
            best, shares = mesh, {*own, row}
        # Cuts of the model itself may do better than a poor mesh that was carried onto it.
        good = reached_by(mesh, part.solids[0]) >= (SMOOTH_BELOW if row == DESIGN else GOOD_ENOUGH)
        # Layers along walls make a sweep poor at a sharp tip in the flow, which is as asked: cells lose some of them.
        is_judged = row == COLUMNS or (row == SWEEP and not options.wall_layers)
        if is_judged and len(part.solids[0].faces) <= _MOST_LOOKED_AT:
            good, share = is_as_good(mesh, part.solids[0]), SECOND_LOOK
        enough |= good or not _may_be_better(part, quality_of(mesh), options)
    if best is not None:
        rows.took(shares)
        return best if isinstance(best, BlockMesh) else made_of(with_last(best), part)
    assert refused is not None
    if not options.decompose and is_own:
        _refuse_touching(part, refused, run)
    raise refused


def _is_tried(row: str, part: Part, options: SweepOptions, run: Run, before: _Before, *, enough: bool) -> bool:
    """Whether a way is worth trying after what has been made; with `enough` only a design may be."""
    best = before.best
    if not rows.is_on(row) or (row in {CELLS, FITTED} and not options.decompose):
        return False
    if row == FITTED:
        return _is_fitted(part, options, before)
    if (best is not None or row == DESIGN) and run.is_over():
        return False
    if row != DESIGN:
        return not enough and (best is None or row != COLUMNS)  # columns along a poor sweep are as poor
    worst = 0.0 if best is None else worst_of(best)
    most = _MOST_POOR if worst < SMOOTH_BELOW else _MOST_CARRIED
    if best is not None and (worst >= GOOD_DESIGN or best.n_hexes > most):
        return False
    return _has_design(part, options, best)


def _is_fitted(part: Part, options: SweepOptions, before: _Before) -> bool:
    """Whether a fitted grid may do better than what there is, or do at all."""
    if before.best is None:
        tried = isinstance(before.refused, _MENDABLE)
    else:
        tried = rows.is_on(INSTEAD) and is_poor(before.best, part.solids[0], options)
    if not tried or options.fitted is False:
        return False
    from .fitted_grids import asked_in_vain

    return not asked_in_vain(options)


def _refuse_touching(part: Part, refused: CadSweepError | None, run: Run) -> None:
    """Raise what no way can mend: that faces of the solid touch, where that is looked for.

    Raises
    ------
    CadError
        The two faces and the place.
    """
    is_asked = len(part.solids[0].faces) <= _MOST_LOOKED_AT and not run.is_over()
    if refused is None or isinstance(refused, InputError) or not is_asked:
        return
    touching = touching_of(part.solids[0], refused)
    if touching is not None:
        raise touching


def _mesh_plainly(part: Part, options: SweepOptions, run: Run) -> AnyMesh:
    """By one sweep, by columns, or by the cuts that are given: without a search."""
    if options.cuts:
        from .complexes.decomposing import mesh_user_cut

        return mesh_user_cut(part, options, run)
    with rows.without([FITTED]):
        return _by_ways(part, options, run, is_own=False)


def _may_be_better(part: Part, report: QualityReport, options: SweepOptions) -> bool:
    """Whether cells may do better than a poor mesh: cuts are allowed, and no sharp edge of the part is to blame."""
    from .complexes.decomposing import may_decompose

    allowed = not options.allow_inverted and may_decompose(part, options)
    return allowed and not is_pointed(part.solids[0], report)


def _mesh_cells(part: Part, options: SweepOptions, run: Run, before: _Before) -> AnyMesh:
    """By cells of cuts."""
    from .complexes.decomposing import mesh_decomposed

    return _said(mesh_decomposed(part, options, run, before.refused, share=before.share, instead_of=before.best), CELLS)


def _mesh_fitted(part: Part, options: SweepOptions, run: Run, before: _Before) -> AnyMesh:
    """By a fitted grid, with all of a run's time again where that has no mesh to show for it or is over."""
    from .fitted_grids import mesh_fitted

    best = before.best
    why = "it was asked for" if before.refused is None else before.refused.what
    if best is not None:
        rows.took([INSTEAD])
        why = f"the worst scaled Jacobian by {best.info['way']} is {worst_of(best):.2g}"
    least = None if best is None else FAR_WORSE * worst_of(best)
    mesh = mesh_fitted(part, options, run.anew() if best is None or run.is_over() else run, why, least=least)
    return _said(mesh, FITTED)


def _said(mesh: AnyMesh, row: str) -> AnyMesh:
    """The mesh, with the way that it was made by in its record."""
    return replace(mesh, info={**mesh.info, "way": row.removeprefix("way: ")})


def _postpones(part: Part, options: SweepOptions, report: QualityReport, _: object) -> bool:
    """Whether a design or cells are tried before a poor sweep of a part is smoothed."""
    is_small = report.n_hexes <= MOST_SMOOTHED
    if is_small or report.min_scaled_jacobian >= GOOD_ENOUGH or is_of_placing(options) or options.wall_layers:
        return False
    from .wishes.design_words import speaks_of_entities

    few = len(part.solids[0].faces) <= _MOST_LOOKED_AT and options.decompose and rows.is_on(CELLS)
    has_design = rows.is_on(DESIGN) and report.n_hexes <= _MOST_POOR and not speaks_of_entities(options)
    return (few and _may_be_better(part, report, options)) or (has_design and _has_design(part, options))


def _has_design(part: Part, options: SweepOptions, best: AnyMesh | None = None) -> bool:
    from .designs import has_design

    return has_design(part, options, best)


def _mesh_design(part: Part, options: SweepOptions, run: Run, before: _Before) -> AnyMesh:
    """By its design, whose mesh says by what way it was made."""
    from .designs import mesh_design

    def mesh_it(design: Part, options: SweepOptions, run: Run) -> AnyMesh:
        others = [DESIGN, FITTED] if before.share else [DESIGN, FITTED, CELLS]  # no search where a mesh is there
        with rows.without(others):
            return _by_ways(design, options, run.for_share(DESIGN_LOOK), DESIGN_LOOK * before.share, is_own=False)

    return mesh_design(part, options, run, mesh_it)


def _mesh_columns(part: Part, options: SweepOptions, run: Run, before: _Before) -> AnyMesh:
    """By the best of its stacks."""
    from .columns.stacking import mesh_stacks_instead

    refused = before.refused or NotSweepableError("its sweep makes poor hexahedra")
    return _said(mesh_stacks_instead(part, options, run, refused), COLUMNS)


def _mesh_swept(part: Part, options: SweepOptions, run: Run, _: _Before) -> AnyMesh:
    """By one sweep; by columns rather than across walls that had to be divided for it, unless those are better."""
    opened, sweeps = find_candidates(part, options, run)
    made: list[AnyMesh] = []
    if any(note.startswith(cad.ANNULI_NOTE) for note in opened.notes[len(part.notes) :]):
        with suppress(*_MENDABLE):  # the sweep has the last word
            made.append(_mesh_columns(part, options, run, _Before(NotSweepableError("no sweep of the part as it is"))))
            if reached_by(made[0], part.solids[0]) >= SMOOTH_BELOW:
                return made[0]
    try:
        made.append(_said(first_good(opened, sweeps, options, run, _make_cell).mesh, SWEEP))
    except _MENDABLE:
        if not made:
            raise
    return max(made, key=worst_of)


def _make_cell(part: Part, sweep: Sweep, options: SweepOptions, run: Run) -> Made:
    """A candidate sweep, meshed as the one cell of its part."""
    from .complexes.several import mesh_judged
    from .complexes.swept import alone, wishes_of_sweep

    found = alone(part, sweep)
    # Nodes on the model's faces stay: what slides makes quads of very unlike lengths for the sake of their angles.
    mesh, shortfall = mesh_judged(found, options, run, wishes_of_sweep(found.part, sweep, options), slide=False)
    return Made(mesh=mesh, shortfall=shortfall)


WAYS = {
    SWEEP: _mesh_swept,
    COLUMNS: _mesh_columns,
    DESIGN: _mesh_design,
    CELLS: _mesh_cells,
    FITTED: _mesh_fitted,
}
"""The ways to a mesh of one solid, in the order in which they are tried."""
