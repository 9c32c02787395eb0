"""An angle of a hundred thousand units."""

import cadquery as cq

result = cq.Workplane().polyline([(0, 0), (1e5, 0), (1e5, 2e4), (2e4, 2e4), (2e4, 1e5), (0, 1e5)]).close().extrude(5e4)

show_object(result, name="huge")  # noqa: F821
