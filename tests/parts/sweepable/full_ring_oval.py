"""A full ring of oval section about its axis: source and target coincide."""

import cadquery as cq

result = cq.Workplane("XZ").center(15, 0).ellipse(4, 2).revolve(360, (-15, 0, 0), (-15, 1, 0))

show_object(result, name="full_ring_oval")  # noqa: F821
