"""A piece of a cylindrical shell with a round hole through it."""

import cadquery as cq

shell = cq.Workplane().circle(20).circle(18).extrude(20).intersect(cq.Workplane().rect(24, 50).extrude(20))
shell = shell.intersect(cq.Workplane().center(0, 25).rect(24, 50).extrude(20))
result = shell.cut(cq.Workplane("XZ").center(0, 10).circle(4).extrude(-30))

show_object(result, name="cylinder_shell")  # noqa: F821
