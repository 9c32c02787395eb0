"""An L-shaped block extruded with a flare: cones round its corners and run out to points on the smaller cap."""

import cadquery as cq

outline = cq.Workplane().polyline([(0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)]).close()
result = outline.extrude(5, taper=-8)

show_object(result, name="flared_corners")  # noqa: F821
