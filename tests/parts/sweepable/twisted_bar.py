"""A square bar twisted by a right angle: curved sides."""

import cadquery as cq

result = cq.Workplane().rect(10, 6).twistExtrude(30, 90)

show_object(result, name="twisted_bar")  # noqa: F821
