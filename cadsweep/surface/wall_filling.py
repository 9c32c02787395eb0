"""A face of a cap with rows of quads along walls, and whatever fills the rest.

Place in the flow: ``filling`` comes here with outlines that have walls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import SurfaceMeshError
from ..mesh import WallRows
from ..polygons import interior_angles
from .annulus import fill_wall
from .chart import Chart
from .gmsh_quads import mesh_polygon, settings_for
from .outline import FaceQuads, Outline
from .round_core import core_of_polygon
from .transfinite import GOOD_ENOUGH, grid_of_polygon
from .wall_columns import Wall
from .walls import LaidRows, lay_all_walls

_KEPT = 0.99
"""Part of a first height from which on it counts as kept."""
_SHARP = np.radians(10)
"""Angle between two walls up to which their corner is why rows have no room."""
_FLAT_CORNER = np.radians(150)
"""Angle on the target cap from which on a node is no corner of a grid there."""


def lay_rows_along_walls(outline: Outline) -> FaceQuads:
    """Rows of quads of the heights asked for along walls, a grid or gmsh's quads inside.

    Raises
    ------
    SurfaceMeshError
        There is no room for the rows, or no quads for what they leave.
    """
    label = outline.face.label()
    boundary = np.concatenate(outline.nodes)
    best: FaceQuads | None = None
    reasons = [_no_room(outline)]
    for chart in outline.charts(outline.nodes):
        rows = lay_all_walls(chart.boundary, _walls_in(outline, chart))
        if rows is None:
            continue
        laid = np.concatenate([own.inner for own in rows])
        places = np.concatenate([*chart.boundary, laid])
        left = [places[loop] for loop in rows[-1].left]
        exact = None if chart.isometric else _rows_on_surface(outline, chart, rows)
        opposite = outline.opposite_of(boundary)
        for own in rows:  # a corner of what is left is straight where that of the wall is
            opposite = np.concatenate([opposite, np.full(len(own.inner), np.nan)])
            opposite[own.nodes[:, -1]] = opposite[own.base]
        angles = np.concatenate([opposite[loop] for loop in rows[-1].left])
        for more, others in _fillings_inside(outline, chart, left, angles, reasons):
            number = np.concatenate([*rows[-1].left, len(places) + np.arange(len(more), dtype=np.int64)])
            made = outline.lift(
                chart,
                np.concatenate([laid, more]),
                np.concatenate([*(own.quads for own in rows), number[others]]),
                boundary,
                n_rows=len(laid),
                rows=exact,
            )
            if best is None or made.better_than(best):
                best = replace(made, walls=_wall_rows(outline, chart, rows), notes=_thinned(outline, rows))
            if best.worst >= GOOD_ENOUGH:
                return best
    if best is None:
        raise SurfaceMeshError(f"{label}: wall layers cannot be laid: {'; '.join(dict.fromkeys(reasons[-2:]))}")
    return best


def _no_room(outline: Outline) -> str:
    """Why rows have no place: the sharpest corner between two walls, where that is one; else they are too thick."""
    assert outline.walls is not None
    walls = outline.walls.layers
    corners = [
        (angle, outline.edge_nodes[edge][0 if forward else -1])
        for loop in outline.loops
        for angle, (last, _), (edge, forward) in zip(outline.angles(loop), [loop[-1], *loop], loop, strict=False)
        if last in walls and edge in walls
    ]
    angle, node = min(corners, default=(np.pi, 0))
    if angle > _SHARP:
        return "there is no room for them; ask for fewer or thinner layers"
    place = outline.face.units.place(outline.known[node])
    return (
        f"the corner of {np.degrees(angle):.2g} degrees between two walls at {place} leaves no room for them; ask for "
        "fewer or thinner layers, or round it"
    )


def _walls_in(outline: Outline, chart: Chart) -> list[Wall]:
    """What is asked of the segments of a chart's outline, in its lengths."""
    assert outline.walls is not None
    found = []
    for loop, nodes, places in zip(outline.loops, outline.nodes, chart.boundary, strict=True):
        asked = [outline.walls.layers.get(e) for e, _ in loop for _ in range(int(outline.counts[e]))]
        points = outline.known[nodes]
        scale = _lengths(places) / _lengths(points)
        found.append(
            Wall(
                n=np.array([0 if own is None else own.n for own in asked]),
                first=scale * np.array([0.0 if own is None else own.first for own in asked]),
                growth=np.array([1.0 if own is None else own.growth for own in asked]),
            )
        )
    return found


