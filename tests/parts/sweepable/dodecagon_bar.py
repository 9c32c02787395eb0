"""A bar of twelve sides: its caps have corners of 150 degrees, all alike."""

import cadquery as cq

result = cq.Workplane().polygon(12, 4).extrude(3)

show_object(result, name="dodecagon_bar")  # noqa: F821
