"""A tube a hundred thousand units from the origin."""

import cadquery as cq

result = cq.Workplane().circle(5).circle(3).extrude(8).translate((1e5, -2e5, 5e4))

show_object(result, name="far_away")  # noqa: F821
