"""Counts of all edges, and the boundary's mesh on them: again with shorter segments where a cap cannot be meshed.

A size that is larger than the part's features leaves narrow places of a cap without a mesh of quads. Segments twice
as short there, and there alone, mend that at the price of a few more hexes; the mesh's notes say so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ... import estimate, intervals, surface
from ...brep import Part
from ...errors import InputError, SurfaceMeshError
from ...mesh import SurfaceMesh
from ...options import SweepOptions
from ...sweep import Intervals, Sweep
from ..run import Run
from ..wishes.biases import say_graded, splits_of
from ..wishes.hints import Hints
from ..wishes.periodic_sides import cap_motion, side_motions, tied_counts
from ..wishes.wall_corners import finer_at_corners
from ..wishes.walls import WallPlan, plan_walls

MOST_HALVINGS = 3
"""How often the segments of an edge are halved before the part is refused."""


def mesh_boundary(
    part: Part,
    sweep: Sweep,
    options: SweepOptions,
    run: Run,
    hints: Hints,
    *,
    streamed: bool,
    check: Callable[[estimate.Estimate], None],
) -> tuple[Intervals, SurfaceMesh, list[str]]:
    """Settle the counts and mesh caps and sides.

    Parameters
    ----------
    hints : Hints
    check : callable
        Raises where the mesh, as it is expected or made, is too large; beside the limits of the options.

    Returns
    -------
    counts : Intervals
    surfaces : SurfaceMesh
    notes : list of str
        What was divided finer than asked for.

    Raises
    ------
    InputError, SurfaceMeshError
        As by the stages; a cap that cannot be meshed with shorter segments either.
    """
    walls = WallPlan()
    if options.wall_layers:
        rough = _count(part, sweep, options, run, hints, streamed=streamed)
        walls = plan_walls(part, sweep, options, rough)
        clash = sorted(walls.ends.keys() & hints.divisions.keys())
        if clash:
            raise InputError(
                f"{sweep.solid.edges[clash[0]].label()}: a bias, and wall layers that end there, cannot both be"
            )
        spoken = {e for edges in hints.counts for e in edges}
        hints = replace(hints, counts=hints.counts | {es: n for es, n in walls.counts.items() if spoken.isdisjoint(es)})
        if not hints.matches:  # what answers another face is divided as that is
            known = {e.id: e.length / max(1, int(rough.counts[e.id])) for e in sweep.solid.edges}
            kept = spoken.union(walls.ends, hints.divisions if options.biases else ())
            sizes, divisions = finer_at_corners(sweep, walls.edges, known, hints.divisions, kept=kept)
            hints = replace(hints, sizes=hints.sizes | sizes, divisions=hints.divisions | divisions)
    if hints.matches:
        rough = _count(part, sweep, options, run, hints, streamed=streamed)
        hints = replace(hints, counts=hints.counts | tied_counts(sweep, hints.matches, rough, hints.counts))
    wished = dict(hints.sizes)
    demanded = {e for edges in hints.counts for e in edges}
    first: SurfaceMeshError | None = None
    for _ in range(1 + MOST_HALVINGS):
        counts = _count(part, sweep, options, run, replace(hints, sizes=wished), streamed=streamed)
        expected = estimate.estimate(sweep, counts, scale=part.scale, streamed=streamed)
        run.expects(expected)
        check(expected)
        try:
            with run.stage("surface"):
                surfaces = surface.mesh_surfaces(
                    sweep,
                    counts,
                    bias=options.bias,
                    fractions=options.fractions,
                    sizes=hints.inside,
                    divisions=hints.divisions,
                    alone=walls.divisions(sweep),
                    walls=walls.walls if walls.edges else None,
                    cap_heights=walls.cap_heights,
                    matched=side_motions(sweep, hints.matches),
                    matched_caps=cap_motion(sweep, hints.matches),
                )
        except SurfaceMeshError as error:
            first = first or error
            shorter = {
                e: sweep.solid.edges[e].length / (2 * int(counts.counts[e]))
                for e in error.edges
                if e not in hints.wished and e not in demanded
            }
            if not shorter:
                raise first from None
            wished |= shorter
            continue
        made = estimate.estimate_made(sweep, counts, surfaces, scale=part.scale, streamed=streamed)
        estimate.check_budget(made, max_hexes=options.max_hexes, max_memory=options.max_memory)
        check(made)
        finer = sum(e not in hints.sizes or wished[e] < hints.sizes[e] for e in wished)
        notes = [f"{finer} edges at narrow places divided finer than their size asks"] if finer else []
        notes += [
            *dict.fromkeys(walls.notes),
            *say_graded(hints.divisions, hints.divisions, dict(enumerate(counts.counts.tolist()))),
        ]
        return counts, surfaces, notes
    assert first is not None
    raise first


def _count(part: Part, sweep: Sweep, options: SweepOptions, run: Run, hints: Hints, *, streamed: bool) -> Intervals:
    """Counts of all edges, within the limits of hexes and memory."""
    size = None if options.size is None else options.size / part.scale
    layers = options.layers if options.fractions is None else len(options.fractions) - 1
    with run.stage("intervals"):
        rough = estimate.estimate_size(
            sweep,
            size=size,
            layers=layers,
            edge_sizes=hints.sizes,
            edge_counts=hints.counts,
            scale=part.scale,
            streamed=streamed,
        )
        if rough is not None:
            estimate.check_budget(rough, max_hexes=options.max_hexes, max_memory=options.max_memory)
        counts = intervals.assign_intervals(
            sweep,
            size=size,
            layers=layers,
            edge_sizes=hints.sizes,
            edge_counts=hints.counts,
            splits=splits_of(hints.divisions),
        )
        expected = estimate.estimate(sweep, counts, scale=part.scale, streamed=streamed)
        estimate.check_budget(expected, max_hexes=options.max_hexes, max_memory=options.max_memory)
    return counts
