"""A bracket bent from sheet, with an embossing in its foot and holes in both legs.

::

    |o |
    |  |
    |  |     ____
     \\  \\____/  _ \\____
      \\_____/  / \\____o|     swept through its thickness, from skin to skin
"""

import cadquery as cq

thickness = 2.0  # mm
foot = 70.0  # length of the lower leg, mm
rise = 40.0  # height of the upper one, mm
width = 50.0  # mm
bend = 4.0  # inner radius of the bend, mm
height = 4.0  # of the embossing, mm
radius = 12.0  # of the embossing at its foot, mm
round_ = 1.0  # the smaller radius at its rims, mm; the other is larger by the thickness
hole = 6.0  # diameter, mm

MIN_SCALED_JACOBIAN = 0.6  # of the mesh that the defaults make


def angle(inset: float, inner: float):
    """The angle that is `inset` within the outer one, and rounded at its edge."""
    profile = [(inset, rise), (inset, inset), (foot, inset), (foot, rise)]
    solid = cq.Workplane("XZ").polyline(profile).close().extrude(width / 2, both=True)
    return solid.edges("|Y").edges("<X and <Z").fillet(inner)


def bulge(level: float, shrink: float, foot_radius: float, top_radius: float):
    """What an embossing adds to a leg whose skin is at a level, with both its rims rounded."""
    leg = cq.Workplane().workplane(offset=level - 10).center(foot / 2 + 5, 0).rect(40, 40).extrude(10)
    cone = cq.Workplane().workplane(offset=level).center(foot / 2 + 5, 0).circle(radius - shrink)
    solid = leg.union(cone.extrude(height, taper=30))
    solid = solid.edges(cq.selectors.BoxSelector((0, -15, level - 1), (foot, 15, level + 1))).edges("%CIRCLE")
    solid = solid.fillet(foot_radius)
    return solid.faces(">Z").edges().fillet(top_radius)


shrink = thickness * 0.577  # the inner skin is about parallel to the outer one
result = angle(0, bend + thickness).cut(angle(thickness, bend))
result = result.union(bulge(thickness, 0, round_, round_ + thickness))
result = result.cut(bulge(0, shrink, round_ + thickness, round_))
result = result.cut(cq.Workplane().center(foot - 8, 0).circle(hole / 2).extrude(2 * thickness))
for y in (-width / 4, width / 4):
    upper = cq.Workplane("YZ", origin=(-1, 0, 0)).center(y, rise - 10)
    result = result.cut(upper.circle(hole / 2).extrude(2 * thickness))

show_object(result, name="embossed_sheet")  # noqa: F821
