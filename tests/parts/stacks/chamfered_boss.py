"""A round boss with a chamfered edge on a plate with chamfered edges, and a countersunk hole through both."""

import cadquery as cq

result = cq.Workplane().box(40, 30, 6).faces(">Z").edges().chamfer(1)
boss = cq.Workplane(origin=(0, 0, 2)).circle(9).extrude(9).faces(">Z").edges().chamfer(1.5)
result = result.union(boss).faces(">Z").workplane().cskHole(5, 10, 90)

show_object(result, name="chamfered_boss")  # noqa: F821
