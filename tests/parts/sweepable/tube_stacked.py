"""A tube whose closed walls are divided all around at half height: pieces that share one surface and its seam."""

import cadquery as cq

tube = cq.Workplane().circle(7).circle(4).extrude(15).val()
above = cq.Solid.makeBox(20, 20, 20, pnt=cq.Vector(-10, -10, 6))
result = tube.cut(above).fuse(tube.intersect(above)).Solids()[0]

show_object(result, name="tube_stacked")  # noqa: F821
