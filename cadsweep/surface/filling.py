"""The ways to fill a face of a cap with quads, and the choice among them.

Place in the flow: ``quads`` asks for each face of the source cap.

Method: a table of ways, the cheapest and most regular first. Each gives quads, or none where it does not apply;
the first that is good enough ends the search, else the best of all is taken. A four-sided face with equal
opposite counts is filled transfinitely; right corners give a lattice and a smooth outline rings around a core
(``structured``, ``round_core``); along smooth rims a row of quads is laid first; around one hole our own
strips and rings are tried (``annulus``); any face is mapped to a plane (``charts``), meshed there by gmsh
(``gmsh_quads``) with settings from the cheapest on, and brought back. A new way is one function and one row.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from .. import rows
from ..arrays import FloatArray, IntArray
from ..brep import Face
from ..errors import SurfaceMeshError
from ..polygons import signed_area
from .annulus import THIN, fill_wall, wall_thickness
from .background import typical_length
from .chart import Chart
from .disc_lattice import fill_disc
from .fan import fan_of
from .gmsh_quads import Setting, mesh_polygon, settings_for
from .outline import CORNER, STRAIGHT, FaceQuads, Outline
from .rim import lay_rows
from .ring_lattice import fill_ring, with_mirrors
from .round_core import find_round_core
from .structured import find_lattice
from .symmetric import fill_symmetric
from .tips import SHARP, lay_tips
from .transfinite import GOOD_ENOUGH, fill
from .wall_filling import lay_rows_along_walls


def fill_grid(outline: Outline) -> FaceQuads | None:
    """A transfinite grid on a face of four sides; None where it has not four, or opposite counts differ."""
    sides = outline.four_sides()
    if sides is None:
        return None
    a, b, c, d = sides
    chains = (a, b, [(e, not f) for e, f in reversed(c)], [(e, not f) for e, f in reversed(d)])
    bottom, right, top, left = (outline.chain_nodes(chain) for chain in chains)
    south, east, north, west = (outline.chain_uv(chain) for chain in chains)
    rim = (outline.known[bottom], outline.known[right], outline.known[top], outline.known[left])
    points, _, worst = fill(outline.face.surface, (south, east, north, west), rim, side=-1.0)
    h, w = points.shape[0] - 1, points.shape[1] - 1
    ids = np.empty((h + 1, w + 1), dtype=np.int64)
    ids[1:-1, 1:-1] = len(outline.known) + np.arange((h - 1) * (w - 1)).reshape(h - 1, w - 1)
    ids[0], ids[:, -1], ids[-1], ids[:, 0] = bottom, right, top, left
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    return outline.judged(points[1:-1, 1:-1].reshape(-1, 3), quads, worst)


def fill_lattice(outline: Outline) -> FaceQuads | None:
    """A lattice on a face whose corners are all right or re-entrant; None where it is no such face."""
    found = find_lattice(outline)
    return None if found is None else with_mirrors(outline, *found, even=not found[0].isometric)


def fill_round_core(outline: Outline) -> FaceQuads | None:
    """Rings around a core, on a face without corners or holes; None on others."""
    found = find_round_core(outline)
    return None if found is None else with_mirrors(outline, *found, even=not found[0].isometric)


def fill_fan(outline: Outline) -> FaceQuads | None:
    """Grids that meet in the middle of a flat face of three, five or six corners; None where its counts forbid it."""
    if len(outline.loops) != 1 or outline.grows():
        return None
    loop = outline.loops[0]
    angles = outline.angles(loop)
    corners = [j for j, angle in enumerate(angles) if CORNER[0] < angle < CORNER[1]]
    straight = [j for j, angle in enumerate(angles) if STRAIGHT[0] <= angle <= STRAIGHT[1]]
    if len(corners) + len(straight) != len(angles):
        return None
    firsts = np.concatenate([[0], np.cumsum([int(outline.counts[e]) for e, _ in loop])])
    found = fan_of(int(firsts[-1]), [int(firsts[j]) for j in corners])
    chart = None if found is None else next(outline.charts(outline.nodes), None)
    if found is None or chart is None or not chart.isometric:
        return None  # on a steep face the counts of its sides say nothing of its middle
    return with_mirrors(outline, chart, *found, even=True)


def lay_rows_along_rims(outline: Outline) -> FaceQuads | None:
    """A row of quads along smooth rims, the rest by gmsh; None where no rim is smooth, or no row fits."""
    if not any(outline.smooth):
        return None
    best: FaceQuads | None = None
    for chart in outline.charts(outline.nodes):
        rows = lay_rows(chart.boundary, list(outline.smooth), partial(_normals_at, outline.face, chart))
        if rows is None:
            continue
        for inner, quads, setting in _with_rest(outline, chart, *rows):
            made = outline.lift(chart, inner, quads, np.concatenate(outline.nodes), n_rows=len(rows[0]))
            if best is None or made.worst > best.worst:
                best = made
            if best.worst >= setting.good_enough and best.excess <= 1.0:
                return best
    return best


def _with_rest(
    outline: Outline, chart: Chart, inner: FloatArray, quads: IntArray, left: Sequence[IntArray]
) -> Iterator[tuple[FloatArray, IntArray, Setting]]:
    """Quads along a chart's boundary with what they leave filled by gmsh, for each of its settings that does it."""
    places = np.concatenate([*chart.boundary, inner])
    remaining = [places[loop] for loop in left]
    given = outline.sizes is not None or chart.conformal
    rest = replace(chart, boundary=tuple(remaining))
    background = outline.background(rest, outline.nodes) if given else None
    for setting in settings_for(remaining):
        try:
            more, others = mesh_polygon(remaining, setting, None, background)
        except SurfaceMeshError:
            continue  # the next setting, or another way
        number = np.concatenate([*left, len(places) + np.arange(len(more), dtype=np.int64)])
        yield np.concatenate([inner, more]), np.concatenate([quads, number[others]]), setting


