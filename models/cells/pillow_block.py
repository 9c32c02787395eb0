"""A pillow block: a seat for a bearing on a foot with two holes.

::

          ______
         /  __  \\
        |  /  \\  |
     ___|  \\__/  |___
    |_|_|________|_|_|
"""

import cadquery as cq

length = 90.0  # of the foot, mm
width = 30.0  # mm
foot = 12.0  # its height, mm
axis = 30.0  # height of the bearing's axis, mm
outer = 22.0  # radius of the seat, mm
bearing = 13.0  # radius, mm
hole = 9.0  # diameter of the holes in the foot, mm
apart = 68.0  # of these holes, mm

MIN_SCALED_JACOBIAN = 0.2  # of the mesh that the defaults make

result = cq.Workplane().box(length, width, foot, centered=(True, True, False))
seat = cq.Workplane("XZ", origin=(0, width / 2, 0)).moveTo(-outer, foot).lineTo(-outer, axis)
seat = seat.threePointArc((0, axis + outer), (outer, axis)).lineTo(outer, foot).close().extrude(width)
result = result.union(seat).cut(cq.Workplane("XZ", origin=(0, width, axis)).circle(bearing).extrude(2 * width))
result = result.cut(cq.Workplane().pushPoints([(-apart / 2, 0), (apart / 2, 0)]).circle(hole / 2).extrude(foot))

show_object(result, name="pillow_block")  # noqa: F821
