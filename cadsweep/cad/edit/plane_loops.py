"""The cells that lines of a plane bound: loops nested in each other, and what OpenCASCADE makes of lines that branch.

Place in the flow: called for the pieces into which outlines divide each other.

Method: lines that hang together in one closed loop bound one cell; where they branch, OpenCASCADE's face builder makes
the cells. Groups of lines do not touch each other, so that one point of a group tells which cells it lies in: those
that a chain of curves turns round it once (:mod:`cadsweep.cad.geometry.plane_curves`). The innermost has the group's
own outline as a hole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from OCP.BOPAlgo import BOPAlgo_BuilderFace
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray, IntArray
from ...errors import CadError
from ..extract.solids import read_wires
from ..geometry.curves import EdgeCurve
from ..geometry.plane_curves import PlaneCurves, near_pairs
from ..shapes import EDGE, FACE, VERTEX, compound, index_map, listed, typed
from ..trial import attempted
from .lines_apart import components

Wire: TypeAlias = "list[tuple[int, bool]]"
"""Lines, and whether the cell is on their left."""

_FORWARD = TopAbs_Orientation.TopAbs_FORWARD
_SHARES = np.linspace(0.0, 1.0, 9)
"""Where lines are sampled for the sense of a loop and for a place inside."""
_HEIGHTS = (0.5, 0.31, 0.69, 0.83, 0.17, 0.43, 0.57)
"""Shares of a cell's extent at which it is looked through for a place inside."""


class Cell(NamedTuple):
    """A cell of the plane: its wires, outer wire first, and a point (3,) inside."""

    wires: list[Wire]
    place: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class _Region:
    """What one group of lines makes of a cell: an outer wire, holes that touch it, and those of other groups."""

    group: int
    wires: list[Wire]
    holes: list[Wire] = field(default_factory=list)


def plane_frame(plane: Any) -> tuple[FloatArray, FloatArray]:
    """Axes (2, 3) and origin (3,) of a plane."""
    position = plane.Position()
    axes = np.array([_row(position.XDirection()), _row(position.YDirection())])
    return axes, _row(position.Location())


def find_cells(
    edges: Sequence[Any], curves: Sequence[EdgeCurve], plane: Any, named: Callable[[int], str] = "line {}".format
) -> list[Cell]:
    """Make the cells between lines that meet in their ends alone.

    Parameters
    ----------
    edges : sequence of TopoDS_Edge
        Lines that meet share their vertices.
    curves : sequence of EdgeCurve
        Of the lines.
    plane : Geom_Plane
    named : callable
        What messages call a line.

    Raises
    ------
    CadError
        OpenCASCADE fails, or a cell has no inside.
    """
    flat = PlaneCurves(curves, *plane_frame(plane))
    samples = flat.points(np.arange(len(edges)), np.tile(_SHARES, (len(edges), 1)))
    corners = index_map(compound(edges), VERTEX)
    forward = [typed(edge.Oriented(_FORWARD), EDGE) for edge in edges]
    finders = TopExp.FirstVertex_s, TopExp.LastVertex_s
    ends = np.array([[corners.FindIndex(find(edge)) for find in finders] for edge in forward])
    group = components(corners.Extent() + 1, ends)[ends[:, 0]]
    loops = _simple_loops(flat, samples, ends, group)
    regions = _regions(edges, group, loops, plane, named)
    nested = _nested(flat, samples, group, loops, regions) if loops else regions
    if nested is None:
        # A line without bounds is in the way.
        nested = _regions(edges, group, {}, plane, named)
    nested.sort(key=lambda region: min(j for j, _ in region.wires[0]))
    wires = [[*region.wires, *region.holes] for region in nested]
    places = _places(flat, samples, wires, named) @ flat.axes + flat.origin
    return [Cell(own, place) for own, place in zip(wires, places, strict=True)]


