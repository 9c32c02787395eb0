"""A solid that no sweep fits, cut into cells that all sweep and agree, and meshed cell by cell.

The search (:mod:`cadsweep.decomposition`) gives one set of cells after the other, the likeliest first; the first whose
mesh does well is taken, and of several that do worse the best.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import islice, takewhile
from typing import Any, NamedTuple

import numpy as np

from ... import cad, decomposition, rows
from ...brep import Cut, Part, Solid
from ...decomposition.curved import MOST_OPENINGS, MOST_PARTS, CellSearch
from ...decomposition.search import MOST_STATES
from ...errors import CadError, CadSweepError, InputError, NotSweepableError
from ...options import SweepOptions
from ...plan import Fill, Plan, make_plan
from ..attempts import open_and_find
from ..candidates import SECOND_LOOK, SMOOTH_BELOW
from ..columns.column_cells import columns_of
from ..origin import AnyMesh, worst_of
from ..parts import load, only_solid
from ..run import Run, silent
from ..wishes.local_sizes import for_all_solids
from ..wishes.shared_hints import resolve_wishes
from .answering import answering
from .best import MOST_MESHED, BestCells
from .cells import expected_cells
from .complex import Complex
from .complexes import as_complex, cutting_tools, plan_cells, recognise, say_open
from .several import mesh_complex

log = logging.getLogger(__name__)

MOST_POINTED = 60
"""Planar complexes that are looked at where a star parts the solid: it has no inner corner, and needs few planes."""
MOST_MORE = 2.0
"""Hexahedra of cells of another search over those that there are, beyond which better ones are too dear."""
CHEAP = 30_000
"""Hexahedra that are never too many of cells in the place of a fair mesh."""
_WHOLE = 1e-9
"""Share of a part's volume by which the part itself, read again, may differ."""
_SHARE = 0.5
"""Of the time for cuts, for those beyond the user's: the rest is for the same part cut by itself, those last."""
_ONE_SWEEP = (
    "source",
    "target",
    "bias",
    "fractions",
    "rail_layers",
)


def is_planar(part: Part) -> bool:
    """Whether all faces of the one solid are planes."""
    return decomposition.is_planar(only_solid(part))


def may_decompose(part: Part, options: SweepOptions) -> bool:
    """Whether cuts may be looked for: what the user asks of one sweep cannot be had of several."""
    return len(part.solids) == 1 and all(getattr(options, name) is None for name in _ONE_SWEEP)


Recognise = Callable[[Solid], list[Fill]]


def _recognise_pieces(part: Part, refused: CadSweepError | None) -> Recognise:
    """Recognition for a search: where the part has a sweep, that is the poor one which it is to do better than."""
    whole = (1.0 - _WHOLE) * only_solid(part).volume

    def recognise_piece(solid: Solid) -> list[Fill]:
        return [] if solid.volume > whole else recognise(solid)

    return recognise if refused is not None else recognise_piece


class _Searched(NamedTuple):
    """A search: what it finds, whether it was ended before its budget was used up, and what it says where it fails.

    Told which cells of what it found last make poor hexahedra, it cuts these further.
    """

    solutions: Iterator[Complex]
    ended_early: Callable[[], bool]
    refusal: Callable[[NotSweepableError], NotSweepableError]
    cut_again: Callable[[Sequence[int]], None]


def _by_surfaces(part: Part, recognise_piece: Recognise, run: Run, share: float) -> _Searched:
    """Cuts by surfaces of any kind, made by OpenCASCADE."""
    with run.stage("decomposition"):
        search = CellSearch(
            cad.divide_corners(part) or part,
            replace(cutting_tools(run), recognise=recognise_piece),
            most_parts=round(share * MOST_PARTS),
            most_openings=round(share * MOST_OPENINGS),
        )
    return _Searched(
        (as_complex(found, part) for found in search.solutions()),
        lambda: search.ended_early,
        lambda refused: decomposition.explain_cells(search, refused),
        search.cut_again,
    )


def _by_planes(part: Part, recognise_piece: Recognise, run: Run, share: float) -> _Searched:
    """Cuts of a solid of plane faces by planes, on polygons: ten times as many are looked at in the same time."""
    solid = only_solid(part)
    is_convex = max(edge.dihedral for edge in solid.edges) < np.pi
    search = decomposition.Search(
        model=solid,
        recognise=recognise_piece,
        make_plan=make_plan,
        most_states=MOST_POINTED if is_convex and cad.from_inside(solid) else round(share * MOST_STATES),
        is_late=run.is_late,
        on_progress=lambda n: run.on_progress(say_open(n), None),
    )
    return _Searched(
        (_planned(part, search, state) for state in search.solutions()),
        lambda: search.ended_early,
        lambda refused: decomposition.explain(search, refused),
        search.cut_again,
    )


