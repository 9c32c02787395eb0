"""A block with tapered sides."""

import cadquery as cq

result = cq.Workplane("XY").rect(20, 12).extrude(10, taper=12)

show_object(result, name="tapered_block")  # noqa: F821
