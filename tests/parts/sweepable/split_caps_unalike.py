"""A plate with a hole whose top and bottom are split differently: the caps do not correspond face by face."""

import cadquery as cq
from OCP.BRepAlgoAPI import BRepAlgoAPI_Splitter
from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing
from OCP.TopTools import TopTools_ListOfShape


def divide(part, faces, tool):
    """Split the selected faces of a solid along a tool; the solid stays one."""
    split = BRepAlgoAPI_Splitter()
    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    for face in part.faces(faces).vals():
        arguments.Append(face.wrapped)
    tools.Append(tool.wrapped)
    split.SetArguments(arguments)
    split.SetTools(tools)
    split.Build()
    chosen = part.faces(faces).vals()
    rest = [face for face in part.val().Faces() if not any(face.isSame(other) for other in chosen)]
    sewing = BRepBuilderAPI_Sewing(1e-6)
    for face in [*rest, *cq.Shape.cast(split.Shape()).Faces()]:
        sewing.Add(face.wrapped)
    sewing.Perform()
    return cq.Workplane(obj=cq.Solid.makeSolid(cq.Shape.cast(sewing.SewedShape())))


result = cq.Workplane().box(20, 14, 6).faces(">Z").workplane().hole(5)
result = divide(result, ">Z", cq.Face.makePlane(60, 60, (6, 0, 0), (1, 0, 0)))
result = divide(result, "<Z", cq.Face.makePlane(60, 60, (0, 5, 0), (0, 1, 0)))

show_object(result, name="split_caps_unalike")  # noqa: F821
