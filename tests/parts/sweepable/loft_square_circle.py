"""A loft from a square to a circle: ruled sides, one corner after the other."""

import cadquery as cq

bottom = cq.Workplane("XY").rect(20, 20)
result = bottom.workplane(offset=25).rect(8, 14).loft(combine=True)

show_object(result, name="loft_square_circle")  # noqa: F821
