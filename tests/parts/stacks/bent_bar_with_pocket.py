"""A square bar bent by a quarter with a pocket in its side face."""

import cadquery as cq

result = cq.Workplane("XZ").center(20, 0).rect(10, 10).revolve(90, (-20, 0, 0), (-20, 1, 0))
pocket = cq.Workplane(origin=(14, 14, 1)).circle(2.5).extrude(10)
result = result.cut(pocket)

show_object(result, name="bent_bar_with_pocket")  # noqa: F821
