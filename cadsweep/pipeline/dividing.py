"""Counts of all edges, and the boundary's mesh on them: again with shorter segments where a cap cannot be meshed.

A size that is larger than the part's features leaves narrow places of a cap without a mesh of quads. Segments twice
as short there, and there alone, mend that at the price of a few more hexes; the mesh's notes say so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from .. import estimate, intervals, surface
from ..brep import Part
from ..errors import SurfaceMeshError
from ..mesh import SurfaceMesh
from ..options import SweepOptions
from ..sweep import Intervals, Sweep
from .hints import Hints, resolve_hints
from .run import Run

MOST_HALVINGS = 3
"""How often the segments of an edge are halved before the part is refused."""


def mesh_boundary(
    part: Part, sweep: Sweep, options: SweepOptions, run: Run, *, streamed: bool
) -> tuple[Intervals, SurfaceMesh, list[str]]:
    """Settle the counts and mesh caps and sides.

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
    hints = resolve_hints(part, sweep, options)

    def attempt(sizes: dict[int, float]) -> tuple[Intervals, Callable[[], SurfaceMesh]]:
        counts = _count(part, sweep, options, run, Hints(sizes=sizes, counts=hints.counts), streamed=streamed)
        return counts, lambda: surface.mesh_surfaces(sweep, counts, bias=options.bias, fractions=options.fractions)

    return divide_until_meshed(sweep, hints.sizes, hints.counts, attempt, run)


def divide_until_meshed(
    sweep: Sweep,
    sizes: dict[int, float],
    demanded: Iterable[tuple[int, ...]],
    attempt: Callable[[dict[int, float]], tuple[Intervals, Callable[[], SurfaceMesh]]],
    run: Run,
) -> tuple[Intervals, SurfaceMesh, list[str]]:
    """Mesh a boundary, with segments twice as short wherever that could not be meshed.

    Parameters
    ----------
    sweep : Sweep
    sizes : dict of int to float
        Sizes of edges that the user asks for; they stay.
    demanded : edges whose counts are demanded; these stay, too
    attempt : callable
        Sizes of edges to their counts, and what meshes the boundary with these.
    run : Run
    """
    wished = dict(sizes)
    fixed = {e for edges in demanded for e in edges} | set(sizes)
    first: SurfaceMeshError | None = None
    for _ in range(1 + MOST_HALVINGS):
        counts, mesh = attempt(wished)
        try:
            with run.stage("surface"):
                surfaces = mesh()
        except SurfaceMeshError as error:
            first = first or error
            shorter = {
                e: sweep.solid.edges[e].length / (2 * int(counts.counts[e])) for e in error.edges if e not in fixed
            }
            if not shorter:
                raise first from None
            wished |= shorter
            continue
        finer = len(wished) - len(sizes)
        return counts, surfaces, [f"{finer} edges at narrow places divided finer than their size asks"] if finer else []
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
            sweep, size=size, layers=layers, edge_sizes=hints.sizes, edge_counts=hints.counts
        )
        expected = estimate.estimate(sweep, counts, scale=part.scale, streamed=streamed)
        estimate.check_budget(expected, max_hexes=options.max_hexes, max_memory=options.max_memory)
    return counts
