"""What both ways of cutting a ring open share: a solid of its faces, and which of them lie on the cut.

Place in the flow: called by :mod:`.rings` and :mod:`.closed`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from OCP.BRep import BRep_Builder
from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid


def solid_of(faces: Sequence[Any]) -> Any:
    """A solid of one closed shell of the faces, in their order, as they are."""
    builder = BRep_Builder()
    shell, solid = TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for face in faces:
        builder.Add(shell, face)
    shell.Closed(True)
    builder.MakeSolid(solid)
    builder.Add(solid, shell)
    return solid


def sides_of_cut(caps: Sequence[int], origins: Sequence[int | None]) -> tuple[frozenset[int], frozenset[int]]:
    """Ids of the present faces on either side of the cut, from its two faces and the origins of all faces."""
    one, other = (frozenset(j for j, origin in enumerate(origins) if origin == cap) for cap in caps)
    assert one
    assert other
    return one, other