def _rows_on_surface(outline: Outline, chart: Chart, rows: list[LaidRows]) -> tuple[FloatArray, FloatArray]:
    """Nodes of rows on a curved surface and their parameters: a chart is exact at its outline, not close to it."""
    surface = outline.face.surface
    flat, _ = _frames(
        [np.column_stack([loop, np.zeros(len(loop))]) for loop in chart.boundary], np.array([[0.0, 0.0, 1.0]])
    )
    known = [outline.known[nodes] for nodes in outline.nodes]
    up = -surface.normals(surface.project(np.concatenate(known)))
    along, across = _frames(known, up)
    points = []
    for own, scale in zip(rows, _scales(outline, chart, rows), strict=True):
        tangent = flat[own.base, :2]
        ahead = np.einsum("ci,ci->c", own.lean, tangent)
        aside = tangent[:, 0] * own.lean[:, 1] - tangent[:, 1] * own.lean[:, 0]
        step = ahead[:, None] * along[own.base] + aside[:, None] * across[own.base]
        heights = own.heights * scale[:, None]
        begin = np.concatenate(known)[own.base]
        points.append((begin[:, None] + heights[..., None] * step[:, None]).reshape(-1, 3))
    uv = surface.project(np.concatenate(points))
    return surface.evaluate(uv), uv


def _frames(loops: list[FloatArray], up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (b, 3) along loops at their nodes, and to their left about `up` (b, 3)."""
    steps = [np.roll(loop, -1, axis=0) - loop for loop in loops]
    steps = [step / np.linalg.norm(step, axis=1, keepdims=True) for step in steps]
    along = np.concatenate([step + np.roll(step, 1, axis=0) for step in steps])
    along -= np.einsum("bi,bi->b", along, np.broadcast_to(up, along.shape))[:, None] * up
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    return along, np.cross(np.broadcast_to(up, along.shape), along)


def _scales(outline: Outline, chart: Chart, rows: list[LaidRows]) -> list[FloatArray]:
    """Lengths on the surface of a unit length in a chart, where columns begin."""
    scale = np.concatenate(
        [_lengths(outline.known[n]) / _lengths(p) for n, p in zip(outline.nodes, chart.boundary, strict=True)]
    )
    return [scale[own.base] for own in rows]


def _lengths(loop: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1))


def _fillings_inside(
    outline: Outline, chart: Chart, left: list[FloatArray], angles: FloatArray, reasons: list[str]
) -> Iterator[tuple[FloatArray, IntArray]]:
    """Quads for what rows leave of a chart: a grid of four sides, rings around a core or a hole, then gmsh's."""
    if len(left) == 1:
        grid = grid_of_polygon(left[0]) if not (angles > _FLAT_CORNER).any() else None
        rings = core_of_polygon(left[0]) if _is_round(left[0], angles) else None
        yield from (found for found in (grid, rings) if found is not None)
    elif len(left) == 2 and len(left[0]) == len(left[1]):
        first = len(left[0])
        if _is_round(left[0], angles[:first]) and _is_round(left[1][::-1], 2 * np.pi - angles[first:][::-1]):
            around = fill_wall(left, angles)
            yield from () if around is None else (around,)
    background = outline.background(replace(chart, boundary=tuple(left)), outline.nodes)
    for setting in settings_for(left):
        try:
            yield mesh_polygon(left, setting, angles, background)
        except SurfaceMeshError as error:
            reasons.append(error.message)


def _is_round(loop: FloatArray, opposite: FloatArray) -> bool:
    """Whether a polygon (n, 2) is convex and has no corner that is one on the other cap, too."""
    angles = interior_angles(loop)
    flat = min(_FLAT_CORNER, np.pi - 3.0 * np.pi / len(loop))
    return bool((np.fmax(angles, opposite) > flat).all() and (angles < 2 * np.pi - _FLAT_CORNER).all())


def _wall_rows(outline: Outline, chart: Chart, rows: list[LaidRows]) -> tuple[WallRows, ...]:
    """Rows in the cap's numbers, their lengths on the surface."""
    assert outline.walls is not None
    boundary = np.concatenate(outline.nodes)
    n_inner = sum(len(own.inner) for own in rows)
    ids = np.concatenate([boundary, len(outline.known) + np.arange(n_inner, dtype=np.int64)])
    return tuple(
        WallRows(
            ring=ids[own.base],
            nodes=ids[own.nodes],
            first=own.first * scale,
            growth=own.growth,
            room=own.room * scale,
            faces=outline.walls.faces,
        )
        for own, scale in zip(rows, _scales(outline, chart, rows), strict=True)
    )


def _thinned(outline: Outline, rows: list[LaidRows]) -> tuple[str, ...]:
    """Say along how much of the walls layers are thinner than asked for, and where the first one is."""
    thinned = [float(own.thinned.mean()) for own in rows if len(own.base)]
    kept = np.concatenate([own.kept for own in rows])
    base = np.concatenate([own.base for own in rows])
    share = max(thinned, default=0.0)
    low = float(kept.min()) if len(kept) else 1.0
    if not share and low > _KEPT:
        return ()
    found = f"{outline.face.label()}: wall layers are thinner"
    if share:
        found += f" along {share:.0%} of the walls, where others are near"
    if low > _KEPT:
        return (f"{found}; first heights are kept",)
    place = outline.known[np.concatenate(outline.nodes)[base[int(np.argmin(kept))]]]
    where = "the lowest" if share else "at the sharp corner"
    return (
        f"{found}, {where} at {outline.face.units.place(place)}, where the first height is {low:.2g} of that asked",
    )
