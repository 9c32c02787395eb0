"""A cube with every edge and corner cut: caps of nine faces with triangles."""

import cadquery as cq

result = cq.Workplane().box(10, 10, 10).edges().chamfer(2)

show_object(result, name="chamfered_everywhere")  # noqa: F821
