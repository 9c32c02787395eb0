"""Two T-slots that cross each other in the top of a block."""

import cadquery as cq

slot = cq.Workplane("XZ").polyline([(-2, 20), (-2, 12), (-4, 12), (-4, 8), (4, 8), (4, 12), (2, 12), (2, 20)])
slot = slot.close().extrude(50, both=True)
result = (
    cq.Workplane().box(40, 40, 16, centered=(True, True, False)).cut(slot).cut(slot.rotate((0, 0, 0), (0, 0, 1), 90))
)

show_object(result, name="crossing_t_slots")  # noqa: F821
