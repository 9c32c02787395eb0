"""A block with two opposite sides split obliquely into trapezoids."""

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


result = cq.Workplane().box(20, 12, 8)
for side in (">Y", "<Y"):
    result = divide(result, side, cq.Face.makePlane(60, 60, (3, 0, 0), (1, 0, 0.3)))

show_object(result, name="split_oblique")  # noqa: F821
