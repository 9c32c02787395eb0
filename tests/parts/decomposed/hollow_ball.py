"""A ball with a concentric hole."""

import cadquery as cq

result = cq.Workplane().sphere(10).cut(cq.Workplane().sphere(6))

show_object(result, name="hollow_ball")  # noqa: F821
