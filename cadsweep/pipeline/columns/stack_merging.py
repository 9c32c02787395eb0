"""A stack whose outlines that nearly coincide in plan were laid together, for its mesh alone."""

from __future__ import annotations

import logging

from ... import cad, stacks
from ...errors import CadError, NotSweepableError
from ...stack import Stack

log = logging.getLogger(__name__)

_SHARES = (1.0, 0.5, 0.25)
"""Parts of the distance that is near with which it is tried, until the outlines make cells again."""


def merged_stack(stack: Stack, size: float) -> Stack:
    """Lay outlines together that are nearer to each other than a share of a size, where the part allows it.

    Parameters
    ----------
    stack : Stack
    size : float
        Of the mesh in the plane, working units.
    """
    sides = None
    for share in _SHARES:
        found = stacks.merge_outlines(stack, share * stacks.NEAR * size)
        if found is None:
            return stack
        sides = sides or stacks.read_sides(stacks.Normals(stack.solid), stack.direction)
        try:
            arrangement = cad.rearrange(stack.solid, stack.direction, sides.caps, stack.arrangement, *found)
            made = stacks.make_stack(stack.solid, sides, stack.stations, arrangement)
            stacks.find_sheets(made)
        except (CadError, NotSweepableError) as error:
            log.info("outlines nearer than %g are not laid together: %s", share * stacks.NEAR * size, error)
            continue
        return made
    return stack
