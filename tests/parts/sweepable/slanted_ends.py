"""A bar cut obliquely at both ends: linking sides with corners of 45 and 135 degrees."""

import cadquery as cq

result = cq.Workplane("XZ").polyline([(0, 0), (40, 0), (30, 10), (10, 10)]).close().extrude(8)
result = result.cut(cq.Workplane("XY").center(20, -4).circle(2).extrude(10))

show_object(result, name="slanted_ends")  # noqa: F821
