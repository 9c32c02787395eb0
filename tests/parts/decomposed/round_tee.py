"""Two round tubes that meet in a tee, the branch narrower."""

import cadquery as cq

run = cq.Workplane("YZ", origin=(-50, 0, 0)).circle(18).extrude(100)
branch = cq.Workplane("XY").circle(11).extrude(45)
bores = cq.Workplane("YZ", origin=(-50, 0, 0)).circle(14).extrude(100).union(cq.Workplane("XY").circle(7).extrude(45))
result = run.union(branch).cut(bores)

show_object(result, name="round_tee")  # noqa: F821
