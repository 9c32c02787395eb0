"""An angle profile: caps with a re-entrant corner, no holes."""

import cadquery as cq

result = cq.Workplane().polyline([(0, 0), (40, 0), (40, 4), (4, 4), (4, 30), (0, 30)]).close().extrude(50)

show_object(result, name="angle_profile")  # noqa: F821
