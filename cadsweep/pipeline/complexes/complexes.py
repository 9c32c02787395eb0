"""Which cells a part is meshed as, and how each is filled: a plan, found by cutting where the part as it is has none.

Place in the flow: :mod:`.assemblies` and :mod:`.decomposing` ask for a plan; :mod:`.several` meshes it.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import pi

from ... import cad, decomposition, recognition, rows, stacks
from ...blocks.joined import neighbours_of
from ...brep import Part, Solid
from ...decomposition.curved import CellSearch, Found, find_cells
from ...decomposition.tools import Cutter, Tools
from ...errors import CadSweepError, NotSweepableError, PlanError
from ...plan import Fill, Plan, list_ways, make_plan
from ...stack import Stack
from ...sweep import Sweep
from ..columns.stacking import find_stacks
from ..run import Run, silent
from .complex import Complex
from .subsets import subset

log = logging.getLogger(__name__)

COLUMNS = "cut: columns"
"""The row of solids that are cut into the columns that they are by themselves, where they touch others."""

_FEW = 2
"""Re-entrant edges of a cell up to which all readings of its faces are worth their time."""

_MOST_CONTACTS = 3
"""Contacts of a solid that a refusal lists."""


def plan_cells(part: Part, run: Run, *, decompose: bool = True) -> Complex:
    """The first of the plans of a part.

    Raises
    ------
    NotSweepableError
        As :func:`find_plans`.
    """
    return next(find_plans(part, run, decompose=decompose))


def find_plans(part: Part, run: Run, *, decompose: bool = True) -> Iterator[Complex]:
    """Find the sweeps of all cells, and choices of them that agree; cells that are in the way are cut.

    Raises
    ------
    NotSweepableError
        A cell has no sweep, or no choice agrees, and no cuts were found that mend it; names the cells and faces.
    """
    with run.stage("recognition"):
        candidates = recognition.sweeps_of_each(part.solids)
        plan: Plan | None = None
        try:
            plan = make_plan(part, candidates)
        except PlanError as error:
            if not decompose:
                raise _refused(part, candidates, error) from error
    if plan is not None:
        yield Complex(part=part, plan=plan, model=part)
        return
    search = CellSearch(cad.divide_corners(part) or part, cutting_tools(run))
    solutions = search.solutions()
    while True:
        with run.stage("decomposition"):
            solution = next(solutions, None)
        if solution is None:
            break
        yield as_complex(solution, part)
    log.info("%d parts looked at", search.n_parts)
    best = search.best
    if best.plan is None:
        raise _refused(best.part, recognition.sweeps_of_each(best.part.solids), None, best)


def plan_again(found: Complex, part: Part, model: Part) -> Complex:
    """The same cells, after something was done to their edges, with a plan of their own.

    Raises
    ------
    NotSweepableError
        They have none any more.
    """
    again, _ = find_cells(part, cutting_tools(Run(on_progress=silent)), most_parts=1)
    if again.plan is None:
        raise NotSweepableError(f"the cells have no plan with their tips bridged: {again.message}")
    return replace(found, part=replace(again.part, cuts=found.part.cuts), plan=again.plan, model=model)


def as_complex(found: Found, model: Part) -> Complex:
    """A part that has a plan, its notes saying what was cut of the model."""
    assert isinstance(found.plan, Plan), "it has one"
    notes = (*found.part.notes, *(f"cut along {cut}" for cut in found.cuts))
    return Complex(part=replace(found.part, notes=notes, cuts=(*model.cuts, *found.cuts)), plan=found.plan, model=model)


def with_caps_grown(found: Complex) -> Complex:
    """Cells that are to be meshed, caps joined to the halves of the roundings around them where all still agree so."""
    fills = [way.fill for way in found.plan.ways]
    caps = [(*fill.source, *fill.target) if isinstance(fill, Sweep) else () for fill in fills]
    joined = cad.join_halves(found.part, caps)
    if joined is None:
        return found
    try:
        return replace(found, part=joined, plan=make_plan(joined, [recognise(solid) for solid in joined.solids]))
    except PlanError as error:
        log.info("caps are not joined to their roundings: %s", error)
        return found


def cutting_tools(run: Run) -> Tools:
    """What the search for cuts through solids of any kind is given."""
    return Tools(
        recognise=recognise,
        make_plan=make_plan,
        find_cutters=partial(find_cutters, known={}),
        split=cad.split_cell,
        make_alike=with_outlines_alike,
        on_progress=lambda n: run.on_progress(say_open(n), None),
        is_late=run.is_late,
    )


def find_cutters(part: Part, cell: int, faces: Sequence[int], known: dict[object, list[Cutter]]) -> Iterator[Cutter]:
    """What may part a cell: a solid of several into the columns that it is by itself, and all that parts any cell.

    A part of one solid that is a stack has been meshed as one before cuts are looked for. `known`: the first of these,
    by solid, however often one is asked for.
    """
    solid = part.solids[cell]
    if len(part.models) > 1 and all(face.key for face in solid.faces) and rows.is_on(COLUMNS):
        if solid.kernel not in known:
            known[solid.kernel] = _between_columns(subset(part, [cell]))
        yield from known[solid.kernel]
    yield from cad.find_cutters(part, cell, faces)


def _between_columns(part: Part) -> list[Cutter]:
    """What parts a solid into columns, first along the directions in which the fewest contacts are in the way."""
    try:
        found = sorted(find_stacks(part), key=_islands)
        return [cad.walls_between_columns(stack, list(stacks.touching_columns(stack))) for stack in found]
    except CadSweepError as error:
        log.info("not cut into columns: %s", error)
        return []


def _islands(stack: Stack) -> int:
    """Holes in faces along a stack: what touches it there is in no outline of its caps, and in the way of columns."""
    caps = {*stack.source, *stack.target}
    return sum(len(face.loops) - 1 for face in stack.solid.faces if face.id not in caps)


def with_outlines_alike(part: Part, cells: Sequence[int]) -> Part | None:
    """The part with edges of cells without a sweep divided where that gives one a sweep; None where it gives none."""
    if not rows.is_on(recognition.ALIKE):
        return None
    found = {cell: recognition.find_divisions(part.solids[cell]) for cell in cells}
    places = {cell: divisions for cell, divisions in found.items() if divisions}
    then = cad.divide_edges(part, places) if places else None
    if then is None or not any(recognise(then.solids[cell]) for cell in places):
        return None
    rows.took([recognition.ALIKE])
    return then


def say_open(n: int) -> str:
    """The stage as the progress shows it: how many cells are in the way still."""
    return f"decomposition, {n} cells open" if n else "decomposition"


def recognise(solid: Solid) -> list[Fill]:
    """How a cell can be filled: sweeps that a plan can use, and blocks at its corners."""
    blocks = recognition.find_corner_blocks(solid)
    return [*_usable(solid), *([] if blocks is None else [blocks])]


def _usable(solid: Solid) -> list[Sweep]:
    """Sweeps found the fast way, and thoroughly only of cells that are nearly convex."""
    for most_readings in (1, None):
        sweeps = recognition.search_sweeps(solid, folds=False, most_readings=most_readings).sweeps
        usable = [sweep for sweep in sweeps if list_ways([sweep])]
        if usable or sum(edge.dihedral > pi + 1e-6 for edge in solid.edges) > _FEW:
            return usable
    return []


def _refused(
    part: Part, candidates: Sequence[Sequence[Sweep]], error: PlanError | None, found: Found | None = None
) -> NotSweepableError:
    """Why a part has no plan: the first cell without sweep and what it touches, or the faces that contradict."""
    cuts = [f"cut along {cut}" for cut in (found.cuts if found else ())]
    tried = f" after {len(cuts)} cuts" if cuts else ""
    stuck = [cell for cell, own in enumerate(candidates) if not own]
    refusal: NotSweepableError | None = None
    for cell in stuck:
        try:
            recognition.find_sweeps(part.solids[cell])
        except NotSweepableError as reason:
            name = part.models[part.owners[cell]].name
            others = _contacts(part, cell)
            beside = f", which touches {', '.join(others)}" if others else ""
            reasons = [f"{name}: {r}" for r in reason.reasons]
            known = [part.solids[cell].faces[f].known for f in reason.faces]
            refusal = NotSweepableError(
                f"'{name}'{beside}, cannot be swept{tried}" if others else f"'{name}' cannot be swept{tried}",
                where=reason.where,
                reasons=[
                    f"{name}: {reason.what}",
                    *(f"{name} touches {other}" for other in others),
                    *(f"{part.models[part.owners[j]].name}: {decomposition.why_left(part.solids[j])}" for j in stuck),
                    *cuts,
                    *reasons,
                ],
                faces=[f for f in known if f >= 0],
            )
            refusal.left = decomposition.outline_of([edge for j in stuck for edge in part.solids[j].edges])
            break
    if refusal is None:
        at = error.faces if error is not None else found.conflict if found else ()
        what, message = (error.what, error.message) if error is not None else 2 * (found.message if found else "",)
        where = error.where if error is not None else _place(part, at)
        refusal = NotSweepableError(f"{what}{tried}", where=where, reasons=[message, *cuts])
        edges = [part.solids[cell].edges[e] for cell, face in at for e in part.solids[cell].faces[face].edges]
        refusal.left = decomposition.outline_of(edges)
        stuck = [cell for cell, _ in at]
    refusal.solids = tuple(dict.fromkeys(part.models[part.owners[cell]].name for cell in stuck))
    return refusal


def _place(part: Part, faces: Sequence[tuple[int, int]]) -> str:
    """The first of the faces on which cells do not agree."""
    return next((part.solids[cell].faces[face].label() for cell, face in faces), "")


def _contacts(part: Part, cell: int) -> list[str]:
    """The solids that a cell touches, and where."""
    beyond = neighbours_of(part)
    found: dict[int, str] = {}
    for face in part.solids[cell].faces:
        other = beyond.get((cell, face.id))
        if other is not None and part.owners[other[0]] != part.owners[cell]:
            owner = part.owners[other[0]]
            found.setdefault(owner, f"'{part.models[owner].name}' on {face.label()}")
    return list(found.values())[:_MOST_CONTACTS]


__all__ = [
    "Complex",
    "as_complex",
    "cutting_tools",
    "find_plans",
    "plan_again",
    "plan_cells",
    "recognise",
    "say_open",
    "with_caps_grown",
]
