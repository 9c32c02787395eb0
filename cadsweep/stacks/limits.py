"""What the part itself allows the worst hexahedron of a stack, and where: sharp corners of outlines, and steep caps.

Place in the flow: beside :mod:`.columns`, for who is told of the mesh; candidates are ranked by the stack's score.

Method: two kinds of limits, of which the first holds whatever smoothing does.

* Nodes on faces stay there. Where two edges of a face hold one quad between them, or two faces one hexahedron, its
  scaled Jacobian is at most the sine of the angle between them: at sharp corners of caps and sharp edges between walls,
  and, as layers go on to the rim, at every convex edge between a cap and a wall.
* While columns are upright, a corner of two outlines in plan, at whatever heights, allows the sine of its angle, and a
  cap that leans the cosine between its normal and the direction. Smoothing draws columns aside and goes beyond these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from math import sin

import numpy as np

from ..arrays import FloatArray
from ..brep import Edge, Face, Solid
from ..stack import Arrangement, Stack, StackLimit
from .along import heights_on_edge
from .sides import ROUNDED_LEAN, SMOOTH, Sides

_NONE = StackLimit(value=1.0, reason="")
_SHARP = ("plane", "cone")
"""Caps that meet a wall at their own angle all along: others turn, and their chords meet it at a blunter one."""


def find_limit(solid: Solid, sides: Sides) -> StackLimit:
    """Find what edges and corners of the part allow any mesh of its columns whose nodes are on its faces.

    Parameters
    ----------
    solid : Solid
    sides : Sides
    """
    found = min([*_sharp_edges(solid, sides), *_sharp_caps(solid, sides)], key=lambda pair: pair[0], default=None)
    return _NONE if found is None or found[0] >= 1.0 else StackLimit(value=found[0], reason=found[1]())


Found = tuple[float, Callable[[], str]]
"""A limit, and what makes its words: of thousands one is told."""


def _sharp_edges(solid: Solid, sides: Sides) -> Iterator[Found]:
    """Convex edges with one hexahedron between their faces."""
    for edge in solid.edges:
        faces = [solid.faces[f] for f in edge.faces]
        own = [face for face in faces if face.id in sides.caps]
        if len(own) == 1:
            one = own[0].kind in _SHARP and edge.dihedral < np.pi
        else:
            one = not own and all(face.kind == "plane" for face in faces) and edge.dihedral < np.pi / 2
        if one:
            yield sin(edge.dihedral), partial(_edge_words, edge, faces)


def _edge_words(edge: Edge, faces: Sequence[Face]) -> str:
    angle = np.degrees(edge.dihedral)
    return f"{faces[0].label()} and {faces[1].label()} meet at {angle:.3g} degrees at {edge.label()}"


def _sharp_caps(solid: Solid, sides: Sides) -> Iterator[Found]:
    """Sharp corners of straight edges of caps."""
    for f in sides.caps:
        for loop in solid.faces[f].loops:
            for j, angle in enumerate(loop.angles):
                pair = [solid.edges[loop.edges[j - 1]], solid.edges[loop.edges[j]]]
                if angle < np.pi / 2 and all(edge.kind == "line" for edge in pair):
                    vertex = pair[1].start if loop.forward[j] else pair[1].end
                    yield sin(angle), partial(_corner_words, solid, f, vertex, angle)


def _corner_words(solid: Solid, face: int, vertex: int, angle: float) -> str:
    where = f"{np.degrees(angle):.3g} degrees at ({solid.units.place(solid.vertices[vertex])})"
    return f"edges of {solid.faces[face].label()} meet at {where}"


def is_round_across(stack: Stack) -> bool:
    """Whether a cap turns until it runs along the columns on two sides: a shaft, a bore or a slot's end across them.

    A rounding of an edge goes on into a cap on one side; what does not is better swept along its own axis.
    """
    edges, caps = stack.solid.edges, {*stack.source, *stack.target}

    def runs_out(f: int, e: int) -> bool:
        other = edges[e].faces[edges[e].faces[0] == f]
        upright = other not in caps or (other in stack.rounded and (other in stack.source) != (f in stack.source))
        return upright and abs(edges[e].dihedral - np.pi) <= SMOOTH

    return any(sum(runs_out(f, e) for e in stack.solid.faces[f].edges) >= 2 for f in stack.rounded)


def find_upright_limit(solid: Solid, sides: Sides, arrangement: Arrangement) -> StackLimit:
    """Find the worst of the corners of all cells and of the caps, for columns that are upright.

    Parameters
    ----------
    solid : Solid
    sides : Sides
    arrangement : Arrangement
        The one that is meshed: outlines that were laid together meet elsewhere than those of the part.
    """
    corner = _sharpest_corner(solid, sides, arrangement)
    cap = _steepest_cap(solid, sides)
    return min(corner, cap, key=lambda limit: limit.value)


def _sharpest_corner(solid: Solid, sides: Sides, arrangement: Arrangement) -> StackLimit:
    prism = arrangement.prism
    corners = [
        (angle, loop.directed[j])
        for f, caps in zip(arrangement.bottoms, arrangement.caps, strict=True)
        if caps
        for loop in prism.faces[f].loops
        for j, angle in enumerate(loop.angles)
    ]
    angle, (edge, forward) = min(corners, default=(np.pi / 2, (0, True)), key=lambda corner: corner[0])
    if angle >= np.pi / 2:
        return _NONE
    vertex = prism.vertices[prism.edges[edge].start if forward else prism.edges[edge].end]
    place = _on_part(solid, sides.direction, vertex, arrangement.over[edge])
    return StackLimit(
        value=float(np.sin(angle)),
        reason=f"two outlines of caps meet at {np.degrees(angle):.3g} degrees at ({solid.units.place(place)})",
    )


def _on_part(solid: Solid, direction: FloatArray, place: FloatArray, over: tuple[int, ...]) -> FloatArray:
    """The lowest point over a place that an edge of the part has there."""
    height = min(
        (float(heights_on_edge(solid.edges[e], direction, place[None])[0]) for e in over),
        default=float(place @ direction),
    )
    return np.asarray(place + (height - place @ direction) * direction)


def _steepest_cap(solid: Solid, sides: Sides) -> StackLimit:
    if sides.steepest_cap is None:
        return _NONE
    label = solid.faces[sides.steepest_cap].label()
    if sides.steepest_cap in sides.rounded:
        return StackLimit(value=ROUNDED_LEAN, reason=f"{label} turns until it runs along the columns")
    lean = np.degrees(np.arcsin(sides.steepest))
    return StackLimit(value=sides.steepest, reason=f"{label} leans {lean:.3g} degrees from the columns at its steepest")


__all__ = ["find_limit", "find_upright_limit", "is_round_across"]
