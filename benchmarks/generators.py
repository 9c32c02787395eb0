"""Parts with any number of faces: what the benchmarks of real CAD grow."""

from __future__ import annotations

import math

import cadquery as cq
import numpy as np
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Vec


def gear(n_teeth: int, *, twist: float = 20.0, width: float = 8.0) -> cq.Workplane:
    """A helical gear: four faces a tooth, its flanks B-splines of the twisted involute."""
    pitch = n_teeth / 2.0
    base, tip, root = pitch * math.cos(math.radians(20)), pitch + 1.0, pitch - 1.25
    start = max(base, root + 0.05)
    involute = lambda r: math.sqrt(max((r / base) ** 2 - 1, 0.0)) - math.atan(math.sqrt(max((r / base) ** 2 - 1, 0.0)))  # noqa: E731
    half = math.pi / (2 * n_teeth) + involute(pitch)
    radii = np.linspace(start, tip, 5)

    def place(r: float, angle: float) -> tuple[float, float]:
        return r * math.cos(angle), r * math.sin(angle)

    step = 2 * math.pi / n_teeth
    flank = [half - involute(r) for r in radii]
    wire = cq.Workplane().moveTo(*place(root, -flank[0]))
    for j in range(n_teeth):
        at = j * step
        wire = wire.lineTo(*place(radii[0], at - flank[0])) if root < start else wire
        up = [place(r, at - f) for r, f in zip(radii[1:], flank[1:], strict=True)]
        down = [place(r, at + f) for r, f in zip(radii[::-1][1:], flank[::-1][1:], strict=True)]
        wire = wire.spline(up, includeCurrent=True).threePointArc(place(tip, at), place(tip, at + flank[-1]))
        wire = wire.spline(down, includeCurrent=True).lineTo(*place(root, at + flank[0]))
        following = at + step
        wire = wire.threePointArc(place(root, at + step / 2), place(root, following - flank[0]))
    wire = wire.close()
    if twist:
        return wire.twistExtrude(width, twist)
    return wire.extrude(width)


def herringbone(n_teeth: int) -> cq.Workplane:
    """A gear whose teeth are helical one way in its lower half and the other way in its upper: eight faces a tooth."""
    lower = gear(n_teeth, twist=15.0, width=4.0)
    return lower.union(lower.mirror("XY"))


def spring(n_turns: int) -> cq.Workplane:
    """A coil of round wire."""
    path = cq.Wire.makeHelix(3.0, 3.0 * n_turns, 8.0)
    return cq.Workplane("XZ").center(8.0, 0).circle(1.0).sweep(cq.Workplane(path), isFrenet=True)