def fill_around_hole(outline: Outline) -> FaceQuads | None:
    """Strips or rings around the only hole of a face; None where there is not one, or they do not go.

    They go where few quads lie across the wall, or where both loops have as many segments.
    """
    if len(outline.loops) != 2:
        return None
    outer, hole = outline.nodes
    for chart in outline.charts(outline.nodes):
        if wall_thickness(chart.boundary) >= THIN and len(outer) != len(hole):
            return None
        boundary = np.concatenate(outline.nodes)
        filled = fill_wall(chart.boundary, outline.opposite_of(boundary))
        return None if filled is None else outline.lift(chart, *filled, boundary)
    return None


def lay_sharp_tips(outline: Outline) -> FaceQuads | None:
    """Quads in the sharp corners, the rest by gmsh; None where no corner is sharp, or none fits."""
    if sharpest_corner(outline) >= SHARP:
        return None
    best: FaceQuads | None = None
    for chart in outline.charts(outline.nodes):
        tips = lay_tips(chart.boundary)
        if tips is None:
            continue
        for inner, quads, setting in _with_rest(outline, chart, *tips):
            made = outline.lift(chart, inner, quads, np.concatenate(outline.nodes))
            if best is None or made.better_than(best):
                best = made
            if best.enough(min(setting.good_enough, _enough_at_tips(outline))):
                return best
    return best


def sharpest_corner(outline: Outline) -> float:
    """Least interior angle of a face's corners, radians."""
    return min((angle for loop in outline.loops for angle in outline.angles(loop)), default=np.pi)


def _enough_at_tips(outline: Outline) -> float:
    """What the sharpest corner allows, or nearly so; half a right angle's sine elsewhere."""
    return min(GOOD_ENOUGH, 0.9 * float(np.sin(min(sharpest_corner(outline), np.pi / 2))))


