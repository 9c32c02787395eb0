"""A round pipe of straight, bend and straight: two stations on each of its loops."""

import cadquery as cq

lower = cq.Workplane().circle(6).circle(4).extrude(30)
bend = cq.Workplane().workplane(offset=30).circle(6).circle(4).revolve(90, (20, 0, 0), (20, 1, 0))
upper = cq.Workplane("YZ").workplane(offset=20).center(0, 50).circle(6).circle(4).extrude(25)
result = lower.union(bend, clean=False).union(upper, clean=False)

show_object(result, name="pipe_straight_bend")  # noqa: F821
