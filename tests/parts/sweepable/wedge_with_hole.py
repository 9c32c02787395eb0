"""A wedge with a hole: source and target are not parallel."""

import cadquery as cq

wedge = cq.Workplane("XZ").polyline([(0, 0), (30, 0), (30, 12), (0, 4)]).close().extrude(20)
result = wedge.faces("<Z").workplane(centerOption="CenterOfBoundBox").hole(6)

show_object(result, name="wedge_with_hole")  # noqa: F821