def _simple_loops(flat: PlaneCurves, samples: FloatArray, ends: IntArray, group: IntArray) -> dict[int, Wire]:
    """By its group, every closed loop whose lines do not branch, its inside on the left."""
    degree = np.bincount(ends.ravel())
    branched = group[(degree[ends] != 2).any(axis=1) | ~flat.bounded()]
    at: dict[int, list[int]] = {}
    for j, pair in enumerate(ends.tolist()):
        for v in pair:
            at.setdefault(v, []).append(j)
    steps = np.diff(samples, axis=1)
    areas = (samples[:, :-1, 0] * steps[..., 1] - samples[:, :-1, 1] * steps[..., 0]).sum(axis=1) / 2.0
    h = (flat.last - flat.first) / (len(_SHARES) - 1)
    away = np.minimum(h * flat.slopes / 2.0, h * h * flat.bends / 8.0)
    doubts = (2.0 * away[:, None] * (np.linalg.norm(steps, axis=2) + 2.0 * away[:, None])).sum(axis=1)
    found: dict[int, Wire] = {}
    _, firsts = np.unique(group, return_index=True)
    for first in np.setdiff1d(firsts, firsts[np.isin(group[firsts], branched)]).tolist():
        wire, vertex = [(first, True)], int(ends[first, 1])
        while True:
            here = wire[-1][0]
            one, other = at[vertex]
            following = other if one == here else one
            if following == first:
                break
            forward = int(ends[following, 0]) == vertex
            wire.append((following, forward))
            vertex = int(ends[following, int(forward)])
        own = [j for j, _ in wire]
        area = float(sum(areas[j] if forward else -areas[j] for j, forward in wire))
        if abs(area) > float(doubts[own].sum()):
            found[int(group[first])] = wire if area > 0.0 else _turned(wire)
    return found


def _turned(wire: Wire) -> Wire:
    return [(j, not left) for j, left in reversed(wire)]


def _regions(
    edges: Sequence[Any], group: IntArray, loops: dict[int, Wire], plane: Any, named: Callable[[int], str]
) -> list[_Region]:
    """Simple loops, and the cells that OpenCASCADE makes of the other lines."""
    regions = [_Region(group=g, wires=[wire]) for g, wire in loops.items()]
    rest = np.flatnonzero(~np.isin(group, list(loops))).tolist()
    if not rest:
        return regions
    number = index_map(compound(edges), EDGE)
    for face in _faces([edges[j] for j in rest], plane, named(rest[0])):
        uses = [[(use.number, use.sense) for use in wire] for wire in read_wires(face, number)]
        if face.Orientation() != _FORWARD:
            raise CadError(f"what lies beside {named(uses[0][0][0])}, as seen along the columns, is turned over")
        loose = [j for wire in uses for j, sense in wire if sense is None]
        if loose:
            raise CadError(f"{named(loose[0])} bounds nothing, as seen along the columns: is the model closed there?")
        wires = [[(j, bool(sense)) for j, sense in wire] for wire in uses]
        regions.append(_Region(group=int(group[wires[0][0][0]]), wires=wires))
    return regions


def _faces(edges: Sequence[Any], plane: Any, first: str) -> list[Any]:
    """Plane faces between edges, the first of which has a name, their normals along the direction."""
    builder = BOPAlgo_BuilderFace()
    builder.SetFace(typed(BRepBuilderAPI_MakeFace(plane.Pln()).Face(), FACE))
    shapes = TopTools_ListOfShape()
    for edge in edges:
        shapes.Append(edge.Oriented(_FORWARD))
        shapes.Append(edge.Oriented(TopAbs_Orientation.TopAbs_REVERSED))
    builder.SetShapes(shapes)
    done = attempted(builder.Perform, "making cells of outlines", on=edges)
    if not done or builder.HasErrors() or not builder.Areas().Size():
        raise CadError(f"OpenCASCADE could not make cells of the outlines of the caps, {first} among them")
    # What lies outside of all outlines comes as a face of negative area.
    return [typed(face, FACE) for face in listed(builder.Areas()) if _area(face) > 0.0]


