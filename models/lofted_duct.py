"""The inside of a duct that goes from a flat, rounded rectangle to a circle beside it.

::

                       .---.
                     (       )      circle, drawn as eight arcs
                    / '.___.' \\
                  /          /
         .-------'------.  /        rounded rectangle: four lines, four arcs
        (________________)

Every line and corner arc of the rectangle has its own arc of the circle, so that the sides join
matching points.
"""

import math

import cadquery as cq

width = 80.0  # of the rectangle, mm
height = 40.0  # of the rectangle, mm
corner = 12.0  # radius of its corners, mm
radius = 30.0  # of the circle, mm
length = 100.0  # mm
offset = 25.0  # of the circle's centre beside the rectangle's, mm

MIN_SCALED_JACOBIAN = 0.4  # of the mesh that the defaults make


x, y = width / 2, height / 2
flat, tall = x - corner, y - corner
signs = [(1, 1), (-1, 1), (-1, -1), (1, -1)]


def closed(points, middles):
    """A wire through the points: an arc through every middle, a line where it is None."""
    edges = []
    for start, middle, end in zip(points, middles, points[1:] + points[:1], strict=True):
        line = middle is None
        edges.append(cq.Edge.makeLine(start, end) if line else cq.Edge.makeThreePointArc(start, middle, end))
    return cq.Wire.assembleEdges(edges)


def on_circle(turn):
    """The point of the circle at an angle."""
    return cq.Vector(offset + radius * math.cos(turn), radius * math.sin(turn), length)


# The ends of the corner arcs, counter-clockwise, and their angles on an ellipse that fits the sides.
ends = []
for sx, sy in signs:
    corner_ends = [(sx * x, sy * tall), (sx * flat, sy * y)]
    ends += corner_ends if sx == sy else corner_ends[::-1]
turns = [math.atan2(py / y, px / x) % (2 * math.pi) for px, py in ends]

reach = corner * math.sqrt(0.5)
knees = [cq.Vector(sx * (flat + reach), sy * (tall + reach), 0) for sx, sy in signs]
rectangle = closed([cq.Vector(*end, 0) for end in ends], [m for knee in knees for m in (knee, None)])

following = [*turns[1:], turns[0] + 2 * math.pi]
circle = closed(
    [on_circle(turn) for turn in turns],
    [on_circle((a + b) / 2) for a, b in zip(turns, following, strict=True)],
)

result = cq.Workplane(cq.Solid.makeLoft([rectangle, circle]))

show_object(result, name="lofted_duct")  # noqa: F821
