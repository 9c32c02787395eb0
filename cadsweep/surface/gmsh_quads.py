"""gmsh as a mesher of polygons: quads in the plane on boundary nodes that stay as they are.

Place in the flow: the only module of the surface stage that meets gmsh. ``quads`` calls it with a
chart's outline.

Method: each loop becomes a discrete curve that already carries its segments, or many of them one; gmsh meshes the
plane surface between them. Its all-quad algorithm works on every second boundary node and then
subdivides, so a whole loop as one curve needs no more than an even count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import scipy

from ..arrays import BoolArray, FloatArray, IntArray, distinct
from ..errors import SurfaceMeshError
from ..gmsh_session import gmsh_session
from ..polygons import signed_area
from ..trial import survives
from .background import Background, typical_length
from .crossings import loops_cross
from .mend import mend_flat_corners
from .triangles import remove_triangles

_TRIANGLE, _QUAD = 2, 3
_CORNERS = {_QUAD: 4, _TRIANGLE: 3}
_BLOSSOMS, _FULL_QUADS = 1, 3
"""gmsh's numbers for recombination by Blossom's matching, and by whole quads only."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A way for gmsh to make quads.

    Attributes
    ----------
    algorithm, recombination : int
        gmsh's ``Mesh.Algorithm`` and ``Mesh.RecombinationAlgorithm``.
    even_loops : bool
        Whether every loop must have an even number of segments.
    good_enough : float
        Worst corner sine, relaxed, from which on no later setting is tried.
    size_factor : float
        Below 1: size of the quads inside, in what is wanted there; without a background, their greatest size in
        typical segments of the boundary (:func:`.background.typical_length`).
    """

    algorithm: int
    recombination: int
    even_loops: bool
    good_enough: float
    size_factor: float = 1.0

    @property
    def is_matching(self) -> bool:
        """Whether triangles are joined by Blossom's matching, which takes seconds where they are many."""
        return self.recombination == _BLOSSOMS


_SUBDIVISION = Setting(algorithm=8, recombination=3, even_loops=True, good_enough=0.5)
_BLOSSOM = Setting(algorithm=6, recombination=1, even_loops=False, good_enough=0.4)
_OTHERS = (
    Setting(algorithm=6, recombination=3, even_loops=True, good_enough=0.4),
    Setting(algorithm=8, recombination=1, even_loops=False, good_enough=0.3),
    Setting(algorithm=5, recombination=1, even_loops=False, good_enough=0.3),
    Setting(algorithm=6, recombination=1, even_loops=False, good_enough=0.3, size_factor=0.6),
    Setting(algorithm=8, recombination=1, even_loops=False, good_enough=0.3, size_factor=0.4),
)
_SMALL_LOOP = 16
"""Nodes of a loop below which it is so coarse that all settings are worth a try."""
_MANY_ODD_CORNERS = 4
"""Corners at odd places beyond which subdivision cuts them off."""
_ROUNDING = 1e-9
"""Radians by which two directions that are one may differ."""
_APART = 0.05
"""How far loops that touch are drawn apart for gmsh, in segments."""
MANY = 250
"""Boundary nodes from which on triangles of algorithm 6 are subdivided first: in a third of Blossom's time a third as
many nodes inside are irregular (6 to 8 %, Blossom's 24 to 29)."""
_LARGE = 1000
"""Boundary nodes from which on Blossom takes seconds."""
_MANY_LOOPS = 20
"""Loops from which on they are one curve: 256 holes take two thirds of the time, and the quads are the same."""
_HUGE = 5000
"""Boundary nodes from which on Blossom takes minutes: 22 s and more than 90 for 12,540, where subdividing takes 5."""
_RUNS_OUT = np.cos(np.radians(2.0))
"""Cosine of the angle between two segments from which on gmsh may end its process: seen at 0.2 degrees."""
_FAIR_WHERE_HUGE = 0.2
"""Worst corner sine of subdivided triangles that is not worth Blossom's minutes to better."""


def settings_for(loops: Sequence[FloatArray]) -> tuple[Setting, ...]:
    """Settings in the order in which they are worth trying.

    Full quads by subdivision are several times faster than Blossom on a large cap, but rough where
    an outline has features as small as its segments: a corner at an odd place is cut off first.
    """
    n_odd = 0
    for loop in loops:
        n_odd += int((corner_cosines(loop)[1::2] > np.cos(np.radians(150))).sum())
    fine = min(len(loop) for loop in loops) >= _SMALL_LOOP and n_odd <= _MANY_ODD_CORNERS
    n_nodes = sum(len(loop) for loop in loops)
    if n_nodes > _LARGE:
        # Triangles of algorithm 6 take a tenth longer than those of 8, but their quads are not folded where many small
        # holes make the sizes change, so that one mesh is enough.
        fair = _FAIR_WHERE_HUGE if n_nodes > _HUGE else 0.3
        quick = (replace(_OTHERS[0], good_enough=0.3), replace(_SUBDIVISION, good_enough=fair))
        return (*quick, _BLOSSOM, _OTHERS[1])
    if n_nodes > MANY and n_odd <= _MANY_ODD_CORNERS:
        return (replace(_OTHERS[0], good_enough=_SUBDIVISION.good_enough), _SUBDIVISION, _BLOSSOM, *_OTHERS[1:])
    return (_SUBDIVISION, _BLOSSOM, *_OTHERS) if fine else (_BLOSSOM, _SUBDIVISION, *_OTHERS)


