"""A sandwich panel: a soft core between two thin skins, with an insert through all three.

::

      ============[###]============   skin
      ............[###]............   core, and the insert
      ============[###]============   skin
"""

import cadquery as cq

length = 80.0  # mm, along x
width = 50.0  # mm, along y
skin = 1.5  # thickness of a skin, mm
core = 12.0  # thickness of the core, mm
insert = 14.0  # diameter of the insert, mm

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make


def layer(bottom, thickness):
    """One layer with the hole of the insert."""
    plate = cq.Workplane(origin=(0, 0, bottom)).rect(length, width).circle(insert / 2).extrude(thickness)
    return plate


result = (
    cq.Assembly(name="sandwich_panel")
    .add(layer(0.0, skin), name="lower_skin", color=cq.Color("steelblue"))
    .add(layer(skin, core), name="core", color=cq.Color("khaki"))
    .add(layer(skin + core, skin), name="upper_skin", color=cq.Color("steelblue"))
    .add(cq.Workplane().circle(insert / 2).extrude(2 * skin + core), name="insert", color=cq.Color("gray"))
)

show_object(result, name="sandwich_panel")  # noqa: F821
