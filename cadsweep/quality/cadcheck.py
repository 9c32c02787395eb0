"""A mesh's boundary against the CAD model: volume, areas, Euler characteristic, nodes on their faces.

Place in the flow: called by :func:`cadsweep.quality.check.check_surface`.

A mesh of flat-sided cells is not the CAD solid: a circle of n chords has an area smaller by a
fraction (2 pi / n)**2 / 6. How much a volume or an area may deviate is therefore judged from the
mesh's own turning angles: a chord of length l across a turn t lies l t / 8 off its arc. Where they cannot explain
a deviation, the distance of the facets from the CAD faces is measured (:mod:`cadsweep.quality.sag`). Where the model's
faces miss each other, its own figures are uncertain by as much as the gaps explain, and that is allowed besides.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cache, partial

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from . import surface_kernels
from .boundary import boundary_blocks
from .conformity import row_keys
from .metrics import quad_areas
from .report import CadReference
from .sag import measure_slack

LARGEST_TURN = np.pi / 3
"""A turn beyond this between neighbouring quads or segments is a corner of the part, not a curve."""

LEAST_RELATIVE = 1e-6
"""Differences of volume and area below this are rounding and the CAD kernel's own integrals."""
SAFETY = 4.0
"""Times what facets are estimated to explain: the estimate is of leading order."""


def cad_problems(
    points: FloatArray,
    boundaries: Mapping[str, IntArray],
    areas: Mapping[str, float],
    *,
    euler: int | None,
    volume: Callable[[], float] | None,
    size: float,
    cad: CadReference,
    numbers: IntArray | None = None,
) -> list[str]:
    """Say where a mesh deviates from its CAD model by more than its facets explain.

    Parameters
    ----------
    points : (n, 3) float64
    boundaries : mapping of name to (q, 4), (q, 8) or (q, 9) int64
        Middle nodes are held against faces and edges as corners are; areas and volume are those of the corners.
    areas : mapping of name to float
        Areas of the mesh.
    euler : of the mesh, None where unknown
    volume : callable or None
        Says the mesh's; asked last, since it may have to be waited for.
    size : float
        Diagonal of the mesh's bounding box.
    cad : CadReference
    numbers : (n,) int64 or None
        What messages call the points; None: by their places in `points`.
    """
    number = np.arange(len(points)) if numbers is None else numbers
    problems = []
    if cad.euler is not None and euler is not None and euler != cad.euler:
        problems.append(f"the boundary's Euler characteristic is {euler}, the CAD solid's {cad.euler}")
    whole = {name: np.asarray(quads) for name, quads in boundaries.items()}
    boundaries = {name: quads[:, :4] for name, quads in whole.items()}
    if len({quads.shape[1] for quads in whole.values()}) > 1:
        whole = dict(boundaries)
    whole_blocks = boundary_blocks(whole, len(points))
    plain = {(name,) for name, quads in whole.items() if whole_blocks.get((name,)) is quads}
    blocks = {names: quads[:, :4] for names, quads in whole_blocks.items()}
    overlaps = {(one, other) for names in blocks for one in names for other in names if one != other}
    found: dict[tuple[str, ...], float] = {(name,): area for name, area in areas.items()}
    if cad.joint_areas:
        block_areas = {names: float(np.sum(quad_areas(points, quads))) for names, quads in blocks.items()}
        found |= {
            joint: sum(area for names, area in block_areas.items() if set(names) & set(joint))
            for joint in cad.joint_areas
        }
    off = []
    nodes = {name: distinct(quads) for name, quads in whole.items()}
    if cad.distance is not None:
        off += _face_problems(points, number, nodes, cad.distance, cad.tolerance * size)
    if cad.rim_distance is not None:
        at_blocks = {own: nodes[own[0]] if own in plain else distinct(quads) for own, quads in whole_blocks.items()}
        off += _rim_problems(points, number, at_blocks, cad.rim_distance, cad.tolerance * size)
    present = None if volume is None else volume()

    @cache
    def slack(name: str) -> tuple[float, float]:
        return _slack(points, boundaries[name])

    @cache
    def block_slack(names: tuple[str, ...]) -> float:
        return slack(names[0])[0] if names in plain else _slack(points, blocks[names])[0]

    odd = _odd_figures(found, present, slack, boundaries, cad, lambda: sum(map(block_slack, blocks)))
    if odd and cad.distance is not None and cad.relative is None:
        # Angles say nothing where a curved face is one facet wide; the face itself does.
        measured = measure_slack(points, boundaries, cad.distance, overlaps)
        most = {name: (max(slack(name)[0], m[0]), max(slack(name)[1], m[1])) for name, m in measured.items()}
        if overlaps:
            away = cad.distance
            by_names = {" ".join(names): quads for names, quads in blocks.items()}
            measured = measure_slack(points, by_names, lambda p, names, close: away(p, names.split()[0], close))
        total = sum(max(block_slack(names), measured[" ".join(names)][0]) for names in blocks)
        odd = _odd_figures(found, present, lambda name: most[name], boundaries, cad, lambda: total)
    return [*problems, *odd, *off]


