"""Heights of all nodes of a stack: on every cap exactly, between caps by their neighbours.

Place in the flow: after :mod:`.levels`, with the quads of the arrangement.

Method: a node is a place of the plane and a level. Over a place the caps of all cells around it fix some levels; those
between follow the mean heights of the levels, evened out along the lines between cells (:mod:`.rims`). There this may
differ from what lies inside of a cell: the difference is carried inwards by one harmonic function a level, which keeps
layers in order.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray, distinct
from ..errors import SurfaceMeshError
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from .along import heights_on_cap, heights_on_edge
from .harmonic import carried
from .rims import even_out, segments_of, short_sides
from .sheets import TOLERANCE

_SAME = 1e-9


@dataclass(frozen=True, kw_only=True, eq=False)
class Heights:
    """Heights of every node of the arrangement on every level.

    A level has two heights over a node where it is the floor and the roof of a passage at once: the layers below it end
    at the one, the layers above it begin at the other.

    Attributes
    ----------
    below, above : (n_layers + 1, n_nodes) float64
        Where the layer below a level ends, and where the layer above it begins; NaN below the lowest cap over a node
        and above the highest.
    """

    below: FloatArray
    above: FloatArray

    @property
    def open(self) -> npt.NDArray[np.bool_]:
        """Where the two differ."""
        return np.isfinite(self.below) & (self.below != self.above)


def place_nodes(stack: Stack, levels: Levels, mesh: QuadMesh, places: FloatArray) -> Heights:
    """Find the heights of all nodes.

    Parameters
    ----------
    stack, levels, mesh
    places : (n_layers + 1, n_nodes, 3) float64
        Where they are over the plane on every level.

    Raises
    ------
    SurfaceMeshError
        Two caps of one level have different heights over one node.
    """
    arrangement = stack.arrangement
    quads_of = quads_by_cell(stack, mesh)
    nodes_of = [distinct(quads) for quads in quads_of]
    under: dict[int, list[int]] = {}
    for c, caps in enumerate(arrangement.caps):
        for f in caps:
            under.setdefault(f, []).append(c)
    ends, begins = np.full((2, levels.n_layers + 1, len(mesh.points)), np.nan)
    tolerance = TOLERANCE * stack.solid.size + 2.0 * stack.solid.tolerance
    sources = set(stack.source)
    rims = stack.rims
    for cap, level in levels.caps.items():
        nodes = distinct(np.concatenate([nodes_of[c] for c in under[cap]]))
        face = stack.solid.faces[cap]
        curved = [] if face.kind == "plane" else rims[cap]
        own = [(stack.solid.edges[one], np.searchsorted(nodes, mesh.edge_nodes[e])) for one, e in curved]
        found = heights_on_cap(face, stack.direction, places[level, nodes], own)
        _fix((begins if cap in sources else ends)[level], nodes, found, tolerance, face.label())
    for e, over in arrangement.over.items():
        for station in set(over) & levels.stations.keys():
            edge = stack.solid.edges[station]
            nodes = mesh.edge_nodes[e]
            level = levels.stations[station]
            found = heights_on_edge(edge, stack.direction, places[level, nodes])
            _fix(ends[level], nodes, found, tolerance, edge.label())
    below, above = np.where(np.isnan(ends), begins, ends), np.where(np.isnan(begins), ends, begins)
    closed = np.abs(above - below) <= 10.0 * tolerance
    above[closed] = below[closed]
    crossed = above < below
    if crossed.any():
        node = int(np.nonzero(crossed)[1][0])
        place = stack.solid.units.place(mesh.points[node])
        raise SurfaceMeshError(f"two caps of one level cross each other over ({place})")
    heights = Heights(below=below, above=above)
    on_lines = np.zeros(len(mesh.points), dtype=bool)
    for e in arrangement.over:
        on_lines[mesh.edge_nodes[e]] = True
    sides = short_sides(mesh.quads, mesh.points, levels.heights)
    evened = on_lines.copy()
    evened[sides] = True
    known = np.isfinite(below[:, evened])
    fill_levels(heights, levels.heights)
    number = np.cumsum(evened) - 1
    segments, lengths = segments_of([mesh.edge_nodes[e] for e in arrangement.over], sides, mesh.points)
    found = even_out(below[:, evened], above[:, evened], known, levels.heights, number[segments], lengths)
    lines = np.flatnonzero(on_lines)
    known, found = known[:, number[lines]], found[:, number[lines]]
    for side in (below, above):
        side[:, lines] = np.where(known, side[:, lines], found)
    between: dict[tuple[int, int], list[IntArray]] = {}
    for quads, columns in zip(quads_of, stack.columns, strict=True):
        for a, b in columns:
            between.setdefault((levels.caps[a], levels.caps[b]), []).append(quads)
    for ends_at, cells in between.items():
        _relax(heights, levels, ends_at, cells, on_lines)
    return heights


def quads_by_cell(stack: Stack, mesh: QuadMesh) -> list[IntArray]:
    """Quads of every cell of the arrangement, in the order of the mesh."""
    order = np.argsort(mesh.faces, kind="stable")
    first, last = (
        np.searchsorted(mesh.faces[order], stack.arrangement.bottoms, side=side) for side in ("left", "right")
    )
    return [mesh.quads[order[a:b]] for a, b in zip(first, last, strict=True)]


def _fix(row: FloatArray, nodes: IntArray, found: FloatArray, tolerance: float, label: str) -> None:
    clash = np.abs(row[nodes] - found) > 10.0 * tolerance
    if clash.any():
        raise SurfaceMeshError(f"{label} does not meet the other caps of its level: nodes would have two heights")
    row[nodes] = np.where(np.isnan(row[nodes]), found, row[nodes])


def fill_levels(heights: Heights, means: FloatArray) -> None:
    """Levels between those that are known, by the mean heights of the levels; places with the same ones at once."""
    known = np.isfinite(heights.below)
    patterns, which = np.unique(np.packbits(known, axis=0), axis=1, return_inverse=True)
    order = np.argsort(which.ravel(), kind="stable")
    bounds = np.searchsorted(which.ravel()[order], np.arange(patterns.shape[1] + 1))
    for j in range(patterns.shape[1]):
        nodes = order[bounds[j] : bounds[j + 1]]
        rows = np.flatnonzero(known[:, nodes[0]])
        for low, high in pairwise(rows):
            share = (means[low + 1 : high] - means[low]) / (means[high] - means[low])
            first, last = heights.above[low, nodes], heights.below[high, nodes]
            between = first + share[:, None] * (last - first)
            heights.below[low + 1 : high, nodes] = heights.above[low + 1 : high, nodes] = between


def _relax(
    heights: Heights, levels: Levels, between: tuple[int, int], cells: list[IntArray], on_lines: np.ndarray
) -> None:
    """Carry what the lines around columns of the same levels differ by into them.

    All at once: lines hold the nodes on them, so that no column knows of another.
    """
    low, high = between
    if high - low < 2:
        return
    means = levels.heights
    share = (means[low + 1 : high] - means[low]) / (means[high] - means[low])

    def off(nodes: IntArray) -> FloatArray:
        below, above = heights.above[low, nodes], heights.below[high, nodes]
        return (heights.below[low + 1 : high][:, nodes] - below) / (above - below) - share[:, None]

    used = [distinct(quads) for quads in cells]
    rims = [nodes[on_lines[nodes]] for nodes in used]
    worst = np.maximum.reduceat(np.abs(off(np.concatenate(rims))).max(axis=0), np.cumsum([0, *map(len, rims[:-1])]))
    uneven = ~(worst <= _SAME) & (np.array([len(nodes) for nodes in used]) > np.array([len(rim) for rim in rims]))
    if not uneven.any():
        return
    nodes, local = np.unique(np.concatenate([cells[c] for c in np.flatnonzero(uneven)]), return_inverse=True)
    border = on_lines[nodes]
    inner = np.flatnonzero(~border)
    moved = carried(np.ascontiguousarray(off(nodes).T), border, local.reshape(-1, 4))[inner].T
    below, above = heights.above[low, nodes[inner]], heights.below[high, nodes[inner]]
    values = (share[:, None] + moved) * (above - below) + below
    heights.below[low + 1 : high, nodes[inner]] = heights.above[low + 1 : high, nodes[inner]] = values
