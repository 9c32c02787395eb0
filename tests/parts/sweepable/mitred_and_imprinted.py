"""A mitred bar of rounded section, its sides divided by a step and by an imprint: the mitre must stay a kink."""

import cadquery as cq

section = (
    cq.Workplane()
    .moveTo(-5, -3)
    .lineTo(5, -3)
    .threePointArc((7, 0), (5, 3))
    .lineTo(-5, 3)
    .threePointArc((-7, 0), (-5, -3))
    .close()
)
path = cq.Workplane("XZ").polyline([(0, 0), (0, 20), (12, 36)])
bar = section.sweep(path, transition="right").val()
for tool in (
    cq.Solid.makeBox(40, 40, 40, pnt=cq.Vector(0, 0, 7)),
    cq.Workplane("YZ", origin=(7, 0, 6)).circle(1.5).extrude(2, both=True).val(),
):
    bar = bar.cut(tool).fuse(bar.intersect(tool)).Solids()[0]
result = bar

show_object(result, name="mitred_and_imprinted")  # noqa: F821
