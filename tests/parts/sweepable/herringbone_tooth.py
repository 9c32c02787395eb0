"""A tooth of a herringbone gear: two twisted spans, one turned against the other."""

import cadquery as cq

profile = [(-4, 0), (4, 0), (2, 9), (-2, 9)]
lower = cq.Workplane().polyline(profile).close().twistExtrude(10, 20)
upper = lower.mirror("XY", (0, 0, 10))
result = lower.union(upper)

show_object(result, name="herringbone_tooth")  # noqa: F821
