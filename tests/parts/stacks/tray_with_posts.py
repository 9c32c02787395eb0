"""A tray with a rim and twelve posts that stand higher than the rim."""

import cadquery as cq

result = cq.Workplane().box(60, 40, 12, centered=(True, True, False))
result = result.cut(cq.Workplane().box(54, 34, 10, centered=(True, True, False)).translate((0, 0, 3)))
posts = cq.Workplane().rarray(14, 11, 4, 3).circle(2.2).extrude(12)
result = result.union(posts.translate((0, 0, 2)))

show_object(result, name="tray_with_posts")  # noqa: F821