def mesh_polygon(
    loops: Sequence[FloatArray],
    setting: Setting,
    opposite: FloatArray | None = None,
    background: Background | None = None,
) -> tuple[FloatArray, IntArray]:
    """Mesh a polygon with holes with quads alone.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise.
    setting : Setting
    opposite : (b,) float64, optional
        Angles of the boundary nodes on the cap that the quads are swept to, NaN where they are as here.
    background : Background, optional
        Wanted lengths inside; without it they are those of the boundary, interpolated.

    Returns
    -------
    inner : (n, 2) float64
        Nodes inside.
    quads : (q, 4) int64
        Counter-clockwise; ids count the loops' nodes first, then `inner`.

    Raises
    ------
    SurfaceMeshError
        The boundary crosses itself, a triangle is left that cannot be removed, a boundary node is lost, or gmsh
        failed.
    """
    own, (loops, order) = loops, parted(loops)
    if setting.even_loops and any(len(loop) % 2 for loop in loops):
        raise SurfaceMeshError("a boundary loop has an odd number of segments")
    # gmsh works without end between boundaries that cross; to subdivide it first takes every second node. Of a boundary
    # that is inside out it fills what lies outside.
    if max((signed_area(loop) for loop in own), key=abs) <= 0 or loops_cross(loops):
        raise SurfaceMeshError("the boundary of the cap crosses itself at this size: try a smaller one")
    if setting.recombination == _FULL_QUADS and loops_cross([loop[::2] for loop in loops]):
        raise SurfaceMeshError("the boundary is too coarse to be halved")
    boundary = np.concatenate(loops)
    origin = boundary.min(axis=0)
    scale = float(np.max(np.ptp(boundary, axis=0)))
    options: dict[str, float] = {
        "Mesh.Algorithm": setting.algorithm,
        "Mesh.RecombinationAlgorithm": setting.recombination,
        "Mesh.RecombineAll": 1,
        "Mesh.Renumber": 0,
        "Mesh.MeshSizeExtendFromBoundary": background is None,
        "Mesh.MeshSizeFromPoints": background is None,
        "Mesh.RandomSeed": 1,
    }
    if setting.size_factor < 1 and background is not None:
        background = replace(background, sizes=setting.size_factor * background.sizes)
    elif setting.size_factor < 1:
        options["Mesh.MeshSizeMax"] = setting.size_factor * typical_length(loops) / scale
    with gmsh_session("cap", options) as gmsh:
        surface = _add_polygon(gmsh, [(loop - origin) / scale + _tie_breaker(len(loop)) for loop in loops])
        if background is not None:
            _set_background(gmsh, background, origin, scale)
        _generate(gmsh, loops)
        inner, quads = _read_quads(gmsh, surface, len(boundary))
    quads = np.concatenate([order, len(order) + np.arange(len(inner))])[quads]
    return mend_flat_corners(own, inner * scale + origin, quads, opposite)


def _generate(gmsh: Any, loops: Sequence[FloatArray]) -> None:
    """Let gmsh mesh the polygon of its model.

    Raises
    ------
    SurfaceMeshError
        It does not come to its end between loops that run together.
    """
    sharp = np.concatenate([corner_cosines(loop) for loop in loops]).max() > _RUNS_OUT
    if sharp and not survives(lambda: gmsh.model.mesh.generate(2), "making quads", library="gmsh"):
        raise SurfaceMeshError("gmsh fails where the cap runs out to nothing between two edges")
    gmsh.model.mesh.generate(2)


def corner_cosines(loop: FloatArray) -> FloatArray:
    """Cosines (m,) of the angles at the nodes of a loop (m, 2), on either side."""
    after, before = np.roll(loop, -1, axis=0) - loop, np.roll(loop, 1, axis=0) - loop
    cosines: FloatArray = (after * before).sum(axis=1) / (
        np.linalg.norm(after, axis=1) * np.linalg.norm(before, axis=1)
    )
    return cosines


