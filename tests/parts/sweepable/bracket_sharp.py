"""A bracket with a sharp bend and holes in both flanges: caps of two planes at a right angle."""

import cadquery as cq

profile = cq.Workplane("XZ").polyline([(0, 0), (40, 0), (40, 4), (4, 4), (4, 30), (0, 30)]).close().extrude(-20)
hole = cq.Workplane("XY").center(25, 10).circle(5).extrude(10)
other = cq.Workplane("YZ").center(10, 18).circle(5).extrude(10)
result = profile.cut(hole).cut(other)

show_object(result, name="bracket_sharp")  # noqa: F821