SURFACES, PLANES = "search: surfaces", "search: planes"
SEARCHES = {PLANES: _by_planes, SURFACES: _by_surfaces}
"""The searches for cuts, in the order in which they are tried; planes part solids of plane faces alone."""


def mesh_decomposed(
    part: Part,
    options: SweepOptions,
    run: Run,
    refused: CadSweepError | None,
    *,
    share: float = 1.0,
    instead_of: AnyMesh | None = None,
) -> AnyMesh:
    """Cut a solid into cells, with a share of the budget of a search, and mesh them: what does well first, or the best.

    Instead of a mesh that is fair none of very many more hexahedra is made.

    Raises
    ------
    NotSweepableError
        No cuts were found; names the cell and the edges in the way, and what was tried.
    SurfaceMeshError, ProjectionError, InvertedHexError
        Cells were found, and none of their meshes is valid.
    """
    options = for_all_solids(part, options)
    recognise_piece = _recognise_pieces(part, refused)
    refused = refused or NotSweepableError("its sweep makes poor hexahedra")
    searches = [row for row in SEARCHES if rows.is_on(row) and (row != PLANES or is_planar(part))]
    if not may_decompose(part, options) or not searches:
        raise refused
    best: AnyMesh | None = None
    failure: CadSweepError | None = None
    shares: set[str] = set()
    most = np.inf
    if instead_of is not None and worst_of(instead_of) >= SMOOTH_BELOW:
        most = max(MOST_MORE * instead_of.n_hexes, CHEAP)
    for row in searches:
        if best is not None and (worst_of(best) >= SMOOTH_BELOW or run.is_over()):
            break
        searched = SEARCHES[row](part, recognise_piece, run, share if best is None else min(share, SECOND_LOOK))
        solutions = searched.solutions
        if best is not None:  # what is much better is so not by many more hexahedra
            most = min(most, MOST_MORE * best.n_hexes)
        if most < np.inf:
            solutions = takewhile(partial(_has_at_most, most, options), islice(solutions, MOST_MESHED))
        with rows.share() as own:
            reached = -np.inf if best is None else worst_of(best)
            mesh, error = BestCells(searched.cut_again, options, run).of_all(solutions, reached)
        failure = failure or error
        if mesh is not None and (best is None or worst_of(mesh) > worst_of(best)):
            best, shares = _ended_early(mesh, run) if searched.ended_early() else mesh, {*own, row}
    if best is not None:
        rows.took(shares)
        return best
    if failure is not None or not isinstance(refused, NotSweepableError):
        raise failure or refused
    raise searched.refusal(refused)


def _has_at_most(most: float, options: SweepOptions, found: Complex) -> bool:
    """Whether no more than so many hexahedra are to be expected of cells."""
    return expected_cells(found.part, found.plan, resolve_wishes(found.part, options, found.model)).n_hexes <= most


def _planned(part: Part, search: decomposition.Search, state: decomposition.State) -> Complex:
    assert isinstance(state.plan, Plan)
    return Complex(part=cells_of(part, search, state), plan=state.plan, model=part)


def _ended_early(mesh: AnyMesh, run: Run) -> AnyMesh:
    note = f"the search for cuts was ended after {run.decompose_time:g} s (decompose_time): the best found are taken"
    return replace(mesh, info={**mesh.info, "notes": [*mesh.info["notes"], note]})


def mesh_user_cut(part: Part, options: SweepOptions, run: Run) -> AnyMesh:
    """Cut a part as its user asks, and mesh the cells; those that no sweep fits are cut further.

    Raises
    ------
    InputError
        A cut is not understood, or parts nothing.
    NotSweepableError, SurfaceMeshError, ProjectionError, InvertedHexError
        As for any cells.
    """
    if any(getattr(options, name) is not None for name in _ONE_SWEEP):
        names = f"{', '.join(_ONE_SWEEP[:-1])} and {_ONE_SWEEP[-1]}"
        raise InputError(f"{names} are about one sweep, and cuts make several")
    with run.stage("decomposition"):
        cut = cad.apply_cuts(part, options.cuts or ())
    try:
        found = plan_cells(cut, run.for_share(_SHARE), decompose=options.decompose)
    except NotSweepableError as refused:
        if not options.decompose:
            raise
        try:
            found = _cut_last(part, options, run)
        except NotSweepableError:
            raise refused from None
    found = answering(replace(found, model=part), options, run)
    options = for_all_solids(part, options)
    return mesh_complex(replace(found, model=part), options, run, resolve_wishes(found.part, options, part))


