"""A tube with a keyway in its bore and flats outside."""

import cadquery as cq

tube = cq.Workplane().circle(12).circle(6).extrude(20).cut(cq.Workplane().center(0, 6).rect(3, 4).extrude(20))
result = tube.intersect(cq.Workplane().rect(20, 40).extrude(20))

show_object(result, name="keyway_tube")  # noqa: F821
