"""A fork with a pin hole across it, on a round shank."""

import cadquery as cq

fork = cq.Workplane().box(40, 30, 30).cut(cq.Workplane(origin=(8, 0, 0)).box(30, 12, 30))
fork = fork.cut(cq.Workplane("XZ", origin=(8, 15, 0)).circle(6).extrude(30))
result = fork.union(cq.Workplane("YZ", origin=(-60, 0, 0)).circle(9).extrude(40))

show_object(result, name="clevis")  # noqa: F821