def _face_problems(
    points: FloatArray,
    number: IntArray,
    nodes_of: Mapping[str, IntArray],
    distance: Callable[[FloatArray, str, float], FloatArray],
    tolerance: float,
) -> list[str]:
    """Nodes of boundaries off their faces; a node on an edge belongs to two boundaries and is asked for twice."""
    problems = []
    for name, nodes in nodes_of.items():
        places = points[nodes]
        away = distance(places, name, tolerance)
        problems += _off(places, number[nodes], away, tolerance, f"of '{name}'", "face")
    return problems


def _rim_problems(
    points: FloatArray,
    number: IntArray,
    blocks: Mapping[tuple[str, ...], IntArray],
    distance: Callable[[FloatArray, frozenset[frozenset[str]]], FloatArray],
    tolerance: float,
) -> list[str]:
    """Nodes of two blocks, by name, off the edges, and nodes of more off the vertices, where these meet."""
    names = list(blocks)
    owned = np.zeros(len(points), dtype=np.int64)
    for nodes in blocks.values():
        owned[nodes] += 1
    used = [nodes[owned[nodes] > 1] for nodes in blocks.values()]
    nodes = np.concatenate([np.zeros(0, dtype=np.int64), *used])
    if not len(nodes):
        return []
    owners = np.repeat(np.arange(len(names)), [len(u) for u in used])
    order = np.argsort(nodes, kind="stable")  # the owners of one node stay in ascending order
    nodes, owners = nodes[order], owners[order]
    first = np.flatnonzero(np.diff(nodes, prepend=-1))
    count = np.diff(np.append(first, len(nodes)))
    # Who meets at a node, as one number: those of unlike sets are alike once in 2^64.
    tokens = row_keys(np.arange(len(names))[:, None]).view(np.uint64)
    _, example, member = np.unique(np.add.reduceat(tokens[owners], first), return_index=True, return_inverse=True)
    by_group = np.split(np.argsort(member, kind="stable"), np.cumsum(np.bincount(member))[:-1])
    groups = [owners[first[at] : first[at] + count[at]].tolist() for at in example.tolist()]
    problems = []
    for group, places in sorted(zip(groups, by_group, strict=True), key=lambda own: (len(own[0]), own[0])):
        here = nodes[first[places]]
        meeting = [names[j] for j in group]
        places_here = points[here]
        away = distance(places_here, frozenset(map(frozenset, meeting)))
        if not (away <= tolerance).all():
            where = "where " + " and ".join(f"'{', '.join(own)}'" for own in meeting) + " meet"
            what = "edge" if len(group) == 2 else "vertex"
            problems += _off(places_here, number[here], away, tolerance, where, what)
    return problems


def _off(  # noqa: PLR0917
    points: FloatArray, nodes: IntArray, distances: FloatArray, tolerance: float, where: str, what: str
) -> list[str]:
    """Say which of some nodes, with places (m, 3), are farther from their CAD entity than the tolerance."""
    off = ~(distances <= tolerance)
    if not np.any(off):
        return []
    worst = int(np.argmax(np.where(off, np.where(np.isnan(distances), np.inf, distances), -1.0)))
    place = ", ".join(f"{c:.5g}" for c in points[worst])
    return [
        f"{np.count_nonzero(off)} nodes {where} are off their CAD {what}, "
        f"the farthest is node {nodes[worst]} at ({place}), by {distances[worst]:.3g}"
    ]


