"""A part as it is meshed: cells, and how each is filled.

Place in the flow: :mod:`.complexes`, :mod:`.swept` and others make one; :mod:`.several` meshes it.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...brep import Part
from ...plan import Plan
from ...sweep import Sweep


@dataclass(frozen=True, kw_only=True, eq=False)
class Complex:
    """Cells with a filling for each; `model` is the part before it was cut, `sweep` that of a part of one cell."""

    part: Part
    plan: Plan
    model: Part
    sweep: Sweep | None = None
