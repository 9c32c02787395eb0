"""A stack as a part of cells: its columns as solids, for who wants to see or to keep them."""

from __future__ import annotations

from dataclasses import replace

from .. import cad, stacks
from ..brep import Cut, Part
from ..errors import CadSweepError, NotSweepableError
from .stacking import find_stacks


def columns_of(part: Part) -> Part | None:
    """The columns of the first stack of a part of one solid whose cells OpenCASCADE makes; None where there is none."""
    try:
        found = find_stacks(part)
    except NotSweepableError:
        return None
    for stack in found:
        try:
            cells = cad.cut_columns(part, stack, list(stacks.touching_columns(stack)))
        except CadSweepError:
            continue  # what OpenCASCADE does not cut along one direction it may along another
        if cells is not None:
            axis = ", ".join(f"{c:.3g}" for c in stack.direction + 0.0)
            reason = f"the outlines of the caps across ({axis}), carried through: {stack.n_columns} columns"
            return replace(cells, cuts=(*part.cuts, Cut(kind="columns", reason=reason)))
    return None
