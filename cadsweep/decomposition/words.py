"""What a decomposition says of itself: the cuts that were made, and what stood in the way where none do.

Place in the flow: ``pipeline`` puts these lines into notes, reports and refusals.
"""

from __future__ import annotations

from math import pi

from ..brep import Edge, Solid
from ..errors import NotSweepableError
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
    """Why no cuts were found: the cell and the edges that are left, and what was tried."""
    best = search.best
    name = f"'{search.model.name}'" if search.model.name else "the solid"
    tried = f"{search.n_states} sets of cuts were tried"
    if best.blocked:
        cell = search.look(best.cells[best.blocked[0]]).solid
        way = _in_the_way(cell)
        where = f"a cell at ({cell.units.place(cell.vertices.mean(axis=0))}) of {len(cell.faces)} faces has no sweep"
        message = (
            f"{name} cannot be swept, and no cuts were found: {where}{way}; {tried}, the best leave "
            f"{len(best.cells)} cells"
        )
    else:
        cells = [(search.look(best.cells[c]).solid.faces[f], c) for c, f in best.conflict]
        faces = " and ".join(face.label() for face, _ in cells[:2])
        message = (
            f"{name} cannot be swept, and no cuts were found that agree: {len(best.cells)} cells sweep, but not so "
            f"that their meshes meet on {faces or 'every face between them'}; {tried}"
        )
    if refused.advice:  # what to do comes first
        message = f"{refused.advice}; {message}"
    return NotSweepableError(message, reasons=refused.reasons, faces=refused.faces, advice=refused.advice)


def _in_the_way(cell: Solid) -> str:
    edges: list[Edge] = sorted((e for e in cell.edges if e.dihedral > pi + FLAT), key=lambda e: -e.length)
    if not edges:
        return ", though it has no re-entrant edge"
    places = "; ".join(cell.units.place(edge.midpoint) for edge in edges[:MOST_NAMED])
    return f": in the way are {len(edges)} re-entrant edges, at ({places})"


__all__ = ["explain", "say"]
