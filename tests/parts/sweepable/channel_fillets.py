"""A channel with fillets along the sweep: narrow tangent sides."""

import cadquery as cq

profile = [(0, 0), (30, 0), (30, 20), (26, 20), (26, 4), (4, 4), (4, 20), (0, 20)]
result = cq.Workplane().polyline(profile).close().extrude(60).edges("|Z").fillet(1.5)

show_object(result, name="channel_fillets")  # noqa: F821
