"""A turn and a quarter of a spring of round wire: one long helical face."""

import cadquery as cq

helix = cq.Wire.makeHelix(12, 15, 10)
result = cq.Workplane("XZ").center(10, 0).circle(2).sweep(cq.Workplane(obj=helix), isFrenet=True)

show_object(result, name="spring")  # noqa: F821