def _cut_last(part: Part, options: SweepOptions, run: Run) -> Complex:
    """The cells of a part as it is, cut as its user asks: a swept cell is often one on both sides of a cut.

    Raises
    ------
    NotSweepableError
        Why the part has no cells, or these none after the cuts.
    """
    return plan_cells(cad.apply_cuts(plan_cells(part, run).part, options.cuts or ()), run)


def decompose(source: Any, *, cuts: Sequence[Any] = (), params: dict[str, Any] | None = None) -> Part:
    """Cut a part into cells that all sweep and agree, as :func:`cadsweep.sweep_mesh` does unasked.

    Parameters
    ----------
    source : Part, or whatever :func:`cadsweep.load` takes
    cuts : sequence
        Cuts of the user's own, made first, as the option ``cuts`` of :func:`cadsweep.sweep_mesh`.
    params : dict or None
        Parameters of a script.

    Returns
    -------
    Part
        Its ``solids`` are the cells, ``cuts`` says what was cut and why; of a stack they are its columns. A part that
        sweeps as it is, or is filled with a block at every corner, comes back as it is.

    Raises
    ------
    NotSweepableError
        No cuts were found; names the cell and the edges in the way.

    Examples
    --------
    >>> import cadsweep as cs
    >>> cells = cs.decompose("models/bracket.step")
    >>> len(cells.solids) > 1, len(cells.models)
    (True, 1)
    >>> print(cells.cuts[0].kind, "of", cells.cuts[0].reason.split(" (")[0])
    plane of face 12
    """
    part = load(source, params=params)
    run = Run(on_progress=silent)
    if cuts:
        part = replace(
            cad.apply_cuts(part, cuts),
            cuts=tuple(Cut(kind="asked", reason=f"asked for: {cad.name_of_cut(cut)}") for cut in cuts),
        )
    elif len(part.solids) == 1:
        try:
            open_and_find(part, None, None)
            return part
        except NotSweepableError as refused:
            try:
                return columns_of(part)
            except NotSweepableError:
                pass
            except CadError as error:
                part = replace(part, notes=(*part.notes, error.message))
            if is_planar(part):
                with suppress(NotSweepableError):
                    return _planar_cells(part, refused)
    return plan_cells(part, run).part


def _planar_cells(part: Part, refused: NotSweepableError) -> Part:
    """The first cells found, as OpenCASCADE's solids."""
    search = decomposition.Search(model=only_solid(part), recognise=recognise, make_plan=make_plan)
    for state in islice(search.solutions(), MOST_MESHED):
        if not state.cuts:
            return part
        facets = search.cut_facets(state)
        polygons = [
            (np.array(facet.normal), [np.array([search.pool.points[v] for v in loop]) for loop in facet.loops])
            for facet in facets
        ]
        cells = cad.cut_along(part, polygons)
        if cells is not None and len(cells.solids) == len(state.cells):
            cuts = tuple(
                Cut(
                    kind="plane",
                    reason=cut.reason,
                    place=_place(part, [facet for facet in facets if facet.origin == -1 - j]),
                )
                for j, cut in enumerate(state.cuts)
            )
            return replace(cells, cuts=cuts, notes=(*cells.notes, decomposition.say(search, state)))
    raise decomposition.explain(search, refused)


def _place(part: Part, facets: Sequence[Any]) -> tuple[float, float, float] | None:
    """The middle of what is left of a cut, model units; None where other cuts took all of it."""
    if not facets:
        return None
    middle = np.average([facet.center for facet in facets], axis=0, weights=[abs(facet.area) for facet in facets])
    x, y, z = part.to_model(middle).tolist()
    return x, y, z


def cells_of(part: Part, search: decomposition.Search, state: decomposition.State) -> Part:
    """The cells of a state as a part: all of them pieces of its one solid."""
    return replace(
        part,
        solids=tuple(search.look(cell).solid for cell in state.cells),
        owners=(0,) * len(state.cells),
        notes=(*part.notes, decomposition.say(search, state)),
    )


__all__ = ["cells_of", "decompose", "is_planar", "may_decompose", "mesh_decomposed", "mesh_user_cut", "recognise"]
