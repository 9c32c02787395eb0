"""A very thin disc: two layers at least."""

import cadquery as cq

result = cq.Workplane().circle(50).extrude(0.5)

show_object(result, name="thin_disc")  # noqa: F821
