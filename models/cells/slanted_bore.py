"""A block with a slanted bore between two bores across.

::

     ____________//____
    |           //     |
    |  o       //   o  |
    |_________//_______|
"""

import math

import cadquery as cq

length = 60.0  # mm
width = 30.0  # mm
height = 16.0  # mm
slant = 26.5  # of the bore to the upright, degrees
bore = 5.0  # radius, mm
across = 3.0  # radius of the bores across, mm
apart = 44.0  # of these, mm

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make

along = (math.sin(math.radians(slant)), 0, math.cos(math.radians(slant)))
result = cq.Workplane().box(length, width, height)
result = result.cut(cq.Workplane(cq.Plane((0, 0, 0), (0, 1, 0), along)).circle(bore).extrude(2 * height, both=True))
pair = cq.Workplane("XZ", origin=(0, width, 0)).pushPoints([(-apart / 2, 0), (apart / 2, 0)])
result = result.cut(pair.circle(across).extrude(2 * width))

show_object(result, name="slanted_bore")  # noqa: F821
