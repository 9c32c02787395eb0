"""A hexagonal bar with a corner of one side cut off by an imprint: a triangle among the sides."""

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


result = cq.Workplane().polygon(6, 16).extrude(9)
result = divide(result, ">Y", cq.Face.makePlane(60, 60, (2, 0, 8), (1, 0, 0.8)))

show_object(result, name="split_corner_off")  # noqa: F821
