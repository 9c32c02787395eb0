"""A sphere: no face has four corners."""

import cadquery as cq

result = cq.Workplane().sphere(5)

show_object(result, name="sphere")  # noqa: F821
