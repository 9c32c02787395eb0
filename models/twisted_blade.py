"""A blade: a cambered, tapered profile that turns from root to tip.

::

        tip    .-'''''--..__          profile   two splines, above and below the chord, and a
              '-----------''--.                 blunt edge at either end
          |
          |   turned by `twist`
        root  .-''''''--..___
             '--------------''---.
"""

import math

import cadquery as cq

chord = 40.0  # of the root, mm
thickness = 0.16  # greatest, over the chord
camber = 0.06  # greatest, over the chord
blunt = 0.05  # thickness of the edges, over the chord
span = 100.0  # mm
twist = 35.0  # degrees from root to tip
taper = 0.7  # chord of the tip over that of the root
n_sections = 6  # sections that the sides are drawn through

MIN_SCALED_JACOBIAN = 0.7  # of the mesh that the defaults make


def section(t):
    """The profile at the fraction t of the span: upper side, front, lower side, back."""
    scale = chord * (1 + (taper - 1) * t)
    turn = math.radians(twist * t)

    def point(x, half):
        y = 4 * camber * x * (1 - x) + half
        x, y = scale * (x - 0.5), scale * y
        return cq.Vector(x * math.cos(turn) - y * math.sin(turn), x * math.sin(turn) + y * math.cos(turn), span * t)

    def half(x):
        return blunt / 2 + (thickness - blunt) / 2 * 4 * x * (1 - x)

    stations = [i / 8 for i in range(9)]
    lower = cq.Edge.makeSpline([point(x, -half(x)) for x in stations])
    upper = cq.Edge.makeSpline([point(x, half(x)) for x in reversed(stations)])
    back = cq.Edge.makeLine(lower.endPoint(), upper.startPoint())
    front = cq.Edge.makeLine(upper.endPoint(), lower.startPoint())
    return cq.Wire.assembleEdges([lower, back, upper, front])


result = cq.Workplane(cq.Solid.makeLoft([section(i / (n_sections - 1)) for i in range(n_sections)]))

show_object(result, name="twisted_blade")  # noqa: F821
