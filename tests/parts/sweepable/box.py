"""A box: three directions, equal in everything but length."""

import cadquery as cq

result = cq.Workplane().box(1, 2, 3)

show_object(result, name="box")  # noqa: F821
