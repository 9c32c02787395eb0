"""A box with a closed cavity: two shells."""

import cadquery as cq

result = cq.Workplane().box(20, 20, 20).cut(cq.Workplane().box(8, 8, 8))

show_object(result, name="hollow_box")  # noqa: F821
