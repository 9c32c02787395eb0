"""What a decomposition says of itself: the cuts that were made, and what stood in the way where none do.

Place in the flow: ``pipeline`` puts these lines into notes, reports and refusals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import FloatArray
from ..brep import Edge, Solid
from ..errors import NotSweepableError
from .curved import CellSearch
from .search import FLAT, Search, State

MOST_NAMED = 3
"""Cuts or places named in a line."""


def say(search: Search, state: State) -> str:
    """One line on the cuts of a state."""
    if not state.cuts:
        return "filled with a block of hexahedra at every corner"
    cuts = list(dict.fromkeys(cut.reason for cut in state.cuts))
    more = f" and {len(cuts) - MOST_NAMED} more" if len(cuts) > MOST_NAMED else ""
    return f"cut into {len(state.cells)} cells, along {'; '.join(cuts[:MOST_NAMED])}{more}"


def explain(search: Search, refused: NotSweepableError) -> NotSweepableError:
    """Why no cuts by planes were found: the cell and the edges that are left, and what was tried."""
    best = search.best
    left = _Left(
        name=search.model.name,
        cells=[search.look(cell).solid for cell in best.cells],
        blocked=best.blocked,
        conflict=best.conflict,
        cuts=[cut.reason for cut in best.cuts],
        n_tried=search.n_states,
    )
    return _with_left(left, (), refused, search.ended_early)


def explain_cells(search: CellSearch, refused: NotSweepableError) -> NotSweepableError:
    """The same of cuts by surfaces of any kind, with those that parted no cell well."""
    best = search.best
    solids = best.part.solids
    left = _Left(
        name=solids[0].name,
        cells=solids,
        blocked=best.blocked,
        conflict=best.conflict,
        cuts=[cut.reason for cut in best.cuts],
        n_tried=search.n_parts,
    )
    failed = [f"parts no cell, or leaves slivers: {reason}" for reason, _ in search.refused.most_common()]
    return _with_left(left, failed, refused, search.ended_early)


def _with_left(left: _Left, more: Sequence[str], refused: NotSweepableError, ended_early: bool) -> NotSweepableError:
    """The refusal of a part that no cuts help either, which knows what is left of it."""
    name = f"'{left.name}'" if left.name else "the solid"
    early = ", ended by decompose_time" if ended_early else ""
    found = refused.about(
        f"{name} cannot be meshed: no sweep, no columns and no cuts fit it (sets of cuts tried: {left.n_tried}{early})",
        where=refused.where or left.place(),
        reasons=[*left.say(), *more],
    )
    found.left = left.outline()
    return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _Left:
    """What the best cuts leave in the way."""

    name: str | None
    cells: Sequence[Solid]
    blocked: Sequence[int]
    conflict: Sequence[tuple[int, int]]
    cuts: Sequence[str]
    n_tried: int

    def place(self) -> str:
        """The cell that has no sweep, or the faces on which cells do not agree."""
        if self.blocked:
            return _called(self.cells[self.blocked[0]])
        faces = dict.fromkeys(self.cells[cell].faces[face].label() for cell, face in self.conflict)
        return " and ".join(list(faces)[:2]) or "every face between the cells"

    def say(self) -> list[str]:
        """What the best cuts are, and for each cell why it has no sweep, or where cells do not agree."""
        cuts = list(dict.fromkeys(self.cuts))
        made = f" after cuts along {'; '.join(cuts)}" if cuts else ""
        lines = [f"{self.n_tried} sets of cuts were tried, the best leave {len(self.cells)} cells{made}"]
        if not self.blocked:
            lines.append(f"all cells can be filled, but not so that their meshes meet on {self.place()}")
        return [*lines, *(why_left(self.cells[number]) for number in self.blocked)]

    def outline(self) -> tuple[FloatArray, ...]:
        """The edges of all cells without sweep, or of the faces on which cells do not agree; model units."""
        if self.blocked:
            edges = [edge for number in self.blocked for edge in self.cells[number].edges]
        else:
            edges = [self.cells[c].edges[e] for c, f in self.conflict for e in self.cells[c].faces[f].edges]
        return outline_of(edges)


def outline_of(edges: Sequence[Edge]) -> tuple[FloatArray, ...]:
    """Edges as chains of points (m, 3), model units: what a picture of a refusal draws over the part."""
    at = np.linspace(0.0, 1.0, 33)
    return tuple(e.units.to_model(e.curve.evaluate(at[::32] if e.kind == "line" else at)) for e in edges)


def why_left(cell: Solid) -> str:
    """Which cell has no sweep, and the edges in the way."""
    return f"{_called(cell)} has no sweep{_in_the_way(cell)}"


def _called(cell: Solid) -> str:
    return f"a cell at ({cell.units.place(cell.vertices.mean(axis=0))}) of {len(cell.faces)} faces"


def _in_the_way(cell: Solid) -> str:
    edges: list[Edge] = sorted((e for e in cell.edges if e.dihedral > pi + FLAT), key=lambda e: -e.length)
    if not edges:
        return ", though it has no re-entrant edge"
    places = "; ".join(cell.units.place(edge.midpoint) for edge in edges[:MOST_NAMED])
    return f": in the way are {len(edges)} re-entrant edges, at ({places})"


__all__ = ["explain", "explain_cells", "outline_of", "say", "why_left"]
