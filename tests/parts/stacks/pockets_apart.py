"""A block with a pocket from above and one from below, side by side."""

import cadquery as cq

result = cq.Workplane().box(30, 16, 8, centered=(True, True, False))
result = result.faces(">Z").workplane().center(-7, 0).rect(10, 9).cutBlind(-5)
result = result.faces("<Z").workplane(invert=True).center(7, 0).rect(9, 10).cutBlind(5)

show_object(result, name="pockets_apart")  # noqa: F821