def _area(face: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return float(properties.Mass())


def _nested(
    flat: PlaneCurves, samples: FloatArray, group: IntArray, loops: dict[int, Wire], regions: Sequence[_Region]
) -> list[_Region] | None:
    """The regions with the outlines of the groups that lie right inside of them; None where that cannot be told."""
    own = [
        _Region(group=r.group, wires=[r.wires[0], *(w for w in r.wires[1:] if group[w[0][0]] == r.group)])
        for r in regions
    ]
    outlines = _outlines(group, loops, own)
    names, firsts = np.unique(group, return_index=True)
    points = samples[firsts, 0]
    uses = [[use for wire in region.wires for use in wire] for region in own]
    lines = [np.array([j for j, _ in some]) for some in uses]
    senses = [np.array([1.0 if left else -1.0 for _, left in some]) for some in uses]
    boxes = np.array([[flat.boxes[some, 0].min(axis=0), flat.boxes[some, 1].max(axis=0)] for some in lines])
    pairs = near_pairs(np.stack([points, points], axis=1), boxes, 0.0)
    groups = np.array([region.group for region in own])
    pairs = pairs[names[pairs[:, 0]] != groups[pairs[:, 1]]]
    if not len(pairs):
        return own
    owner = np.repeat(np.arange(len(pairs)), [len(lines[r]) for r in pairs[:, 1].tolist()])
    turns = flat.turns(
        points[pairs[:, 0]],
        owner,
        np.concatenate([lines[r] for r in pairs[:, 1].tolist()]),
        np.concatenate([senses[r] for r in pairs[:, 1].tolist()]),
    )
    if np.isnan(turns).any():
        return None
    pairs = pairs[turns != 0.0]
    # Of the regions round a group the innermost lies in the most others.
    depths = np.bincount(pairs[:, 0], minlength=len(names))
    depth_of = dict(zip(names.tolist(), depths.tolist(), strict=True))
    around: dict[int, int] = {}
    for g, r in zip(names[pairs[:, 0]].tolist(), pairs[:, 1].tolist(), strict=True):
        if g not in around or depth_of[own[around[g]].group] < depth_of[own[r].group]:
            around[g] = r
    for g, r in around.items():
        own[r].holes.append(outlines[g])
    return own


def _outlines(group: IntArray, loops: dict[int, Wire], regions: Sequence[_Region]) -> dict[int, Wire]:
    """By its group, what bounds the cell around it."""
    found = {g: _turned(wire) for g, wire in loops.items()}
    used = {use for region in regions for wire in region.wires for use in wire}
    for j, g in enumerate(group.tolist()):
        if g not in loops:
            found.setdefault(g, []).extend(use for use in ((j, True), (j, False)) if use not in used)
    return found


def _places(
    flat: PlaneCurves, samples: FloatArray, cells: Sequence[Sequence[Wire]], named: Callable[[int], str]
) -> FloatArray:
    """A point (n, 2) inside every cell.

    Raises
    ------
    CadError
        A cell has none.
    """
    uses = [[use for wire in wires for use in wire] for wires in cells]
    found = np.empty((len(cells), 2))
    waiting = list(range(len(cells)))
    # One height after the other: the widest stretch of all may have its middle on a line that touches it there.
    for height in _HEIGHTS:
        for c in waiting:
            drawn = samples[[j for j, _ in uses[c]]]
            found[c] = _widest(drawn[:, :-1].reshape(-1, 2), drawn[:, 1:].reshape(-1, 2), height)
        owner = np.repeat(np.arange(len(waiting)), [len(uses[c]) for c in waiting])
        lines = np.array([j for c in waiting for j, _ in uses[c]])
        senses = np.array([1.0 if left else -1.0 for c in waiting for _, left in uses[c]])
        turns = flat.turns(found[waiting], owner, lines, senses)
        # Of a line without bounds there is no telling but by its samples.
        unknown = np.bincount(owner, ~flat.bounded()[lines], len(waiting)) > 0.0
        waiting = [
            c for c, n, free in zip(waiting, turns.tolist(), unknown.tolist(), strict=True) if n != 1.0 and not free
        ]
        if not waiting:
            return found
    beside = " and ".join(dict.fromkeys(named(j) for j, _ in uses[waiting[0]][:2]))
    raise CadError(
        f"what lies between {beside}, as seen along the columns, is too narrow to be meshed: lay them on each other or "
        "move them apart"
    )


def _widest(starts: FloatArray, ends: FloatArray, share: float) -> FloatArray:
    """The middle (2,) of the widest stretch inside a polygon at a share of its extent; a corner where there is none."""
    low, high = float(starts[:, 1].min()), float(starts[:, 1].max())
    y = low + share * (high - low)
    across = (starts[:, 1] <= y) != (ends[:, 1] <= y)
    a, b = starts[across], ends[across]
    x = np.sort(a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0]))
    widths = x[1::2] - x[: len(x) - len(x) % 2 : 2]
    if not len(widths):
        return starts[0]
    k = int(widths.argmax())
    return np.array([(x[2 * k] + x[2 * k + 1]) / 2.0, y])


def _row(point: Any) -> FloatArray:
    return np.array([point.X(), point.Y(), point.Z()])


__all__ = ["Cell", "find_cells", "plane_frame"]
