"""A bar whose sides are L-shaped around patches at their lower corners, of different heights, and whose caps differ."""

import cadquery as cq

bar = cq.Workplane().polyline([(-5, -4), (5, -4), (5, 4), (0, 6), (-5, 4)]).close().extrude(20).val()
for tool in (
    cq.Workplane(origin=(4, 3, 0)).rect(4, 6).extrude(8).val(),
    cq.Workplane(origin=(-5, 0, 12)).rect(2, 4).extrude(9).val(),
):
    bar = bar.cut(tool).fuse(bar.intersect(tool)).Solids()[0]
result = bar

show_object(result, name="t_junction_sides")  # noqa: F821
