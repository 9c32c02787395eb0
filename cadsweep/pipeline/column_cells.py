"""A stack as a part of cells: its columns as solids, for who wants to see or to keep them."""

from __future__ import annotations

from dataclasses import replace

from .. import cad, stacks
from ..brep import Cut, Part
from ..errors import CadError, CadSweepError
from ..stack import Stack
from .stacking import find_stacks


def columns_of(part: Part) -> Part:
    """The columns of the first stack of a part of one solid whose cells OpenCASCADE makes.

    Raises
    ------
    NotSweepableError
        It is no stack.
    CadError
        OpenCASCADE parts the columns of none; says where that fails as a rule.
    """
    found = find_stacks(part)
    for stack in found:
        try:
            cells = cad.cut_columns(part, stack, list(stacks.touching_columns(stack)))
        except CadSweepError:
            continue  # what OpenCASCADE does not cut along one direction it may along another
        if cells is not None:
            reason = f"the outlines of the caps across ({_axis(stack)}), carried through: {stack.n_columns} columns"
            return replace(cells, cuts=(*part.cuts, Cut(kind="columns", reason=reason)))
    stack = found[0]
    why = ""
    if stack.rounded:
        why = f", as walls run tangent into {part.solids[0].faces[stack.rounded[0]].label()}"
    raise CadError(
        f"the {stack.n_columns} columns across ({_axis(stack)}) are meshed as they are, but OpenCASCADE does not part "
        f"them as solids{why}"
    )


def _axis(stack: Stack) -> str:
    return ", ".join(f"{c:.3g}" for c in stack.direction + 0.0)
