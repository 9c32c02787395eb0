"""A boss rounded into its plate and at its top edge."""

import cadquery as cq

boss = cq.Workplane("XY", (0, 0, 5)).rect(30, 30).extrude(12).edges("|Z").fillet(5).faces(">Z").edges().fillet(2)
result = cq.Workplane().box(60, 60, 10).union(boss)
foot = cq.selectors.BoxSelector((-15.5, -15.5, 4.9), (15.5, 15.5, 5.1))
result = result.edges(foot).fillet(3)

show_object(result, name="rounded_boss")  # noqa: F821
