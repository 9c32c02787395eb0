"""What is said of solids that nearly touch, or nearly in line: widths, places, and what would close them.

Place in the flow: called by :mod:`.joining` with what :mod:`.gaps` and :mod:`.steps` found.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...brep import Part, Units
from .gaps import Gap
from .steps import Step

_MOST = 10
"""Notes of a kind; a badly placed assembly has hundreds of such places."""


def doubt_notes(part: Part, gaps: Sequence[Gap], steps: Sequence[Step]) -> list[str]:
    """One line for each two solids that are apart a little, the nearest first, and for each length of steps."""
    units = Units(part.scale, part.offset)
    notes = []
    pairs: dict[tuple[str, ...], list[Gap]] = {}
    for gap in sorted(gaps, key=lambda gap: gap.distance):
        pairs.setdefault(tuple(sorted(_name(part, cell) for cell in gap.cells)), []).append(gap)
    for (one, other), between in list(pairs.items())[:_MOST]:
        nearest, closing = between[0], _closing(max(gap.widest for gap in between) * part.scale)
        more = f" and {len(between) - 1} more places" if len(between) > 1 else ""
        notes.append(
            f"{one} and {other} are {nearest.distance * part.scale:.3g} apart at ({units.place(nearest.place)}){more} "
            f"and do not touch there; if they should, {closing} closes the gap"
        )
    if len(pairs) > _MOST:
        notes.append(f"{len(pairs) - _MOST} more pairs of solids are as little apart")
    alike: dict[str, list[Step]] = {}
    for step in steps:
        alike.setdefault(f"{step.length * part.scale:.2g}", []).append(step)
    for length, own in list(alike.items())[:_MOST]:
        names = list(dict.fromkeys(_name(part, cell) for step in own for cell in step.cells))
        on = ", ".join(names[:_MOST]) + (f" and {len(names) - _MOST} more" if len(names) > _MOST else "")
        edges = f"{len(own)} edges of {length} are" if len(own) > 1 else f"an edge of {length} is"
        notes.append(
            f"{edges} left at ({units.place(own[0].place)}) where outlines nearly coincide, on {on}; "
            f"{_closing(max(step.length for step in own) * part.scale)} makes them coincide"
        )
    if len(alike) > _MOST:
        notes.append(f"edges of {len(alike) - _MOST} other small lengths are left")
    return notes


def _closing(width: float) -> str:
    """The option that closes a width, a little more than it, in two digits."""
    step = 10.0 ** (math.floor(math.log10(width)) - 1)
    enough = step * math.ceil(1.1 * width / step - 1e-6)
    return f"touch={enough:.3g} (--touch {enough:.3g})"


def _name(part: Part, cell: int) -> str:
    return f"'{part.models[part.owners[cell]].name}'"
