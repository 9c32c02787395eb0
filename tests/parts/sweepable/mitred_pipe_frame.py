"""A closed frame of round bars with mitred corners: stations at every corner, caps nowhere."""

import cadquery as cq

path = cq.Workplane().moveTo(0, -4).lineTo(5, -4).lineTo(5, 4).lineTo(-5, 4).lineTo(-5, -4).close()
result = cq.Workplane("YZ", origin=(0, -4, 0)).circle(1.5).sweep(path, transition="right")

show_object(result, name="mitred_pipe_frame")  # noqa: F821
