"""What both ways of cutting a ring open share: the opened solid from its faces, and which of them lie on the cut.

Place in the flow: called by :mod:`.rings` and :mod:`.closed`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid
from OCP.TopTools import TopTools_ListOfShape

from ...brep import Solid
from ..extract.labels import Labels, label_of
from ..extract.shared import PartGeometry
from ..extract.solids import extract_solid
from ..heal.divide import divide_closed
from ..heal.tracing import Traced
from ..heal.validate import check_closed
from ..shapes import EDGE, FACE, index_map, mapped, subshapes
from ..trial import attempted
from .edge_labels import find_edge_labels


def cross_section(shape: Any, face: Any) -> list[Any]:
    """The pieces of a face that lie in a solid; none where OpenCASCADE fails at it."""
    common, arguments, tools = BRepAlgoAPI_Common(), TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(shape)
    tools.Append(face)
    common.SetArguments(arguments)
    common.SetTools(tools)
    done = attempted(common.Build, "finding a cross-section", on=[shape])
    return subshapes(common.Shape(), FACE) if done and common.IsDone() else []


def open_solid(
    solid: Solid, faces: Sequence[Any], caps: Sequence[int], origin: Callable[[Any, int | None], int | None]
) -> Solid:
    """Read the solid that faces make once a ring is cut open, with the names and keys of its faces before.

    Parameters
    ----------
    solid : Solid
        The closed ring.
    faces : sequence of TopoDS_Face
    caps : two of int
        Places in `faces` of the two sides of the cut.
    origin : callable
        ``origin(face, j)`` gives the ring's face that a face of the opened solid comes from, or None; it is the j-th
        of `faces`, or a part of it.
    """
    traced = Traced(_solid_of(faces))
    check_closed(traced.shape)
    divide_closed(traced)
    found = index_map(traced.shape, FACE)
    came_from = traced.face_origins(found)
    origins = [origin(face, j) for face, j in zip(mapped(found, FACE), came_from, strict=True)]
    labels = Labels(
        [label_of(None if j is None else solid.faces[j]) for j in origins],
        find_edge_labels(solid, mapped(index_map(traced.shape, EDGE), EDGE)),
    )
    return extract_solid(
        traced.shape,
        labels=labels,
        name=solid.name,
        material=solid.material,
        color=solid.color,
        units=solid.units,
        shared=PartGeometry(traced.shape, closed=solid.closed),
        opened=_sides_of_cut(caps, came_from),
    )


def _solid_of(faces: Sequence[Any]) -> Any:
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


def _sides_of_cut(caps: Sequence[int], origins: Sequence[int | None]) -> tuple[frozenset[int], frozenset[int]]:
    """Ids of the present faces on either side of the cut, from its two faces and the origins of all faces."""
    one, other = (frozenset(j for j, origin in enumerate(origins) if origin == cap) for cap in caps)
    assert one
    assert other
    return one, other
