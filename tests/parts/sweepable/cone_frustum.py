"""A frustum of a cone: the target is a quarter of the source."""

import cadquery as cq

result = cq.Workplane("XY").circle(8).extrude(15, taper=15)

show_object(result, name="cone_frustum")  # noqa: F821