def parted(loops: Sequence[FloatArray]) -> tuple[list[FloatArray], IntArray]:
    """Loops that touch themselves or each other in a node, as cells do that meet in a point, drawn apart there.

    Every visit of such a node gets one sector of the polygon, whatever loop it is in, and is moved a little into it.

    Returns
    -------
    loops : list of (m, 2) float64
        Outer loop first; the given ones where none touch.
    order : (b,) int64
        Which node of the given loops, counted through, each of theirs is.
    """
    places = np.concatenate(loops)
    _, node, uses = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    node = node.ravel()
    twice = uses[node] > 1
    if not twice.any():
        return list(loops), np.arange(len(places))
    firsts = np.cumsum([0, *(len(loop) for loop in loops)])
    after = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in pairwise(firsts)])
    before = np.concatenate([np.roll(np.arange(a, b), 1) for a, b in pairwise(firsts)])
    following = after.copy()
    for one in np.unique(node[twice]):
        visits = np.flatnonzero(node == one)
        ahead, back = places[after[visits]] - places[visits], places[before[visits]] - places[visits]
        # The inside lies between where a way goes on and, counter-clockwise from there, where it came from.
        turn = np.arctan2(back[:, 1], back[:, 0])[:, None] - np.arctan2(ahead[:, 1], ahead[:, 0])
        # The least of all together: where loops touch along a tangent, the nearest one by one would be twice the same.
        # No turn is a full one by rounding.
        rows, columns = scipy.optimize.linear_sum_assignment((turn + _ROUNDING) % (2.0 * np.pi))
        following[visits[rows]] = after[visits[columns]]
    found: list[IntArray] = []
    left = set(range(len(places)))
    while left:
        way = [min(left)]
        while (step := int(following[way[-1]])) != way[0]:
            way.append(step)
        left.difference_update(way)
        found.append(np.array(way, dtype=np.int64))
    found.sort(key=lambda way: -float(np.ptp(places[way], axis=0).sum()))
    return [_drawn_in(places[way], twice[way]) for way in found], np.concatenate(found)


def _drawn_in(loop: FloatArray, which: BoolArray) -> FloatArray:
    """Some nodes of a loop moved into the polygon on its left."""
    after, back = np.roll(loop, -1, axis=0) - loop, np.roll(loop, 1, axis=0) - loop
    lengths = np.linalg.norm(after, axis=1), np.linalg.norm(back, axis=1)
    angles = np.arctan2(after[:, 1], after[:, 0])
    half = (np.arctan2(back[:, 1], back[:, 0]) - angles) % (2.0 * np.pi) / 2.0
    inward = np.stack([np.cos(angles + half), np.sin(angles + half)], axis=1)
    return np.where(which[:, None], loop + _APART * np.minimum(*lengths)[:, None] * inward, loop)


def triangulate(loops: Sequence[FloatArray], background: Background) -> tuple[FloatArray, IntArray]:
    """Triangles (t, 3), counter-clockwise, of a polygon with holes, and the nodes (n, 2) inside; see `mesh_polygon`.

    Raises
    ------
    SurfaceMeshError
        The boundary crosses itself, or gmsh failed.
    """
    if loops_cross(loops):
        raise SurfaceMeshError("the boundary of the cap crosses itself at this size: try a smaller one")
    boundary = np.concatenate(loops)
    origin, scale = boundary.min(axis=0), float(np.max(np.ptp(boundary, axis=0)))
    options = {
        "Mesh.Algorithm": 6,
        "Mesh.Renumber": 0,
        "Mesh.MeshSizeExtendFromBoundary": 0,
        "Mesh.MeshSizeFromPoints": 0,
        "Mesh.RandomSeed": 1,
    }
    with gmsh_session("cap", options) as gmsh:
        surface = _add_polygon(gmsh, [(loop - origin) / scale + _tie_breaker(len(loop)) for loop in loops])
        _set_background(gmsh, background, origin, scale)
        _generate(gmsh, loops)
        points, inner, cells = _read_cells(gmsh, surface, len(boundary))
    triangles = _counter_clockwise(points, cells[_TRIANGLE])
    return inner * scale + origin, np.ascontiguousarray(triangles)


def _tie_breaker(n: int) -> FloatArray:
    """Offsets (n, 2) of a billionth of the cap, always the same, that gmsh's nodes of the boundary are moved by.

    On a symmetric outline gmsh's algorithm 8 has equal triangles to choose from and takes the one that lies
    first in memory, so its quads change from run to run. Only gmsh sees the offsets: our boundary nodes stay.
    """
    return 1e-9 * np.random.default_rng(n).standard_normal((n, 2))


