"""Parts as STEP text, and what befalls files: the material of the tests of bad input."""

import random
from pathlib import Path

FAMILY = ("box", "plate", "elbow", "loft", "twist")


def make_part(name):
    """One of five sweepable shapes, small enough to be meshed in no time."""
    import cadquery as cq

    if name == "box":
        return cq.Workplane().box(3, 2, 1)
    if name == "plate":
        return cq.Workplane().box(6, 4, 1).faces(">Z").workplane().hole(1.5)
    if name == "elbow":
        return cq.Workplane("XY").circle(1).revolve(90, (4, 0, 0), (4, 1, 0))
    if name == "loft":
        return cq.Workplane().rect(2, 2).workplane(offset=3).rect(1, 1.5).loft()
    if name == "twist":
        return cq.Workplane().rect(2, 1).twistExtrude(4, 40)
    raise ValueError(name)


def write_parts(folder):
    """Write the family as STEP files; returns name to path."""
    import cadquery as cq

    paths = {}
    for name in FAMILY:
        paths[name] = Path(folder) / f"{name}.step"
        cq.exporters.export(make_part(name), str(paths[name]))
    return paths


def flipped(data, seed):
    """A copy with one to four random bytes changed."""
    dice = random.Random(seed)
    damaged = bytearray(data)
    for _ in range(dice.randint(1, 4)):
        damaged[dice.randrange(len(damaged))] ^= 1 << dice.randrange(8)
    return bytes(damaged)
