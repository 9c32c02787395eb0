"""A mesh of the design carried onto the model: what its lines and faces are there, and where its nodes go.

Place in the flow: ``pipeline`` has the design meshed like any other solid, and carries the mesh.

Method: every quad of the skin is of a patch of the model (:mod:`.patches`). Where quads of two patches meet are lines
of the mesh; they answer runs of the model's edges (:mod:`.runs`) one to one, and their ends its corners, or places on a
run where the design has a corner and the model a blend. Lines go onto their runs; then lines of the design that a blend
has replaced go to the nearest points of their patch, the middle of the blend; then all other nodes of the skin; the
inside follows harmonically. Nothing is bent to fit: every run must be covered by lines once, and the skin have the
topology of the model.

Not handled: what untangling and smoothing are for.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from ..arrays import BoolArray, FloatArray, IntArray, distinct
from ..brep import Solid, Surface
from ..cells import HEX_EDGES
from ..errors import SurfaceMeshError
from ..harmonic import followed, sides_of
from .lines import Line, find_lines
from .runs import LaidLine, Run, as_curve, find_runs

_SAME = 1e-6
"""Share of the solid's size within which a node is at a vertex, or on an edge."""
_EVEN = 0.4
"""Share of its place's own step that projected nodes on a line are apart at least; else they keep their shares."""
_ALONG = np.linspace(0.0, 1.0, 10)[1:-1]
"""Places between the ends of an edge of a design for which lines on the model are looked for."""
_COVERED = 1e-6
"""Share of a run's length that its lines may leave out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Carried:
    """Where a mesh of the design is on the model.

    Attributes
    ----------
    points : (n, 3) float64
    lines : tuple of LaidLine
    patches : (q,) int64
        Patch of every quad of the skin.
    surfaces : dict of int to Surface
        By patch.
    surface, curve : (n,) int64
        Patch that a node may move in, and line that it may move along; -1 for neither.
    """

    points: FloatArray
    lines: tuple[LaidLine, ...]
    patches: IntArray
    surfaces: dict[int, Surface]
    surface: IntArray
    curve: IntArray


def carry(  # noqa: PLR0917
    solid: Solid,
    gone: Collection[int],
    patch_of: IntArray,
    surfaces: dict[int, Surface],
    points: FloatArray,
    hexes: IntArray,
    quads: IntArray,
    faces: IntArray,
) -> Carried:
    """Carry a mesh of the design onto the model.

    Parameters
    ----------
    solid : Solid
        The model.
    gone : collection of int
        Its faces that the design has not.
    patch_of : (n_faces,) int64
        Patch of each of its faces.
    surfaces : dict of int to Surface
    points : (n, 3) float64
        Nodes on the design.
    hexes : (m, 8) int64
    quads : (q, 4) int64
        The skin, outward.
    faces : (q,) int64
        Face of the model that each quad is on in the design.

    Raises
    ------
    SurfaceMeshError
        The mesh has not the edges of the model.
    """
    patches = patch_of[faces]
    segments, pairs = sides_of(quads)
    laid, found, is_line, is_inner = _laid(solid, gone, patch_of, points, segments, faces[pairs])
    on_line, inner = np.zeros((2, len(points)), dtype=bool)
    on_line[segments[is_line]], inner[segments[is_inner]] = True, True
    found = spread(points, found, on_line, hexes, quads, patches, surfaces, first=inner)
    surface, curve = np.full((2, len(points)), -1, dtype=np.int64)
    surface[quads] = patches[:, None]
    surface[on_line] = -1
    for number, line in enumerate(laid):
        curve[line.nodes[1:-1]] = number
    return Carried(
        points=found, lines=tuple(laid), patches=patches, surfaces=surfaces, surface=surface, curve=curve
    )  # fmt: skip


def spread(  # noqa: PLR0917
    rest: FloatArray,
    points: FloatArray,
    is_set: BoolArray,
    hexes: IntArray,
    quads: IntArray,
    patches: IntArray,
    surfaces: dict[int, Surface],
    *,
    first: BoolArray | None = None,
    by_length: bool = False,
) -> FloatArray:
    """The points (n, 3); those that are not set follow from `rest`: on patches, some of them at first, then inside.

    `by_length`: the inside as :func:`cadsweep.harmonic.followed` says.
    """
    found, is_set = points.copy(), is_set.copy()
    every = np.ones(len(points), dtype=bool)
    for wanted in (every,) if first is None else (first, every):
        for patch in np.unique(patches).tolist():
            own = quads[patches == patch]
            nodes = np.unique(own)
            nodes = nodes[wanted[nodes] & ~is_set[nodes]]
            if len(nodes):
                sides = np.stack([own, np.roll(own, -1, axis=1)], axis=-1).reshape(-1, 2)
                moved = followed(rest, found, sides, is_set)[nodes]
                found[nodes] = surfaces[patch].evaluate(surfaces[patch].project(moved))
        is_set[quads] |= wanted[quads]
    return followed(rest, found, hexes[:, HEX_EDGES].reshape(-1, 2), is_set, by_length=by_length)


def check_edges(solid: Solid, gone: Collection[int], patch_of: IntArray, design: Solid, faces: IntArray) -> None:
    """Ask whether the edges of a design can be laid on the model's, before it has a mesh.

    Parameters
    ----------
    solid : Solid
        The model.
    gone : collection of int
        Its faces that the design has not.
    patch_of : (n_faces,) int64
        Patch of each of its faces.
    design : Solid
    faces : (n_design_faces,) int64
        Face of the model that each of its faces is.

    Raises
    ------
    SurfaceMeshError
        They cannot, so no mesh can that follows them.
    """
    points, segments, n = [design.vertices], [], len(design.vertices)
    for edge in design.edges:
        points.append(edge.curve.evaluate(_ALONG))
        chain = np.array([edge.start, *range(n, n + len(_ALONG)), edge.end], dtype=np.int64)
        segments.append(np.stack([chain[:-1], chain[1:]], axis=1))
        n += len(_ALONG)
    beside = faces[np.array([edge.faces for edge in design.edges], dtype=np.int64)]
    beside = np.repeat(beside, len(_ALONG) + 1, axis=0)
    _laid(solid, gone, patch_of, np.concatenate(points), np.concatenate(segments), beside)


def _laid(  # noqa: PLR0917
    solid: Solid, gone: Collection[int], patch_of: IntArray, points: FloatArray, segments: IntArray, faces: IntArray
) -> tuple[list[LaidLine], FloatArray, BoolArray, BoolArray]:
    """Lines of segments (s, 2) between faces (s, 2) on the model, where points are then, and what `_lines` finds."""
    close = _SAME * solid.size
    away, _ = cKDTree(points[distinct(segments)]).query(solid.vertices)
    runs, patches = find_runs(solid, patch_of, set(np.flatnonzero(away <= close).tolist())), patch_of[faces]
    is_line, is_inner = _lines(solid, gone, runs, points, segments, faces, patches)
    corners = [solid.vertices[v] for v in sorted({v for run in runs if not run.is_closed for v in run.ends})]
    lines = find_lines(segments[is_line], np.sort(patches[is_line], axis=1), points, corners, close)
    laid, found = _on_runs(solid, gone, runs, lines, points)
    return laid, found, is_line, is_inner


def _lines(  # noqa: PLR0917
    solid: Solid,
    gone: Collection[int],
    runs: Sequence[Run],
    points: FloatArray,
    segments: IntArray,
    faces: IntArray,
    patches: IntArray,
) -> tuple[BoolArray, BoolArray]:
    """Which segments (s, 2) between faces (s, 2) are lines, and which are of design edges within a patch.

    Within a patch those are lines that lie on a sharp edge of the model. Where that ends in a mitre of blends, the rest
    of the design's edge goes on along it.
    """
    is_line = patches[:, 0] != patches[:, 1]
    is_inner = ~is_line & (faces[:, 0] != faces[:, 1])
    for run in runs:
        own = np.flatnonzero(is_inner & (patches[:, 0] == run.pair[0]) & (run.pair[0] == run.pair[1]))
        if not len(own):
            continue
        off = run.distance(points[segments[own].ravel()]).reshape(-1, 2).max(axis=1)
        is_line[own[_hanging(segments[own], faces[own], off < _SAME * solid.size)]] = True
    return is_line, is_inner & ~is_line


def _hanging(segments: IntArray, faces: IntArray, chosen: BoolArray) -> BoolArray:
    """Which segments (s, 2) hang together with those chosen through others between the same faces (s, 2)."""
    beside = np.sort(faces, axis=1)
    while True:
        reached = {(n, *pair) for own, pair in zip(segments[chosen].tolist(), beside[chosen].tolist(), strict=True)
                   for n in own}  # fmt: skip
        grown = np.array([
            (a, *pair) in reached or (b, *pair) in reached
            for (a, b), pair in zip(segments.tolist(), beside.tolist(), strict=True)
        ], dtype=bool)  # fmt: skip
        if not chosen.any() or (grown == chosen).all():
            return chosen
        chosen = grown


def _on_runs(
    solid: Solid, gone: Collection[int], runs: Sequence[Run], lines: Sequence[Line], points: FloatArray
) -> tuple[list[LaidLine], FloatArray]:
    """Every line on the run nearest to it, and the points with these nodes there.

    What of a sharp edge within a patch is in a mitre of blends may be left out: the design has a corner there.
    """
    run_of = _runs_of(solid, runs, lines, points)
    at_end: dict[int, list[int]] = {}
    for line, r in zip(lines, run_of, strict=True):
        for node in line.nodes[[0, -1]].tolist():
            at_end.setdefault(node, []).append(r)
    found = points.copy()
    for node, own in at_end.items():
        found[node] = _place(solid, [runs[r] for r in own], points[node])
    laid, covered = [], np.zeros(len(runs))
    for line, r in zip(lines, run_of, strict=True):
        run = runs[r]
        at = fractions_of(solid, run, found[line.nodes[[0, -1]]], points[line.nodes])
        found[line.nodes[1:-1]] = run.evaluate(at[1:-1])
        covered[r] += abs(at[-1] - at[0])
        laid.append(LaidLine(nodes=line.nodes, run=run, curve=as_curve(run, float(at[0]), float(at[-1]))))
    for run, share in zip(runs, covered.tolist(), strict=True):
        mitres = sum(edge.length for edge in run.edges if set(edge.faces) & set(gone)) / run.length
        if not -_COVERED <= 1.0 - share <= mitres * (run.pair[0] == run.pair[1]) + _COVERED:
            raise SurfaceMeshError(f"{run.edges[0].label()}: {share:.2f} of it are lines of the design's mesh")
    return laid, found


def _runs_of(solid: Solid, runs: Sequence[Run], lines: Sequence[Line], points: FloatArray) -> list[int]:
    """The run that each line goes on: near to it, and between two patches so that none is left without a line."""
    found = [0] * len(lines)
    by_pair: dict[tuple[int, int], list[int]] = defaultdict(list)
    for number, line in enumerate(lines):
        by_pair[line.pair].append(number)
    for pair, own in by_pair.items():
        there = [r for r, run in enumerate(runs) if run.pair == pair]
        if not there:
            where = solid.units.place(points[lines[own[0]].nodes[0]])
            raise SurfaceMeshError(f"the design has an edge at ({where}) that the model has not")
        away = np.array([[runs[r].distance(points[lines[i].nodes]).mean() for r in there] for i in own])
        nearest = away.argmin(axis=1)
        n_more = len(own) - len(there)
        if pair[0] != pair[1] and n_more >= 0:
            any_run = np.repeat(away.min(axis=1, keepdims=True), n_more, axis=1)
            _, chosen = linear_sum_assignment(np.concatenate([away, any_run], axis=1))
            nearest = np.where(chosen < len(there), chosen, nearest)
        for i, k in zip(own, nearest.tolist(), strict=True):
            found[i] = there[k]
    return found


def _place(solid: Solid, runs: Sequence[Run], point: FloatArray) -> FloatArray:
    """Where a node goes at which lines end: a corner of all their runs, or, on one run, the nearest place."""
    if len(runs) == 1:
        return runs[0].nearest(point[None])[0]
    if len(runs) == 2 and runs[0] is runs[1]:
        near = runs[0].nearest(point[None])[0]
        ends = [] if runs[0].is_closed else [solid.vertices[v] for v in runs[0].ends]
        if all(np.linalg.norm(near - end) > _SAME * solid.size for end in ends):
            return near
    common = set.intersection(*(set(run.ends) for run in runs))
    if not common:
        raise SurfaceMeshError(f"no corner of the model answers the design's at ({solid.units.place(point)})")
    corners = solid.vertices[sorted(common)]
    place: FloatArray = corners[np.argmin(np.linalg.norm(corners - point, axis=1))]
    return place


def fractions_of(solid: Solid, run: Run, ends: FloatArray, points: FloatArray) -> FloatArray:
    """Where the nodes of a line lie on its run, in order: near to where they are, else by shares of its length.

    A corner is the end of its run also where the model has it beside the curve of its edge.
    """
    first, last = (_fraction(solid, run, end) for end in ends)
    lengths = np.cumsum([0.0, *np.linalg.norm(np.diff(points, axis=0), axis=1)])
    shares = lengths / lengths[-1]
    if run.is_closed:
        ways = [last - first + turn for turn in (-1.0, 0.0, 1.0)]
        ways = [way for way in ways if _COVERED < abs(way) <= 1.0 + _COVERED]
        off = [np.linalg.norm(run.evaluate(first + shares * way) - points, axis=1).sum() for way in ways]
        last = first + ways[int(np.argmin(off))]
    elif abs(last - first) < _COVERED:
        raise SurfaceMeshError(f"{run.edges[0].label()}: a line of the design's mesh has no room on it")
    even = first + shares * (last - first)
    at = run.project(points)
    if run.is_closed:
        at = even + (at - even + 0.5) % 1.0 - 0.5
    at[[0, -1]] = first, last
    steps = np.diff(at) / np.diff(even)
    return at if steps.min() > _EVEN else even


def _fraction(solid: Solid, run: Run, place: FloatArray) -> float:
    at_end = [] if run.is_closed else [(solid.vertices[v] == place).all() for v in run.ends]
    return float(at_end.index(True)) if any(at_end) else float(run.project(place[None])[0])


__all__ = ["Carried", "carry", "check_edges", "fractions_of", "spread"]
