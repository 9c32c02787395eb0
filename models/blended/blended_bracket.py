"""A cast bracket: an angle with a rib, rounded where faces meet and at its corners.

::

    |  |
    |  |\\
    |o | \\  rib, its feet rounded as the inner corner is
    |  |__\\______
    |______o_____|
"""

import cadquery as cq

leg = 60.0  # length of the lower leg, mm
rise = 50.0  # height of the upper one, mm
width = 50.0  # mm
thickness = 8.0  # mm
rib = 30.0  # legs of the rib's triangle, mm
inner = 3.0  # radius of the inner corner and of the rib's feet, mm
corner = 8.0  # radius of the corners of both legs, mm
hole = 9.0  # diameter, mm
apart = 30.0  # of the two holes of a leg, mm

MIN_SCALED_JACOBIAN = 0.3  # of the mesh that the defaults make

centred = (False, True, False)
result = cq.Workplane().box(leg, width, thickness, centered=centred).edges("|Z and >X").fillet(corner)
result = result.union(cq.Workplane().box(thickness, width, rise, centered=centred).edges("|X and >Z").fillet(corner))
profile = [(thickness, thickness), (thickness + rib, thickness), (thickness, thickness + rib)]
result = result.union(cq.Workplane("XZ", origin=(0, thickness / 2, 0)).polyline(profile).close().extrude(thickness))
# All inner edges of the angle and the rib: straight ones in the plane of a leg, and not on its rim.
room = cq.selectors.BoxSelector((thickness - 1, 1 - width / 2, thickness - 1), (leg - 1, width / 2 - 1, rise - 1))
inside = [e for e in result.edges(room).edges("%LINE").vals() if min(e.Center().x, e.Center().z) < thickness + 1e-6]
result = cq.Workplane(result.val().fillet(inner, inside))
pair = [(-apart / 2, 0), (apart / 2, 0)]
lower = cq.Workplane(cq.Plane((leg - 12, 0, -1), (0, 1, 0), (0, 0, 1))).pushPoints(pair).circle(hole / 2)
upper = cq.Workplane(cq.Plane((-1, 0, rise - 12), (0, 1, 0), (1, 0, 0))).pushPoints(pair).circle(hole / 2)
result = result.cut(lower.extrude(thickness + 2)).cut(upper.extrude(thickness + 2))

show_object(result, name="blended_bracket")  # noqa: F821
