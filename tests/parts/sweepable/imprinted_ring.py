"""A plate with a circle imprinted on its top: the source is a disc inside a frame."""

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


plate = cq.Workplane().box(30, 30, 5)
result = divide(plate, ">Z", cq.Workplane().circle(8).extrude(20, both=True).val())

show_object(result, name="imprinted_ring")  # noqa: F821
