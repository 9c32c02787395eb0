"""An angle bracket: holes in both legs, and a gusset between them.

::

    |  |
    |  |\\
    |o | \\  gusset
    |  |__\\______
    |______o_____|
"""

import cadquery as cq

leg = 60.0  # length of the lower leg, mm
rise = 50.0  # height of the upper one, mm
width = 50.0  # mm
thickness = 8.0  # mm
gusset = 32.0  # legs of the triangle, mm
hole = 9.0  # diameter, mm
apart = 30.0  # of the two holes of a leg, mm

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make

corner = (False, True, False)
result = cq.Workplane().box(leg, width, thickness, centered=corner)
result = result.union(cq.Workplane().box(thickness, width, rise, centered=corner))
profile = [(thickness, thickness), (thickness + gusset, thickness), (thickness, thickness + gusset)]
result = result.union(cq.Workplane("XZ", origin=(0, thickness / 2, 0)).polyline(profile).close().extrude(thickness))
pair = [(-apart / 2, 0), (apart / 2, 0)]
lower = cq.Workplane(cq.Plane((leg - 15, 0, -1), (0, 1, 0), (0, 0, 1))).pushPoints(pair).circle(hole / 2)
upper = cq.Workplane(cq.Plane((-1, 0, rise - 14), (0, 1, 0), (1, 0, 0))).pushPoints(pair).circle(hole / 2)
result = result.cut(lower.extrude(thickness + 2)).cut(upper.extrude(thickness + 2))

show_object(result, name="angle_bracket")  # noqa: F821
