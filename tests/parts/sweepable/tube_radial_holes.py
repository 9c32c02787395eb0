"""A tube with holes through its wall: swept across the wall, its ends are sides with a hole each."""

import cadquery as cq

tube = cq.Workplane().circle(30).circle(26).extrude(20)
drill = cq.Workplane("YZ", origin=(0, 0, 10)).circle(3).extrude(40)
for angle in (20, 110, 230):
    tube = tube.cut(drill.rotate((0, 0, 0), (0, 0, 1), angle))

show_object(tube, name="tube_radial_holes")  # noqa: F821
