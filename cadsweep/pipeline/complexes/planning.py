"""The plan of an assembly as plain rows: which way every cell is swept, in which order, and what its contacts are."""

from __future__ import annotations

from typing import Any

from ...blocks.joined import neighbours_of
from ...brep import Part
from ...errors import NotSweepableError
from ...plan import Plan
from ...sweep import Sweep
from ..run import Run
from .complexes import plan_cells
from .subsets import subset, touching_groups


def describe_plan(part: Part, run: Run) -> dict[str, Any]:
    """How solids that touch are meshed together.

    Returns
    -------
    dict
        ``cells``: rows in the order of meshing, each with ``solid``, ``source`` and ``target`` (labels of faces; empty
        for blocks at corners), ``contacts`` (what each face that is shared is to the cell: ``[solid, role]``, the role
        ``cap`` or ``side``; of a cut the solid is the cell's own). ``refused``: why there is no plan, group by group.
        ``alone``: names of solids that share nothing, and are swept by themselves.
    """
    found: dict[str, Any] = {"cells": [], "refused": [], "alone": []}
    for cells in touching_groups(part):
        own = subset(part, cells)
        if len(cells) == 1:
            found["alone"].append(own.models[0].name)
            continue
        try:
            planned = plan_cells(own, run)
        except NotSweepableError as error:
            found["refused"].append(error.message)
            continue
        found["cells"] += [_row(planned.part, planned.plan, cell) for cell in planned.plan.order]
    return found


def _row(part: Part, plan: Plan, cell: int) -> dict[str, Any]:
    beyond = neighbours_of(part)
    fill = plan.ways[cell].fill
    faces = part.solids[cell].faces
    caps = (*fill.source, *fill.target) if isinstance(fill, Sweep) else ()
    contacts: dict[tuple[str, str], None] = {}
    for face in faces:
        other = beyond.get((cell, face.id))
        if other is not None:
            contacts[part.models[part.owners[other[0]]].name, "cap" if face.id in caps else "side"] = None
    return {
        "solid": part.models[part.owners[cell]].name,
        "source": [faces[f].label() for f in fill.source] if isinstance(fill, Sweep) else [],
        "target": [faces[f].label() for f in fill.target] if isinstance(fill, Sweep) else [],
        "contacts": [list(pair) for pair in contacts],
    }