def _add_polygon(gmsh: Any, loops: Sequence[FloatArray]) -> int:
    """A plane surface between loops, each one discrete curve, many of them one curve together.

    For every node of the boundary gmsh goes through all curves, often.
    """
    tag = 1
    curve_loops = []
    for together in [loops] if len(loops) >= _MANY_LOOPS else [[loop] for loop in loops]:
        n = sum(map(len, together))
        tags = np.arange(tag, tag + n)
        following = np.concatenate([np.roll(own, -1) for own in np.split(tags, np.cumsum([*map(len, together)])[:-1])])
        xyz = np.column_stack([np.concatenate(together), np.zeros(n)])
        point = gmsh.model.addDiscreteEntity(0)
        gmsh.model.setCoordinates(point, *xyz[0])
        curve = gmsh.model.addDiscreteEntity(1, -1, [point, point])
        gmsh.model.mesh.addNodes(0, point, tags[:1], xyz[0])
        gmsh.model.mesh.addNodes(1, curve, tags[1:], xyz[1:].ravel())
        gmsh.model.mesh.addElementsByType(point, 15, [], tags[:1])
        gmsh.model.mesh.addElementsByType(curve, 1, [], np.column_stack([tags, following]).ravel())
        curve_loops.append(gmsh.model.geo.addCurveLoop([curve]))
        tag += n
    surface = gmsh.model.geo.addPlaneSurface(curve_loops)
    gmsh.model.geo.synchronize()
    return int(surface)


def _set_background(gmsh: Any, background: Background, origin: FloatArray, scale: float) -> None:
    """Have gmsh interpolate the wanted lengths; the view goes with the session's model."""
    corners = ((background.places - origin) / scale)[background.triangles]
    sizes = background.sizes[background.triangles] / scale
    rows = np.concatenate([corners[:, :, 0], corners[:, :, 1], np.zeros_like(sizes), sizes], axis=1)
    view = gmsh.view.add("sizes")
    gmsh.view.addListData(view, "ST", len(rows), rows.ravel())
    field = gmsh.model.mesh.field.add("PostView")
    gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
    gmsh.model.mesh.field.setAsBackgroundMesh(field)


def _read_cells(gmsh: Any, surface: int, n_boundary: int) -> tuple[FloatArray, FloatArray, dict[int, IntArray]]:
    """All nodes, boundary first, those inside, and the quads and triangles."""
    types, _, nodes = gmsh.model.mesh.getElements(2, surface)
    found = {int(t): np.asarray(n, dtype=np.int64) for t, n in zip(types, nodes, strict=True)}
    cells = {kind: found.get(kind, np.empty(0, dtype=np.int64)).reshape(-1, n) for kind, n in _CORNERS.items()}
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    tags = np.asarray(tags, dtype=np.int64)
    xy = np.empty((int(np.max(tags)) + 1, 2))
    xy[tags] = np.asarray(xyz).reshape(-1, 3)[:, :2]
    used = distinct(np.concatenate([c.ravel() for c in cells.values()]))
    inner = used[used > n_boundary]
    if len(used) - len(inner) != n_boundary:
        raise SurfaceMeshError(f"gmsh lost {n_boundary - (len(used) - len(inner))} boundary nodes")
    number = np.full(len(xy), -1, dtype=np.int64)
    number[1 : n_boundary + 1] = np.arange(n_boundary)
    number[inner] = n_boundary + np.arange(len(inner))
    points = xy[np.concatenate([np.arange(1, n_boundary + 1), inner])]
    return points, xy[inner], {kind: number[c] for kind, c in cells.items()}


def _read_quads(gmsh: Any, surface: int, n_boundary: int) -> tuple[FloatArray, IntArray]:
    points, inner, cells = _read_cells(gmsh, surface, n_boundary)
    quads, triangles = (_counter_clockwise(points, cells[kind]) for kind in (_QUAD, _TRIANGLE))
    if len(triangles):
        without = remove_triangles(points, quads, triangles)
        if without is None:
            raise SurfaceMeshError(f"gmsh left {len(triangles)} triangles")
        quads = without
    _check_border(quads, n_boundary)
    return inner, np.ascontiguousarray(quads)


def _counter_clockwise(points: FloatArray, cells: IntArray) -> IntArray:
    """All cells turned over where their areas add up to less than nothing."""
    x, y = points[cells, 0], points[cells, 1]
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum()
    return cells[:, ::-1] if area < 0 else cells


def _check_border(quads: IntArray, n_boundary: int) -> None:
    """Every border edge of the quads joins boundary nodes: no boundary segment was divided."""
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    keys, uses = np.unique(ends[:, 0] * (np.max(quads) + 1) + ends[:, 1], return_counts=True)
    border = keys[uses == 1] % (np.max(quads) + 1)
    if (uses > 2).any() or len(border) != n_boundary or (border >= n_boundary).any():
        raise SurfaceMeshError("gmsh changed the boundary of the cap")
