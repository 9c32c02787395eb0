"""Numbers of layers that are asked for, and why they cannot be had.

Place in the flow: foundation of :mod:`.levels`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from ..errors import InputError
from ..stack import Stack
from .sheets import Sheets

_MOST_NAMED = 6
"""Caps that a message names."""


class Wanted(NamedTuple):
    """So many layers between two sheets; `whole` where it is the user's number for the whole stack."""

    low: int
    high: int
    n: int
    whole: bool = False


def minimal(wanted: Sequence[Wanted], is_feasible: Callable[[Sequence[Wanted]], bool]) -> list[Wanted]:
    """Those that contradict each other, none of which could be left out."""
    kept = list(wanted)
    for one in wanted:
        others = [other for other in kept if other is not one]
        if not is_feasible(others):
            kept = others
    return kept


def refusal(stack: Stack, sheets: Sheets, wanted: Sequence[Wanted]) -> InputError:
    """Say which numbers cannot be had, and what of the part is in the way."""
    named = [_name(stack, sheets, one) for one in wanted]
    if len(wanted) == 1:
        chain = _chain(sheets, wanted[0].low, wanted[0].high)
        caps = [label_of(stack, sheets, sheet) for sheet in chain]
        if len(caps) > _MOST_NAMED:
            caps[_MOST_NAMED - 1 : -1] = [f"{len(caps) - _MOST_NAMED} more"]
        return InputError(
            f"{named[0]} cannot be had: {', '.join(caps)} lie over each other, with a layer or more between each two, "
            f"so take {len(chain) - 1} or more"
        )
    return InputError(f"{' and '.join(named)} contradict each other: change or drop one of them")


def label_of(stack: Stack, sheets: Sheets, sheet: int) -> str:
    """How messages name a sheet: by its first cap, or its first station."""
    faces = (stack.solid.faces[f].label() for f, own in sheets.caps.items() if own == sheet)
    edges = (stack.solid.edges[e].label() for e, own in sheets.stations.items() if own == sheet)
    return next(faces, "") or next(edges)


def _name(stack: Stack, sheets: Sheets, one: Wanted) -> str:
    if one.whole:
        return f"layers = {one.n}"
    low, high = (label_of(stack, sheets, sheet) for sheet in (one.low, one.high))
    return f"{one.n} layer{'s' if one.n != 1 else ''} from {low} to {high}"


def _chain(sheets: Sheets, low: int, high: int) -> list[int]:
    """The longest chain of sheets over each other from one to another, these with it."""
    depth, under = {low: 0}, dict[int, int]()
    # Sheets do not lie over each other in a circle, so that this ends.
    changed = True
    while changed:
        changed = False
        for a, b in sheets.over:
            if a in depth and depth.get(b, -1) <= depth[a]:
                depth[b], under[b], changed = depth[a] + 1, a, True
    chain = [high]
    while chain[-1] in under and chain[-1] != low:
        chain.append(under[chain[-1]])
    return chain[::-1] if chain[-1] == low else [low, high]


__all__ = ["Wanted", "label_of", "minimal", "refusal"]
