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
    return _after_advice(left, left.say() + _ended(search.ended_early), refused)


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
    failed = [reason for reason, _ in search.refused.most_common(MOST_NAMED)]
    more = f"; these part no cell, or leave slivers: {'; '.join(failed)}" if failed else ""
    return _after_advice(left, left.say() + more + _ended(search.ended_early), refused)


def _ended(early: bool) -> str:
    return "; the search was ended by decompose_time: more of it may find cuts" if early else ""


def _after_advice(left: _Left, message: str, refused: NotSweepableError) -> NotSweepableError:
    """The refusal that begins with what to do about the part as it is, and knows what is left of it."""
    lead = f"{refused.advice}; " if refused.advice else ""
    columns = f"; {refused.columns}" if refused.columns else ""
    found = NotSweepableError(
        lead + message + columns, reasons=refused.reasons, faces=refused.faces, advice=refused.advice
    )
    found.columns = refused.columns
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

    def say(self) -> str:
        """One line: the cell or the faces, the edges, the cuts."""
        name = f"'{self.name}'" if self.name else "the solid"
        cuts = list(dict.fromkeys(self.cuts))[:MOST_NAMED]
        made = f" after cuts along {'; '.join(cuts)}" if cuts else ""
        tried = f"{self.n_tried} sets of cuts were tried, the best leave {len(self.cells)} cells{made}"
        if not self.blocked:
            faces = dict.fromkeys(self.cells[cell].faces[face].label() for cell, face in self.conflict)
            where = " and ".join(list(faces)[:2]) or "every face between them"
            return (
                f"{name} cannot be swept, and no cuts were found that agree: all cells can be filled, but not so that "
                f"their meshes meet on {where}; {tried}; cut it there: cuts=, or --cut"
            )
        cell = self.cells[self.blocked[0]]
        where = f"a cell at ({cell.units.place(cell.vertices.mean(axis=0))}) of {len(cell.faces)} faces has no sweep"
        return (
            f"{name} cannot be swept, and no cuts were found: {where}{_in_the_way(cell)}; {tried}; cut it there: "
            "cuts=, or --cut"
        )

    def outline(self) -> tuple[FloatArray, ...]:
        """The edges of the first cell without sweep, or of the faces on which cells do not agree; model units."""
        if self.blocked:
            edges = list(self.cells[self.blocked[0]].edges)
        else:
            edges = [self.cells[c].edges[e] for c, f in self.conflict for e in self.cells[c].faces[f].edges]
        return outline_of(edges)


def outline_of(edges: Sequence[Edge]) -> tuple[FloatArray, ...]:
    """Edges as chains of points (m, 3), model units: what a picture of a refusal draws over the part."""
    at = np.linspace(0.0, 1.0, 33)
    return tuple(e.units.to_model(e.curve.evaluate(at[::32] if e.kind == "line" else at)) for e in edges)


def _in_the_way(cell: Solid) -> str:
    edges: list[Edge] = sorted((e for e in cell.edges if e.dihedral > pi + FLAT), key=lambda e: -e.length)
    if not edges:
        return ", though it has no re-entrant edge"
    places = "; ".join(cell.units.place(edge.midpoint) for edge in edges[:MOST_NAMED])
    return f": in the way are {len(edges)} re-entrant edges, at ({places})"


__all__ = ["explain", "explain_cells", "outline_of", "say"]
