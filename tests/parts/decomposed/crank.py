"""A crank with two main journals and a pin between two webs."""

import cadquery as cq


def web(x):
    return cq.Workplane("YZ", origin=(x, 0, 0)).center(0, 10).slot2D(48, 26, 90).extrude(8)


result = (
    cq.Workplane("YZ", origin=(-30, 0, 0)).circle(10).extrude(30)
    .union(web(0))
    .union(cq.Workplane("YZ", origin=(8, 0, 0)).center(0, 20).circle(8).extrude(16))
    .union(web(24))
    .union(cq.Workplane("YZ", origin=(32, 0, 0)).circle(10).extrude(30))
)  # fmt: skip

show_object(result, name="crank")  # noqa: F821
