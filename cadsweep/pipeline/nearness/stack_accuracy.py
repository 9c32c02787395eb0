"""Stacks as near to the CAD model as is asked for: outlines of what sags divided finer, and all quads over them.

The limits are those of other meshes (:mod:`.cells_accuracy`). The plane shows how outlines turn, and nothing of how
caps do: a half bore across the columns is a strip of straight lines there. So what was made is measured against the
faces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import ceil

from ...arrays import IntArray
from ...blocks.cells import CellBlocks
from ...blocks.joined import JoinedMesh
from ...brep import Part
from ...mesh import QuadMesh
from ...options import SweepOptions
from ...stack import Stack
from ...stack_mesh import Placed
from ..run import Run
from ..wishes.stack_hints import StackHints
from .cells_accuracy import LEAST_MORE, SHARE, Judged, nearest
from .measured import Found, edge_sag, keeps_shape, measure
from .nearer import check_most


@dataclass(frozen=True, kw_only=True, eq=False)
class MadeStack:
    """A stack's mesh, the plane's quads that it is made of, and notes."""

    quads: QuadMesh
    placed: Placed
    joined: JoinedMesh | CellBlocks
    notes: list[str]


def accurate_stack(  # noqa: PLR0917
    part: Part,
    stack: Stack,
    options: SweepOptions,
    run: Run,
    hints: StackHints,
    make: Callable[[StackHints], MadeStack],
) -> tuple[MadeStack, Found | None]:
    """Mesh a stack as near to the CAD faces as is asked for; with how far it is off, where that was asked.

    Raises
    ------
    SurfaceMeshError
        The first mesh cannot be made.
    """
    first = make(hints)
    if keeps_shape(part, first.joined, options):
        return first, None

    def judged(made: MadeStack) -> Judged[MadeStack]:
        with run.stage("quality"):
            return Judged(made, measure(part, made.joined, options))

    def finer(last: Judged[MadeStack], hints: StackHints, _: int) -> StackHints | None:
        made, found = last
        check_most(options, len(part.models), made.joined.n_hexes * found.most_needed**2)
        sizes = _finer(part, stack, made, found, hints)
        if not sizes:
            return None
        known = dict(hints.plane.wishes.edge_sizes)
        others = {e: size for e, size in sizes.items() if e not in known}
        return hints.on_plane(edge_sizes=known | {e: sizes[e] for e in known.keys() & sizes.keys()}).finer(others)

    best, notes = nearest(part, judged(first), hints, options, run, make=lambda hints: judged(make(hints)), finer=finer)
    return replace(best.made, notes=[*best.made.notes, *notes]), best.found


def _finer(part: Part, stack: Stack, made: MadeStack, found: Found, hints: StackHints) -> dict[int, float]:
    """Sizes of edges of the arrangement that make the quads on faces that are too far off finer.

    Under a wall these are its outlines; under a cap those around all cells below it, of which those that follow an edge
    of the cap count where it bends. Those whose count the user gave stay.
    """
    arrangement, prism = stack.arrangement, stack.arrangement.prism
    spoken = hints.demanded | hints.plane.divisions.keys()
    below: dict[int, list[int]] = {}
    for own, over in arrangement.over.items():
        for edge in over:
            below.setdefault(edge, []).append(own)
    factors: dict[int, float] = {}
    for (cell, face), needed in found.needed.items():
        edges = stack.solid.faces[face].edges
        cells = [f for f, caps in zip(arrangement.bottoms, arrangement.caps, strict=True) if face in caps]
        around = {e for f in cells for e in prism.faces[f].edges} | {e for edge in edges for e in below.get(edge, ())}
        straight = {
            own
            for edge in edges
            if edge_sag(part, made.joined, cell, edge) <= SHARE * found.sags[cell, face]
            for own in below.get(edge, ())
        }
        for e in (around - straight or around) - spoken:
            factors[e] = max(factors.get(e, 1.0), needed)
    return _sizes(stack, made.quads.edge_nodes, factors)


def _sizes(stack: Stack, nodes: Mapping[int, IntArray], factors: dict[int, float]) -> dict[int, float]:
    edges = stack.arrangement.prism.edges
    sizes = dict[int, float]()
    for e, factor in factors.items():
        count = len(nodes[e]) - 1
        sizes[e] = edges[e].length / (count + max(LEAST_MORE, ceil(count * (factor - 1.0))))
    return sizes


__all__ = ["MadeStack", "accurate_stack"]
