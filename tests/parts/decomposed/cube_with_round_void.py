"""A cube with a spherical hole in its middle."""

import cadquery as cq

result = cq.Workplane().box(20, 20, 20).cut(cq.Workplane().sphere(6))

show_object(result, name="cube_with_round_void")  # noqa: F821
