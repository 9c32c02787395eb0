"""A bar with a periodic spline for its section and a round imprint across the seam of its only side."""

import cadquery as cq

points = [(6, 0), (4, 4), (0, 3), (-5, 4), (-6, -1), (0, -5)]
bar = cq.Workplane().spline(points, periodic=True).close().extrude(15).val()
tool = cq.Workplane("YZ", origin=(3, 0, 7)).circle(1.5).extrude(5).val()
result = bar.cut(tool).fuse(bar.intersect(tool)).Solids()[0]

show_object(result, name="imprint_across_seam")  # noqa: F821
