"""A tube: two loops without a corner."""

import cadquery as cq

result = cq.Workplane().circle(5).circle(4).extrude(12)

show_object(result, name="tube")  # noqa: F821
