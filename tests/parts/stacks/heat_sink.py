"""A heat sink with 40 fins on a base with two holes."""

import cadquery as cq

result = cq.Workplane().box(122, 30, 4, centered=(True, True, False))
fins = cq.Workplane(origin=(0, 0, 4)).rarray(3, 1, 40, 1).rect(1, 22).extrude(16)
result = result.union(fins).cut(cq.Workplane().pushPoints([(-40, -13), (40, 13)]).circle(1).extrude(4))

show_object(result, name="heat_sink")  # noqa: F821
