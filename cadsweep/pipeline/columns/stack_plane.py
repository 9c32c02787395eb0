"""The arrangement of a stack meshed: again with shorter segments where that fails, or where quads are poor."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from typing import NamedTuple

from ... import stacks
from ...arrays import IntArray
from ...errors import SurfaceMeshError
from ...mesh import QuadMesh
from ...stack import Levels, Stack
from ...sweep import Intervals
from ..nearness.nearer import MOST_HALVINGS
from ..run import Run
from ..wishes.biases import say_graded
from ..wishes.stack_hints import StackHints

log = logging.getLogger(__name__)

MOST_REFINED = 3
"""How often the segments around poor quads are halved."""

MOST_UNFOLDED = 8
"""The same while a quad is folded on some level: no part is meshed with one."""

MOST_BLUNTED = 4
"""How often the segments beside a sharp corner are halved to open it."""

MOST_GROWTH = 3.0
"""Quads, as a multiple of those before, beyond which better ones are too dear."""

Attempt = Callable[[StackHints, dict[int, float]], tuple[Intervals, Callable[[], QuadMesh]]]


def mesh_plane(
    stack: Stack,
    levels: Levels,
    hints: StackHints,
    attempt: Attempt,
    run: Run,
    *,
    narrow: Callable[[StackHints, IntArray], StackHints] | None,
) -> tuple[QuadMesh, list[str]]:
    """Mesh the arrangement, again with shorter segments where cells are narrow, or have poor quads, while that helps.

    Cells whose quads are poor get segments as their widths ask for, all at once; where that is not enough, those
    around poor quads are halved.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    hints : StackHints
    attempt : callable
        Hints and sizes of edges to their counts, and what meshes the plane with these.
    run : Run
    narrow : callable
        Hints and counts to hints that have shorter segments at narrow places.

    Raises
    ------
    SurfaceMeshError
        A cell cannot be meshed with shorter segments either.
    """
    plane = hints.plane
    known, best, judged, hints, notes = _first_mesh(stack, levels, hints, attempt, run, narrow)
    finer = dict[int, float]()
    poor, whole = _to_halve(judged)
    fixed = hints.fixed
    for turn in range(MOST_UNFOLDED):
        if turn >= MOST_REFINED and judged.worst > 0.0:
            break
        shorter = {e: stack.arrangement.prism.edges[e].length / (2 * int(known.counts[e])) for e in poor - fixed}
        if not shorter:
            break
        try:
            counts, quads, more = _until_meshed(stack, hints, finer | shorter, attempt, run)
        except SurfaceMeshError as error:
            # What there is has been meshed already: the cells that fail stay as they are.
            fixed |= set(error.edges)
            if not shorter.keys() & set(error.edges):
                break
            continue
        finer |= shorter
        if len(quads.quads) > MOST_GROWTH * len(best.quads) and judged.worst > 0.0:
            break
        with run.stage("surface"):
            mended = stacks.mend_quads(stack, levels, quads)
            found = stacks.judge_plane(stack, levels, mended)
        # A cell that no division mends must not keep the others from what they gain.
        if found.rank >= judged.rank:
            finer = {e: size for e, size in finer.items() if e not in shorter}
            gained = _gained(stack, judged, found, shorter)
            if gained:
                poor, whole = gained, False
            elif whole:
                break
            else:
                # Segments that differ along one outline may be what is poor then: those of the whole cell are halved.
                poor, whole = judged.around, True
            continue
        best, judged, known = mended, found, counts
        poor, whole = _to_halve(judged)
        notes = [f"{len(finer)} outlines divided finer than their size asks, for better quads", *more]
    return best, [*notes, *say_graded(plane.divisions, plane.biased, dict(enumerate(known.counts.tolist())))]


class _Made(NamedTuple):
    """A mesh of the plane, how good it is, and from which hints it was made."""

    counts: Intervals
    quads: QuadMesh
    judged: stacks.Judged
    hints: StackHints
    notes: list[str]


def _first_mesh(  # noqa: PLR0917
    stack: Stack,
    levels: Levels,
    hints: StackHints,
    attempt: Attempt,
    run: Run,
    narrow: Callable[[StackHints, IntArray], StackHints] | None,
) -> _Made:
    """Mesh the plane with the sizes that are asked for, or with those that narrow places need where that is better."""

    def made(hints: StackHints, found: tuple[Intervals, QuadMesh, list[str]]) -> _Made:
        counts, quads, notes = found
        with run.stage("surface"):
            mended = stacks.mend_quads(stack, levels, quads)
            return _Made(counts, mended, stacks.judge_plane(stack, levels, mended), hints, notes)

    plain: _Made | None = None
    if narrow is None:
        return made(hints, _until_meshed(stack, hints, {}, attempt, run))
    counts, mesh = _blunted(stack, _wished(hints), hints.fixed, hints, attempt)
    try:
        with run.stage("surface"):
            quads = mesh()
        plain = made(hints, (counts, quads, []))
        if not plain.judged.lacking:
            return plain
    except SurfaceMeshError as error:
        log.info("one size for all cells: %s", error)
    finer = narrow(hints, counts.counts)
    try:
        fit = made(finer, _until_meshed(stack, finer, {}, attempt, run))
    except SurfaceMeshError as error:
        log.info("segments as short as cells are narrow: %s", error)
        return plain or made(hints, _until_meshed(stack, hints, {}, attempt, run))
    if plain is not None and plain.judged.rank <= fit.judged.rank:
        return plain
    return fit._replace(notes=["segments are shorter where outlines come near each other", *fit.notes])


def _gained(stack: Stack, before: stacks.Judged, after: stacks.Judged, shorter: Collection[int]) -> set[int]:
    """Those of the edges that were halved which no cell has come off badly by; none where all are."""
    prism = stack.arrangement.prism
    losers = {f for f in stack.arrangement.bottoms if after.lacks[f] > before.lacks[f]}
    found = {e for e in shorter if not losers.intersection(prism.edges[e].faces)}
    helped = any(after.lacks[f] < before.lacks[f] for e in found for f in prism.edges[e].faces)
    return found if helped and len(found) < len(shorter) else set()


def _to_halve(judged: stacks.Judged) -> tuple[set[int], bool]:
    """Edges around poor quads; all of the cells' where these are most of them anyway, and whether it is all.

    Folded quads come first: where few segments are halved, no cell elsewhere comes off badly.
    """
    if judged.folded:
        return judged.folded, False
    whole = 2 * len(judged.poor) >= len(judged.around)
    return (judged.around if whole else judged.poor), whole


def _wished(hints: StackHints) -> dict[int, float]:
    """Sizes of edges, those that were asked for before others."""
    wishes = hints.plane.wishes
    return {**wishes.most_sizes, **wishes.edge_sizes}


def _until_meshed(
    stack: Stack, hints: StackHints, finer: dict[int, float], attempt: Attempt, run: Run
) -> tuple[Intervals, QuadMesh, list[str]]:
    """Mesh a boundary, with segments twice as short wherever that could not be meshed; what was asked for stays."""
    wished = _wished(hints) | finer
    sizes = dict(wished)
    fixed = hints.fixed | set(finer)
    last: SurfaceMeshError | None = None
    for _ in range(1 + MOST_HALVINGS):
        counts, mesh = _blunted(stack, wished, fixed, hints, attempt)
        try:
            with run.stage("surface"):
                quads = mesh()
        except SurfaceMeshError as error:
            last = error
            shorter = {
                e: stack.plan.solid.edges[e].length / (2 * int(counts.counts[e])) for e in error.edges if e not in fixed
            }
            if not shorter:
                raise
            wished |= shorter
            continue
        n = sum(e not in sizes or size < sizes[e] for e, size in wished.items())
        return counts, quads, [f"{n} edges at narrow places divided finer than their size asks"] if n else []
    assert last is not None
    raise last


def _blunted(
    stack: Stack, wished: dict[int, float], fixed: set[int], hints: StackHints, attempt: Attempt
) -> tuple[Intervals, Callable[[], QuadMesh]]:
    """Counts with which no two outlines cross that part at a sharp corner; `wished` gets the sizes for them."""
    counts, mesh = attempt(hints, wished)
    for _ in range(MOST_BLUNTED):
        shorter = {e: size for e, size in stacks.divide_at_cusps(stack, counts.counts).items() if e not in fixed}
        if not shorter:
            break
        wished |= shorter
        counts, mesh = attempt(hints, wished)
    return counts, mesh
