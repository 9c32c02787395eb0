"""A lid with a groove for an O-ring and four holes."""

import cadquery as cq

result = cq.Workplane().rect(60, 60).extrude(10)
result = result.cut(cq.Workplane(origin=(0, 0, 7)).circle(20).circle(16).extrude(5))
result = result.faces(">Z").workplane().rect(48, 48, forConstruction=True).vertices().hole(5)

show_object(result, name="o_ring_groove")  # noqa: F821
