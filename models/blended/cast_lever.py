"""A cast lever: a hub and an eye on a web, rounded along their feet and their upper rims.

::

     ____
    |    |
    |    |             __
    |    |____________|  |
    |    |____________|  |
     hub      web      eye
"""

import cadquery as cq

apart = 60.0  # of the two axes, mm
hub, bore = 14.0, 8.0  # radii, mm
eye, pin = 9.0, 4.0  # radii, mm
rise, eye_rise = 26.0, 18.0  # mm
web = 8.0  # thickness, mm
slender = 0.8  # widths of the web over those of what it joins
foot = 2.5  # radius, mm
rim = 1.0  # radius, mm

MIN_SCALED_JACOBIAN = 0.45  # of the mesh that the defaults make

corners = [(0, -slender * hub), (apart, -slender * eye), (apart, slender * eye), (0, slender * hub)]
result = cq.Workplane().polyline(corners).close().extrude(web)
result = result.union(cq.Workplane().circle(hub).extrude(rise))
result = result.union(cq.Workplane(origin=(apart, 0, 0)).circle(eye).extrude(eye_rise))
result = result.faces(cq.selectors.BoxSelector((1, -1, web - 0.1), (apart, 1, web + 0.1))).edges("%CIRCLE").fillet(foot)
for x, height, radius in ((0, rise, bore), (apart, eye_rise, pin)):
    top = cq.selectors.BoxSelector((x - 1, -1, height - 0.1), (x + 1, 1, height + 0.1))
    result = result.faces(top).edges().fillet(rim)
    result = result.cut(cq.Workplane(origin=(x, 0, 0)).circle(radius).extrude(height))

show_object(result, name="cast_lever")  # noqa: F821
