"""Three quarters of a ring: more than half a turn from source to target."""

import cadquery as cq

result = cq.Workplane("XZ").center(10, 0).rect(3, 4).revolve(270, (-10, 0, 0), (-10, 1, 0))

show_object(result, name="three_quarter_ring")  # noqa: F821
