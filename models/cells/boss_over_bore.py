"""A block with a bore from side to side, and over it a boss and a blind hole.

::

         ____
     ___|    |___  __
    |            |_| |
    |  ------------- |  bore
    |________________|
"""

import cadquery as cq

length = 60.0  # mm
width = 40.0  # mm
height = 30.0  # mm
bore = 5.0  # radius, mm
below = 6.0  # of its axis under the middle, mm
boss = 9.0  # radius, mm
boss_height = 8.0  # mm
blind = 5.0  # radius of the blind hole, mm
depth = 8.0  # of the blind hole, mm

MIN_SCALED_JACOBIAN = 0.3  # of the mesh that the defaults make

result = cq.Workplane().box(length, width, height)
result = result.cut(cq.Workplane("YZ", origin=(-length, 6, -below)).circle(bore).extrude(2 * length))
result = result.union(cq.Workplane(origin=(-length / 5, -4, height / 2)).circle(boss).extrude(boss_height))
result = result.cut(cq.Workplane(origin=(length / 4, 0, height / 2)).circle(blind).extrude(-depth))

show_object(result, name="boss_over_bore")  # noqa: F821
