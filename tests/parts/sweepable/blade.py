"""A blade section of two splines and a blunt trailing edge, twisted."""

import cadquery as cq

section = (
    cq.Workplane()
    .moveTo(0, 0)
    .spline([(4, 3.5), (12, 5), (30, 1)], includeCurrent=True)
    .lineTo(30, 0)
    .spline([(14, -1), (5, -1.5), (0, 0)], includeCurrent=True)
    .close()
)
result = section.twistExtrude(40, 15)

show_object(result, name="blade")  # noqa: F821
