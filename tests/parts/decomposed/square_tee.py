"""Two square tubes that meet in a tee."""

import cadquery as cq

run = cq.Workplane("YZ", origin=(-50, 0, 0)).rect(30, 30).extrude(100)
branch = cq.Workplane("XY").rect(30, 30).extrude(50)
bores = (
    cq.Workplane("YZ", origin=(-50, 0, 0)).rect(22, 22).extrude(100).union(cq.Workplane("XY").rect(22, 22).extrude(50))
)
result = run.union(branch).cut(bores)

show_object(result, name="square_tee")  # noqa: F821