def mesh_freely(outline: Outline) -> FaceQuads:
    """Mesh a face with gmsh in a chart: the best of several settings by the worst quad.

    Raises
    ------
    SurfaceMeshError
        The outline has an odd number of segments, or gmsh makes no quads in any chart.
    """
    face = outline.face
    for loop in outline.nodes:
        if len(loop) % 2 and len(outline.nodes) == 1:
            raise SurfaceMeshError(f"{face.label()} has {len(loop)} boundary segments; quads alone need an even number")
    nodes = [_start_at_corner(outline, j) for j in range(len(outline.loops))]
    boundary = np.concatenate(nodes)
    # A sharp corner between two edges is one quad's corner whatever the mesher does.
    limit = min((np.sin(a) for loop in outline.loops for a in outline.angles(loop) if a < np.pi / 2), default=1.0)
    least = _FAIR if len(boundary) < _MANY else 0.0
    reasons: list[str] = []
    best: FaceQuads | None = None
    for chart in outline.charts(nodes):
        background = outline.background(chart, nodes)
        for setting in settings_for(chart.boundary):
            if (
                setting.size_factor < 1
                and best is not None
                and (best.expected >= least or (background is None and _too_fine(chart, setting)))
            ):
                break  # many more quads are no way to make fair ones good, nor to mend one place of a large face
            try:
                inner, quads = mesh_polygon(chart.boundary, setting, outline.opposite_of(boundary), background)
            except SurfaceMeshError as error:
                reasons.append(error.message)
                continue
            made = outline.lift(chart, inner, quads, boundary)
            if best is None or made.better_than(best):
                best = made
            if best.enough(min(setting.good_enough, 0.95 * limit)):
                return best
        if best is not None and best.expected >= _FAIR:
            return best
    if best is None:
        why = (
            "; ".join(list(dict.fromkeys(reasons))[:3])
            or "its outline overlaps itself in every plane view; split the face"
        )
        raise SurfaceMeshError(f"{face.label()} could not be meshed with quads alone: {why}", edges=face.edges)
    return best


def _too_fine(chart: Chart, setting: Setting) -> bool:
    """Whether a setting makes many times the quads that the outline asks for: most of its segments are very short."""
    size = setting.size_factor * typical_length(chart.boundary)
    area = sum(signed_area(loop) for loop in chart.boundary)
    return area > _MOST_FINER * size**2 * chart.n_interpolated


def must_grow(outline: Outline) -> bool:
    """Whether quads as fine as the outline, which mirrors would be made of, are many times those that grow inside."""
    chart = next(outline.charts(outline.nodes), None)
    background = None if chart is None else outline.background(chart, outline.nodes)
    if chart is None or background is None:
        return False
    return chart.n_interpolated > _MOST_FINER * background.count_quads(chart.boundary)


def mesh_with_mirrors(outline: Outline) -> FaceQuads:
    """Quads with the mirrors of the outline, unless a mesher's of the whole are clearly better.

    Raises
    ------
    SurfaceMeshError
        As :func:`mesh_freely`, where there are no mirrors.
    """
    made = None if must_grow(outline) else fill_symmetric(outline)
    if made is not None and made.expected >= _SYMMETRIC:
        return made
    try:
        free = mesh_freely(outline)
    except SurfaceMeshError:
        if made is None:
            raise
        return made
    return made if made is not None and made.worst > 0 and made.expected >= free.expected - _LOST else free


_FAIR = GOOD_ENOUGH / 2
"""Worst corner sine from which on no chart is tried but the first, nor quads much smaller than the outline's."""
_MANY = 400
"""Nodes of an outline from which on quads much smaller than it take seconds, where one narrow place is poor."""
_MOST_FINER = 20.0
"""Quads, as a multiple of those that the outline asks for, beyond which smaller ones are not tried; 6 are usual."""
_SYMMETRIC = 0.6
"""Worst corner sine from which on symmetric quads are as good as those that a mesher makes of the whole."""
_LOST = 0.02
"""Worst corner sine that symmetry may cost."""
_REGULAR = 0.07
"""Worst corner sine that a regular mesh may cost: the best free one of a ring has 0.69, where circles and rays have
0.62 with fewer than half as many quads."""


