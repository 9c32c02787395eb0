"""Parametric families of parts for the property tests: numbers in, CadQuery solid out.

The families are drawn wide: many members cannot be swept or even built. What matters is how each ends.
"""

import math

from hypothesis import strategies as st

lengths = st.floats(0.2, 5.0)
angles = st.floats(-170.0, 170.0)
counts = st.integers(3, 9)


def star(n, inner, outer):
    """Corners of a star of n tips; a polygon where the radii are equal."""
    return [
        (r * math.cos(math.pi * k / n), r * math.sin(math.pi * k / n))
        for k in range(2 * n)
        for r in [outer if k % 2 == 0 else inner]
    ]


def prism(n, inner, outer, height, slant):
    """A star-shaped prism, leaning."""
    import cadquery as cq

    base = cq.Wire.makePolygon([cq.Vector(x, y, 0) for x, y in star(n, inner, outer)], close=True)
    path = cq.Wire.makePolygon([cq.Vector(0, 0, 0), cq.Vector(slant, 0, height)])
    return cq.Solid.sweep(base, [], path, True, False)


def loft(widths, heights, offset, length, round_end):
    """Between two rectangles, or from a rectangle to an ellipse, not above one another."""
    import cadquery as cq

    base = cq.Workplane().rect(widths[0], heights[0]).workplane(offset=length).center(offset, offset / 2)
    end = base.ellipse(widths[1] / 2, heights[1] / 2) if round_end else base.rect(widths[1], heights[1])
    return end.loft(combine=True).val()


def bend(radius, width, height, angle, hollow):
    """A bar or a tube, bent."""
    import cadquery as cq

    section = cq.Workplane("XZ").center(radius, 0).rect(width, height)
    if hollow:
        section = section.rect(width * hollow, height * hollow)
    return section.revolve(angle, (-radius, 0, 0), (-radius, 1, 0)).val()


def twist(width, height, length, angle):
    """A bar, twisted."""
    import cadquery as cq

    return cq.Workplane().rect(width, height).twistExtrude(length, angle).val()


def plate(width, height, thickness, holes, fillet):
    """A plate with round holes wherever they fall, its upright edges rounded."""
    import cadquery as cq

    part = cq.Workplane().rect(width, height).extrude(thickness)
    if fillet:
        part = part.edges("|Z").fillet(fillet)
    for x, y, r in holes:
        part = part.cut(cq.Workplane().center(x * width, y * height).circle(r).extrude(thickness))
    return part.val()


def boss(width, height, radius, tall):
    """A plate with a boss on it: sweepable only the long way, or not at all."""
    import cadquery as cq

    return cq.Workplane().box(width, width, height).faces(">Z").workplane().circle(radius).extrude(tall).val()


members = st.one_of(
    st.tuples(st.just(prism), st.tuples(counts, lengths, lengths, lengths, st.floats(-3, 3))),
    st.tuples(
        st.just(loft),
        st.tuples(st.tuples(lengths, lengths), st.tuples(lengths, lengths), st.floats(-3, 3), lengths, st.booleans()),
    ),
    st.tuples(
        st.just(bend),
        st.tuples(st.floats(0.5, 8.0), lengths, lengths, st.floats(5, 360), st.sampled_from([0, 0.3, 0.7, 0.95])),
    ),
    st.tuples(st.just(twist), st.tuples(lengths, lengths, lengths, angles)),
    st.tuples(
        st.just(plate),
        st.tuples(
            lengths,
            lengths,
            st.floats(0.05, 3.0),
            st.lists(st.tuples(st.floats(-0.55, 0.55), st.floats(-0.55, 0.55), st.floats(0.02, 1.0)), max_size=4),
            st.sampled_from([0, 0, 0.05, 0.1]),
        ),
    ),
    st.tuples(st.just(boss), st.tuples(lengths, st.floats(0.1, 2.0), st.floats(0.05, 2.0), lengths)),
)

options = st.fixed_dictionaries(
    {},
    optional={
        "layers": st.integers(1, 12),
        "bias": st.floats(0.2, 5.0),
        "functional": st.sampled_from("FGH"),
        "strategy": st.sampled_from(["source", "advancing", "both"]),
        "residual": st.booleans(),
        "smoothing": st.booleans(),
    },
)


TYPICAL = {
    # What an engineer would draw: nothing thinner than a tenth of the rest, no hole across the outline.
    "prism": lambda u: prism(int(u(3, 9)), u(1, 2), u(2, 3), u(1, 4), u(-1, 1)),
    "loft": lambda u: loft((u(2, 4), u(1, 3)), (u(2, 4), u(1, 3)), u(-1, 1), u(3, 5), u(0, 1) < 0.5),
    "bend": lambda u: bend(u(4, 8), u(1, 2), u(1, 2), u(20, 300), (0, 0.3, 0.7)[int(u(0, 3))]),
    "twist": lambda u: twist(u(1, 3), u(1, 3), u(3, 5), u(-90, 90)),
    "plate": lambda u: plate(
        u(3, 5), u(3, 5), u(0.3, 2), [(x, u(-0.3, 0.3), u(0.1, 0.5)) for x in (-0.3, 0.3)], u(0.05, 0.3)
    ),
    "boss": lambda u: boss(u(3, 5), u(0.5, 2), u(0.3, 1.3), u(0.3, 3)),
}
"""For each family a part from numbers that ``u(low, high)`` draws."""
