"""A tray of sheet with four flanges, a hole, and an embossing whose flanks are about as long as the sheet is thick."""

import cadquery as cq


def bent(length, width):
    """A channel of sheet of 2."""
    outer = cq.Workplane().box(2 * length + 2, width, 16).edges("|Y and <Z").fillet(4)
    inner = cq.Workplane().box(2 * length - 2, width, 16).edges("|Y and <Z").fillet(2)
    return outer.cut(inner.translate((0, 0, 2))).translate((0, 0, 7))


result = bent(30, 30).union(bent(20, 50).rotate((0, 0, 0), (0, 0, 1), 90)).clean()
result = result.cut(cq.Workplane().center(10, 5).circle(4).extrude(4, both=True))
boss = cq.Workplane().workplane(offset=1).center(-10, 0).circle(6).extrude(2, taper=30)
dent = cq.Workplane().workplane(offset=-1).center(-10, 0).circle(5).extrude(2, taper=30)
result = result.union(boss).cut(dent)

show_object(result, name="embossed_tray")  # noqa: F821
