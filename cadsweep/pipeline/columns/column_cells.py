"""A stack as a part of cells: its columns as solids, for who wants to see or to keep them."""

from __future__ import annotations

from dataclasses import replace

from ... import cad, stacks
from ...brep import Cut, Part
from ...errors import CadError, CadSweepError
from ...stack import name_direction
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
            cutter = cad.walls_between_columns(stack, list(stacks.touching_columns(stack)))
            parted = cad.split_cell(part, 0, cutter)
            cells = None if parted is None else parted.imprinted()
        except CadSweepError:
            continue  # what OpenCASCADE does not cut along one direction it may along another
        if cells is not None and len(cells.solids) == stack.n_columns:
            reason = cutter.reason
            if stack is not found[0]:
                meshed = f"{found[0].n_columns} across ({name_direction(found[0].direction)})"
                reason += f" (the part is meshed in {meshed}, which OpenCASCADE does not part as solids)"
            return replace(cells, cuts=(*part.cuts, Cut(kind=cutter.kind, reason=reason)))
    stack = found[0]
    why = ""
    if stack.rounded:
        why = f", as walls run tangent into {part.solids[0].faces[stack.rounded[0]].label()}"
    raise CadError(
        f"the {stack.n_columns} columns across ({name_direction(stack.direction)}) are meshed as they are, but "
        f"OpenCASCADE does not part them as solids{why}"
    )