def _odd_figures(  # noqa: PLR0917
    areas: Mapping[tuple[str, ...], float],
    volume: float | None,
    slack: Callable[[str], tuple[float, float]],
    boundaries: Collection[str],
    cad: CadReference,
    volume_slack: Callable[[], float],
) -> list[str]:
    """Volume and areas that differ from the CAD model's by more than the slack allows, which is asked where it counts.

    `slack` says what the facets of a boundary explain of the volume and of its area, `volume_slack` what all do.
    """
    problems = []
    if cad.volume is not None and volume is not None:

        def explained() -> float:
            return SAFETY * volume_slack() if boundaries else 0.5 * abs(cad.volume or 0.0)  # no facets to judge by

        allowed = _exceeded(cad, volume, cad.volume, cad.volume_doubt, explained)
        if allowed is not None:
            problems.append(
                f"the volume is {volume:.8g}, the CAD solid's {cad.volume:.8g}: "
                f"more apart than its facets explain ({allowed:.2g})"
            )
    for names, area in [*(((name,), area) for name, area in cad.areas.items()), *cad.joint_areas.items()]:
        present = [name for name in names if name in boundaries]
        if not present:  # of faces that the mesh knows as one, some may be smaller than a quad
            problems.append(f"the mesh has no boundary '{names[0]}', which the CAD model has")
            continue
        doubt = cad.area_doubts.get(names[0], 0.0) if len(names) == 1 else cad.joint_doubts.get(names, 0.0)
        allowed = _exceeded(cad, areas[names], area, doubt, partial(_explained_area, present, slack))
        called = " and ".join(f"'{name}'" for name in names)
        if allowed is not None:
            problems.append(
                f"the area of {called} is {areas[names]:.8g}, the CAD face's {area:.8g}: "
                f"more apart than its facets explain ({allowed:.2g})"
            )
    return problems


def _explained_area(names: Sequence[str], slack: Callable[[str], tuple[float, float]]) -> float:
    return SAFETY * sum(slack(name)[1] for name in names)


def _exceeded(
    cad: CadReference, found: float, value: float, doubt: float, explained: Callable[[], float]
) -> float | None:
    """What a figure may differ from the CAD model's value, where it differs by more; else None."""
    if cad.relative is not None:
        allowed = cad.relative * abs(value) + doubt
    else:
        allowed = LEAST_RELATIVE * abs(value) + doubt
        if not abs(found - value) <= allowed:
            allowed = max(LEAST_RELATIVE * abs(value), explained()) + doubt
    return None if abs(found - value) <= allowed else allowed


def _slack(points: FloatArray, quads: IntArray) -> tuple[float, float]:
    """How much volume and area the facets of one boundary can gain or lose."""
    if not len(quads):
        return 0.0, 0.0
    quads = np.ascontiguousarray(quads)
    mates = np.empty(4 * len(quads), dtype=np.int64)
    surface_kernels.pair_edges(quads, len(points), mates)
    volume, area = surface_kernels.facet_slack(points, quads, mates, LARGEST_TURN)
    rim = np.flatnonzero(mates == -1)
    starts, ends = quads.ravel()[rim], np.roll(quads, -1, axis=1).ravel()[rim]
    # In the face's own plane the rim bulges as well.
    return volume, area + _rim_slack(points, starts, ends, np.linalg.norm(points[ends] - points[starts], axis=1))


def _rim_slack(points: FloatArray, starts: IntArray, ends: IntArray, lengths: FloatArray) -> float:
    order = np.argsort(starts)
    at = np.minimum(np.searchsorted(starts[order], ends), len(order) - 1) if len(order) else order
    if not len(order):
        return 0.0
    follower = order[at]
    direction = (points[ends] - points[starts]) / np.where(lengths > 0, lengths, 1.0)[:, None]
    cosine = np.einsum("ij,ij->i", direction, direction[follower])
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    turn = np.where((starts[follower] == ends) & (turn < LARGEST_TURN), turn, 0.0)
    before = np.zeros_like(turn)
    before[follower] = turn
    return float(np.sum(lengths**2 * np.maximum(turn, before) / 8))
