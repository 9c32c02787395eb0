"""A square bar bent by a right angle with one domed end."""

import cadquery as cq

bend = cq.Workplane().rect(8, 8).revolve(90, (15, 0, 0), (15, -1, 0))
result = bend.intersect(cq.Workplane().sphere(22).translate((12, 0, 21)))

show_object(result, name="quarter_elbow_square_dome")  # noqa: F821
