"""A fuel pin: pellets on top of each other, the gas gap around them, and the cladding.

::

      |.|=======|.|
      |.| pellet|.|     clad, gap, pellet, gap, clad: shells in shells
      |.|=======|.|
"""

import cadquery as cq

pellet_radius = 4.1  # mm
pellet_height = 10.0  # mm
gap = 0.2  # mm
clad = 0.6  # thickness of the cladding, mm
n_pellets = 3

MIN_SCALED_JACOBIAN = 0.5  # of the mesh that the defaults make

height = n_pellets * pellet_height
result = cq.Assembly(name="fuel_pin")
for k in range(n_pellets):
    pellet = cq.Workplane(origin=(0, 0, k * pellet_height)).circle(pellet_radius).extrude(pellet_height)
    result.add(pellet, name=f"pellet_{k + 1}", color=cq.Color("orange"))
gas = cq.Workplane().circle(pellet_radius + gap).circle(pellet_radius).extrude(height)
tube = cq.Workplane().circle(pellet_radius + gap + clad).circle(pellet_radius + gap).extrude(height)
result.add(gas, name="gap", color=cq.Color("lightblue")).add(tube, name="clad", color=cq.Color("gray"))

show_object(result, name="fuel_pin")  # noqa: F821
