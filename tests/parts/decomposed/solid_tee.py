"""A round bar with a narrower round branch."""

import cadquery as cq

result = cq.Workplane("YZ", origin=(-40, 0, 0)).circle(15).extrude(80).union(cq.Workplane("XY").circle(9).extrude(40))

show_object(result, name="solid_tee")  # noqa: F821
