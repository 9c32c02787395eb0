"""Boxes around bores that end in a wider one: each is swept from its mouth to the wall of the bore it opens into.

Place in the flow: a candidate of :mod:`.cutters` for a part as it is read. A block with a bore, bolt holes along it and
ports from its sides goes one way but for the ports. Planes through the axes of what crosses would go through the bolt
holes; a box does not leave the material between the mouth and the wall::

         __________________
        |  o     __     o  |      The sides of a box are walls of both neighbours: the rest of the block is swept along
        |      /    \\______|      the bore, the box along the port. The box reaches along the bore as far as its wall
        |     |      ->p___|      and the faces beside it do, and has a floor or a roof where it ends inside the
        |  o   \\____/   o  |      material.
        |__________________|

Several ports into one bore, on both sides of it, or from one bore into another, get a box each. The wall that a port
ends in may be a part of a cylinder: the end of a slot, one of two bores that overlap, a bore with a keyway.

Not handled: ports that are slanted to the bore, nearly as wide as it or far off its axis, and those that end before it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import pi

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from .axes import WHOLE, Axis, find_axes, is_hollow
from .central import Cutter, plane_tool
from .inside import inside_of
from .port_boxes import SQUARE, Port, PortBox

ROUND = 0.25 * pi
"""Radians that the wall a port ends in goes around, at least: a slot's end does, and one of two bores that overlap."""


def at_ports(solid: Solid) -> list[Cutter]:
    """Boxes around all bores that end in a wider one and have room for one; none where there is no such bore."""
    ports = list(_find_ports(solid, find_axes(solid, least_turn=ROUND)))
    if not ports:
        return []
    is_inside = inside_of(solid)
    boxes: list[PortBox] = []
    for port in ports:
        # What joins two bores is a port of both.
        box = None if any(port.faces & known.port.faces for known in boxes) else port.box(is_inside)
        boxes += [box] if box is not None else []
    whole, done = _levels(boxes, ports)
    tools = (
        *(plane_tool(solid, direction, place) for direction, place in whole),
        *(tool for box in boxes for tool in box.tools(done)),
    )
    if not tools:
        return []
    what = "a box around a bore that ends" if len(boxes) == 1 else f"boxes around {len(boxes)} bores that end"
    return [Cutter(kind="boxes", reason=f"{what} in a wider one", tools=tools, weight=solid.size, leads=True)]


def _levels(
    boxes: Sequence[PortBox], ports: Sequence[Port]
) -> tuple[list[tuple[FloatArray, FloatArray]], list[tuple[PortBox, tuple[int, int]]]]:  # fmt: skip
    """Planes, normal and place, through all of the part where boxes end inside it, and the sides that lie on them.

    The rest would have a notch there. A side between two boxes needs none, and none may go through a port.
    """
    planes: list[tuple[FloatArray, FloatArray]] = []
    done: list[tuple[PortBox, tuple[int, int]]] = []
    for box in boxes:
        normal = box.port.frame[2]
        for side, place in box.ends():
            level = float(place @ normal)
            near = box.port.near
            if any(box.is_beside(other, side[1]) for other in boxes if other is not box):
                continue
            if any(low + near < level < high - near for low, high in (port.reach(normal) for port in ports)):
                continue
            done.append((box, side))
            if all(abs(float(normal @ n)) < 1.0 - SQUARE or abs(float((place - p) @ n)) > near for n, p in planes):
                planes.append((normal, place))
    return planes, done


def _find_ports(solid: Solid, axes: Sequence[Axis]) -> Iterator[Port]:
    """The bores that end in the wall of a wider one, on each side of it."""
    at = np.linspace(0.0, 1.0, 17)
    bores = [axis for axis in axes if _is_bore(solid, axis)]
    axes = [axis for axis in axes if axis.turn > WHOLE]
    hollow = [axis for axis in axes if axis in bores]
    for own in hollow:
        for bore in bores:
            if abs(float(own.direction @ bore.direction)) > SQUARE or own.radius >= bore.radius:
                continue
            meeting = [e for e in solid.edges if _joins(e.faces, own.faces, bore.faces)]
            gap = own.place - bore.place
            origin = bore.place + float(gap @ bore.direction) * bore.direction
            for sign in (-1.0, 1.0):
                way = sign * own.direction
                frame = np.array([way, np.cross(bore.direction, way), bore.direction])
                here = [e for e in meeting if float((e.midpoint - origin) @ way) > 0.0]
                if not here:
                    continue
                line = [axis for axis in axes if axis.line == own.line]
                beyond = {f for axis in line for f in axis.faces if _is_beyond(solid, f, origin, way)}
                faces = frozenset(f for axis in line if axis in hollow for f in axis.faces & beyond)
                if not faces & own.faces:
                    continue
                edges = sorted({e for f in faces for e in solid.faces[f].edges})
                points = np.concatenate([solid.edges[e].curve.evaluate(at) for e in edges])
                yield Port(
                    solid=solid,
                    origin=origin,
                    frame=frame,
                    off=float(gap @ frame[1]),
                    radius=max(axis.radius for axis in line if axis.faces & faces),
                    bore=bore,
                    start=float(((np.concatenate([e.curve.evaluate(at) for e in here]) - origin) @ way).min()),
                    end=float(((points - origin) @ way).max()),
                    faces=faces,
                    bosses=frozenset(beyond - faces),
                    wider=tuple(a for a in line if a.faces & faces and a.radius > own.radius),
                )


def _joins(faces: Sequence[int], one: frozenset[int], other: frozenset[int]) -> bool:
    a, b = faces
    return (a in one and b in other) or (b in one and a in other)


def _is_beyond(solid: Solid, face: int, origin: FloatArray, way: FloatArray) -> bool:
    """Whether all of a face lies on one side of a point: what grazes the bore goes on beside it."""
    at = np.linspace(0.0, 1.0, 5)
    points = np.concatenate([solid.edges[e].curve.evaluate(at) for e in solid.faces[face].edges])
    return bool(((points - origin) @ way).min() > 0.0)


def _is_bore(solid: Solid, axis: Axis) -> bool:
    face = solid.faces[min(axis.faces)]
    return is_hollow(face, solid.edges[face.edges[0]].midpoint, axis.place, axis.direction)


__all__ = ["at_ports"]
