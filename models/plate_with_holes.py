"""A plate with rounded corners, four bolt holes and a larger bore.

::

       .---------------------------.
       | o                       o |
       |           .---.           |
       |          (     )          |      a constant section: one loop outside, five inside
       |           '---'           |
       | o                       o |
       '---------------------------'
"""

import cadquery as cq

width = 80.0  # mm, along x
depth = 50.0  # mm, along y
thickness = 10.0  # mm
corner = 6.0  # radius of the corners, mm
bore = 20.0  # diameter of the middle hole, mm
bolt = 6.0  # diameter of the bolt holes, mm
margin = 10.0  # of the bolt holes from the edges of the plate, mm

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make

result = (
    cq.Workplane("XY")
    .rect(width, depth)
    .extrude(thickness)
    .edges("|Z")
    .fillet(corner)
    .faces(">Z")
    .workplane()
    .hole(bore)
    .faces(">Z")
    .workplane()
    .rect(width - 2 * margin, depth - 2 * margin, forConstruction=True)
    .vertices()
    .hole(bolt)
)

show_object(result, name="plate_with_holes")  # noqa: F821
