"""A block with all vertical edges and all edges of its top rounded: the cap is nine tangent faces."""

import cadquery as cq

result = cq.Workplane().box(20, 20, 10).edges("|Z or >Z").fillet(2)

show_object(result, name="filleted_block")  # noqa: F821