@dataclass(frozen=True)
class Filling:
    """A way to fill a face, by name, and the worst corner sine from which on no further way is asked.

    What a later way makes must be better by `worth` in the worst corner sine to take its place.
    """

    row: str
    fill: Callable[[Outline], FaceQuads | None]
    enough: Callable[[Outline], float]
    worth: float = 0.0


FILLINGS = (
    # A grid is what a person would draw, but for a smooth rim: its quads are flat at four nodes of a circle.
    Filling("cap: grid", fill_grid, lambda outline: np.inf if any(outline.smooth) else GOOD_ENOUGH),
    # Below 0.4 the rows have been squeezed, and quads without them often do better.
    Filling("cap: rows along rims", lay_rows_along_rims, lambda _: 0.4),
    # Where every corner is right or re-entrant, and where there is none, these are what a person would draw.
    # What gmsh makes is seldom better than 0.7, and a regular mesh is worth a little.
    Filling("cap: lattice", fill_lattice, lambda _: 0.65, _REGULAR),
    Filling("cap: round core", fill_round_core, lambda _: 0.7, _REGULAR),
    Filling("cap: fan", fill_fan, lambda _: 0.65, _REGULAR),
    Filling("cap: ring", fill_ring, lambda _: 0.65, _REGULAR),
    Filling("cap: disc", fill_disc, lambda _: 0.65, _REGULAR),
    # Strips of 0.7 are as good as gmsh's in the mean, and cost nothing.
    Filling("cap: around a thin hole", fill_around_hole, lambda _: 0.7),
    # In a sharp corner gmsh leaves a folded quad, or one much worse than the corner.
    Filling("cap: sharp tips", lay_sharp_tips, _enough_at_tips),
    Filling("cap: gmsh, with mirrors", mesh_with_mirrors, lambda _: GOOD_ENOUGH),
)


def best_quads(outline: Outline) -> FaceQuads:
    """The first quads of `FILLINGS` that are good enough, else the best of all.

    Raises
    ------
    SurfaceMeshError
        No way gives quads; it tells why the last that was tried gave none.
    """
    if outline.walls is not None:
        return lay_rows_along_walls(outline)
    best: FaceQuads | None = None
    worth, row = 0.0, ""
    failure: SurfaceMeshError | None = None
    for filling in FILLINGS:
        if not rows.is_on(filling.row):
            continue
        try:
            made = filling.fill(outline)
        except SurfaceMeshError as error:
            failure = error
            continue
        if made is None:
            continue
        if best is None or made.better_than(replace(best, expected=best.expected + worth)):
            best, worth, row = made, filling.worth, filling.row
        if made.enough(filling.enough(outline)):
            break
    if best is None:
        raise failure or SurfaceMeshError(
            f"no way to fill {outline.face.label()} with quads was tried",
            try_="switch a row of the table 'cap' on again",
        )
    rows.took([row])
    return best


def _normals_at(face: Face, chart: Chart, places: FloatArray) -> FloatArray:
    return face.surface.normals(chart.lift(places)[1])


def _start_at_corner(outline: Outline, loop: int) -> IntArray:
    """Turn a loop's nodes so that as many sharp corners as possible stand at even places.

    gmsh's all-quad algorithm works on every second boundary node first, counted from the beginning.
    """
    edges, ids = outline.loops[loop], outline.nodes[loop]
    sharpness = np.abs(np.pi - np.array(outline.angles(edges)))
    places = np.concatenate([[0], np.cumsum([int(outline.counts[e]) for e, _ in edges])])[:-1]
    even = sharpness[places % 2 == 0].sum()
    return ids if even >= sharpness[places % 2 == 1].sum() else np.roll(ids, -1)