def embossed(n: int) -> cq.Workplane:
    """A sheet with n round embossings, lofted as splines, on both sides alike."""
    side = math.ceil(math.sqrt(n))
    sheet = cq.Workplane().rect(6 * side, 6 * side).extrude(1)
    places = [(6 * (k % side) - 3 * side + 3, 6 * (k // side) - 3 * side + 3) for k in range(n)]
    up = cq.Workplane("XY", (0, 0, 1)).pushPoints(places).circle(2).extrude(0.5, taper=20)
    down = cq.Workplane().pushPoints(places).circle(2).extrude(0.5, taper=20)
    return sheet.union(up).cut(down)


def plate(n_holes: int) -> cq.Workplane:
    """A plate with a square pattern of n holes."""
    side = math.ceil(math.sqrt(n_holes))
    places = [(6 * (k % side) - 3 * side + 3, 6 * (k // side) - 3 * side + 3) for k in range(n_holes)]
    sketch = cq.Sketch().rect(6 * side, 6 * side).push(places).circle(1.5, mode="s")
    return cq.Workplane().placeSketch(sketch).extrude(2)


def scattered(n_holes: int, *, off: float = 1.2) -> cq.Workplane:
    """A plate with n holes that lie off a square pattern, each by up to so much both ways."""
    side = math.ceil(math.sqrt(n_holes))
    random = np.random.default_rng(n_holes)
    places = [
        (6 * (k % side) - 3 * side + 3 + float(x), 6 * (k // side) - 3 * side + 3 + float(y))
        for k, (x, y) in enumerate(random.uniform(-off, off, (n_holes, 2)))
    ]
    sketch = cq.Sketch().rect(6 * side, 6 * side).push(places).circle(1.5, mode="s")
    return cq.Workplane().placeSketch(sketch).extrude(2)


def pits(n_pits: int) -> cq.Workplane:
    """A plate with a square pattern of n blind holes: no sweep of one solid, but columns of material."""
    side = math.ceil(math.sqrt(n_pits))
    places = [(6 * (k % side) - 3 * side + 3, 6 * (k // side) - 3 * side + 3) for k in range(n_pits)]
    sheet = cq.Workplane().rect(6 * side, 6 * side).extrude(4)
    return sheet.cut(cq.Workplane("XY", (0, 0, 2)).pushPoints(places).circle(1.5).extrude(4))


def crossed(n_holes: int) -> cq.Workplane:
    """A block with a square pattern of n holes, every fourth row of them met by a bore across."""
    side = math.ceil(math.sqrt(n_holes))
    places = [(6 * (k % side) - 3 * side + 3, 6 * (k // side) - 3 * side + 3) for k in range(n_holes)]
    holes = cq.Workplane().pushPoints(places).circle(1.2).extrude(10, both=True)
    rows = [(6 * j - 3 * side + 3, 0) for j in range(0, side, 4)]
    bores = cq.Workplane("YZ").pushPoints(rows).circle(0.8).extrude(6 * side, both=True)
    return cq.Workplane().box(6 * side, 6 * side, 6).cut(holes).cut(bores)


def slanted(n_holes: int) -> cq.Workplane:
    """A plate with n blind holes that lean four ways, by 10, 20 and 30 degrees: no sweep, no stack, no few cuts."""
    side = math.ceil(math.sqrt(n_holes))
    tools = []
    for k in range(n_holes):
        turn, lean = math.radians(90.0 * (k % 4)), math.radians(10.0 + 10.0 * (k % 3))
        way = cq.Vector(math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn), math.cos(lean))
        place = cq.Vector(6 * (k % side) - 3 * side + 3, 6 * (k // side) - 3 * side + 3, 0)
        tools.append(cq.Solid.makeCylinder(1.2, 8.0, place, way))
    sheet = cq.Workplane("XY", (0, 0, -3)).rect(6 * side, 6 * side).extrude(6)
    return sheet.cut(cq.Workplane(cq.Compound.makeCompound(tools)))


def undercut(n: int) -> cq.Workplane:
    """An embossed sheet on a thick one with a dovetail groove below and a blind bore from the side."""
    side = math.ceil(math.sqrt(n))
    base = cq.Workplane().rect(6 * side, 6 * side).extrude(-6)
    groove = cq.Workplane("XZ", (0, 3 * side + 1, 0)).polyline([(-1, -6.1), (1, -6.1), (2.2, -3), (-2.2, -3)])
    bore = cq.Workplane("YZ", (-3 * side - 1, 0, 0)).center(2 * side, -3).circle(1).extrude(3 * side)
    return embossed(n).union(base).cut(groove.close().extrude(6 * side + 2)).cut(bore)


def drilled(n_teeth: int) -> cq.Workplane:
    """A helical gear with a blind hole from every third gap between its teeth towards its axis."""
    radius = n_teeth / 2.0 - 3.25
    tools = []
    for k in range(0, n_teeth, 3):
        angle = 2 * math.pi * (k + 0.5) / n_teeth + math.radians(10)
        way = cq.Vector(math.cos(angle), math.sin(angle), 0)
        tools.append(cq.Solid.makeCylinder(0.35, 3.0, radius * way + cq.Vector(0, 0, 4), way))
    return gear(n_teeth).cut(cq.Workplane(cq.Compound.makeCompound(tools)))


def rack(n_blades: int) -> cq.Workplane:
    """A row of blades on a foot, all of one section: four faces a blade, two of them splines."""
    wire = cq.Workplane("XZ").moveTo(0, 0)
    for j in range(n_blades):
        x = 4.0 * j
        wire = wire.lineTo(x + 1, 0).spline([(x + 1.6, 2), (x + 1.4, 4), (x + 2.2, 6)], includeCurrent=True)
        wire = wire.lineTo(x + 2.8, 6).spline([(x + 2.4, 4), (x + 2.8, 2), (x + 2.6, 0)], includeCurrent=True)
    wire = wire.lineTo(4.0 * n_blades, 0).lineTo(4.0 * n_blades, -2).lineTo(0, -2).close()
    return wire.extrude(6)


def block(seed: int, n_features: int = 30, *, snap: float | None = None) -> cq.Workplane:
    """A block of 100 x 100 x 30 with pockets and bosses from both sides at random places: boxes, drums and slots.

    Where `snap` is given, places and lengths are multiples of it and slots lie along the block, as on a drawing;
    without it outlines may come as near to each other as chance has it.
    """
    random = np.random.default_rng(seed)

    def rounded(values: np.ndarray) -> list[float]:
        steps = values if snap is None else np.round(values / snap) * snap
        return [float(value) for value in steps]

    part = cq.Workplane().box(100, 100, 30)
    for _ in range(n_features):
        side = 1.0 if random.random() < 0.5 else -1.0
        is_pocket = random.random() < 0.6
        kind = random.integers(3)
        x, y = rounded(random.uniform(-40.0, 40.0, 2))
        length, width = rounded(random.uniform(6.0, 16.0, 2))
        depth = float(random.uniform(2.0, 12.0))
        turn = float(random.choice([0.0, 90.0]) if snap else random.uniform(0.0, 180.0))
        low, high = (15.0 - depth, 45.0) if is_pocket else (14.0, 15.0 + depth)
        tool = cq.Workplane("XY", (x, y, low))
        if kind == 0:
            tool = tool.rect(1.5 * length, 1.5 * width)
        elif kind == 1:
            tool = tool.circle(0.7 * length)
        else:
            tool = tool.slot2D(2.0 * max(length, width), min(length, width) / 1.2, turn)
        solid = tool.extrude(high - low)
        if side < 0:
            solid = solid.mirror("XY")
        part = part.cut(solid) if is_pocket else part.union(solid)
    return part


def bossed(n_columns: int) -> cq.Workplane:
    """A perforated plate of n columns: bosses, bored bosses, blind holes and holes, put together without a fuse."""
    side = math.ceil(math.sqrt(1.25 * n_columns))
    sites = [(4.0 * (k % side), 4.0 * (k // side)) for k in range(side * side)]
    kinds = [("boss", "bored", "blind", "boss", "hole")[k % 5] for k in range(side * side)]
    plate = cq.Wire.makePolygon(
        [cq.Vector(x, y, 2) for x, y in ((-4, -4), (4 * side, -4), (4 * side, 4 * side), (-4, 4 * side))], close=True
    )
    faces, holes_above, holes_below = [], [], []
    n_made = 1
    for (x, y), kind in zip(sites, kinds, strict=True):
        if kind != "hole" and n_made == n_columns:
            continue
        n_made += kind != "hole"
        outline = cq.Wire.makeCircle(1.2, cq.Vector(x, y, 2), cq.Vector(0, 0, 1))
        holes_above.append(outline)
        to = {"boss": 1.0, "bored": 1.5, "blind": -1.0, "hole": -2.0}[kind]
        wall, end = _drawn(outline, to)
        faces.append(wall)
        if kind == "hole":
            holes_below.append(end)
        elif kind == "bored":
            rim = cq.Wire.makeCircle(0.6, cq.Vector(x, y, 3.5), cq.Vector(0, 0, 1))
            bore, foot = _drawn(rim, -3.5)
            faces += [bore, cq.Face.makeFromWires(end, [rim])]
            holes_below.append(foot)
        else:
            faces.append(cq.Face.makeFromWires(end))
    sides, below = _drawn(plate, -2.0)
    faces += [sides, cq.Face.makeFromWires(plate, holes_above), cq.Face.makeFromWires(below, holes_below)]
    shell = cq.Shell.makeShell([part for face in faces for part in face.Faces()])
    return cq.Workplane(cq.Solid.makeSolid(shell).fix())


def _drawn(wire: cq.Wire, height: float) -> tuple[cq.Shape, cq.Wire]:
    """The wall that a wire draws when it is moved by a height, and the wire in its new place."""
    maker = BRepPrimAPI_MakePrism(wire.wrapped, gp_Vec(0, 0, height))
    return cq.Shape.cast(maker.Shape()), cq.Wire(maker.LastShape())


FAMILIES = {
    "gear": gear,
    "herringbone": herringbone,
    "spring": spring,
    "embossed": embossed,
    "plate": plate,
    "scattered": scattered,
    "pits": pits,
    "crossed": crossed,
    "slanted": slanted,
    "undercut": undercut,
    "drilled": drilled,
    "rack": rack,
}
