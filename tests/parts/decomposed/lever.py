"""A lever: a hub with a bore along z, an arm, and an eye with a bore along y at its end."""

import cadquery as cq

hub = cq.Workplane().circle(14).extrude(24)
arm = cq.Workplane(origin=(30, 0, 12)).box(50, 10, 12)
eye = cq.Workplane("XZ", origin=(60, 5, 12)).circle(11).extrude(10)
result = (
    hub.union(arm).union(eye)
    .cut(cq.Workplane().circle(8).extrude(24))
    .cut(cq.Workplane("XZ", origin=(60, 5, 12)).circle(6).extrude(10))
)  # fmt: skip

show_object(result, name="lever")  # noqa: F821
