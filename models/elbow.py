"""A pipe elbow: a ring turned about an axis beside it.

::

        .-------.
        |  wall  '.          source   a ring: an outer and an inner circle
        '---.      \\         target   the same, turned by `angle`
             \\      |        sides    the outside and the bore
              |  |  |
              '-----'
"""

import cadquery as cq

outer = 10.0  # outer radius of the pipe, mm
wall = 2.5  # mm
bend_radius = 30.0  # radius of the middle line of the bend, mm
angle = 90.0  # degrees

MIN_SCALED_JACOBIAN = 0.9  # of the mesh that the defaults make

result = cq.Workplane("XY").moveTo(bend_radius, 0).circle(outer).circle(outer - wall).revolve(angle, (0, 0), (0, 1))

show_object(result, name="elbow")  # noqa: F821
