"""A plate with a hole, a hundredth of a unit wide."""

import cadquery as cq

result = cq.Workplane().rect(0.01, 0.01).circle(0.003).extrude(0.002)

show_object(result, name="tiny")  # noqa: F821
