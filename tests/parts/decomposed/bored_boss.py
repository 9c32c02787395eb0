"""A boss with a bore through it, on a block with a cross hole below."""

import cadquery as cq

result = cq.Workplane().box(50, 40, 30).cut(cq.Workplane("XZ", origin=(0, 20, -6)).circle(5).extrude(40))
result = result.union(cq.Workplane("XY", origin=(12, 0, 15)).circle(8).extrude(8))
result = result.cut(cq.Workplane("XY", origin=(12, 0, 23)).circle(3).extrude(-60))

show_object(result, name="bored_boss")  # noqa: F821
