"""A mesh's boundary against the CAD model: volume, areas, Euler characteristic, nodes on their faces.

Place in the flow: called by :func:`cadsweep.quality.check.check_surface`.

A mesh of flat-sided cells is not the CAD solid: a circle of n chords has an area smaller by a
fraction (2 pi / n)**2 / 6. How much a volume or an area may deviate is therefore judged from the
mesh's own turning angles: a chord of length l across a turn t lies l t / 8 off its arc. Where they cannot explain
a deviation, the distance of the facets from the CAD faces is measured (:mod:`cadsweep.quality.sag`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ..topology import FloatArray, IntArray
from . import surface_kernels
from .report import CadReference
from .sag import measure_slack

LARGEST_TURN = np.pi / 3
"""A turn beyond this between neighbouring quads or segments is a corner of the part, not a curve."""

LEAST_RELATIVE = 1e-6
SAFETY = 4.0

MOST_PROJECTED = 10_000
"""Boundary nodes that are projected to their CAD faces; of more, evenly spread ones (a B-spline takes 30 us a node)."""


def cad_problems(
    points: FloatArray,
    boundaries: Mapping[str, IntArray],
    areas: Mapping[str, float],
    *,
    euler: int | None,
    volume: float | None,
    size: float,
    cad: CadReference,
    notes: list[str],
) -> list[str]:
    """Say where a mesh deviates from its CAD model by more than its facets explain.

    Parameters
    ----------
    points : (n, 3) float64
    boundaries : mapping of name to (q, 4) int64
    areas : mapping of name to float
        Areas of the mesh.
    euler, volume : of the mesh, None where unknown
    size : float
        Diagonal of the mesh's bounding box.
    cad : CadReference
    notes : list of str
        Gets what is worth knowing and not wrong.
    """
    problems = []
    if cad.euler is not None and euler is not None and euler != cad.euler:
        problems.append(f"the boundary's Euler characteristic is {euler}, the CAD solid's {cad.euler}")
    slack = {name: _slack(points, quads) for name, quads in boundaries.items()}
    odd = _odd_figures(areas, volume, slack, cad)
    if odd and cad.distance is not None and cad.relative is None:
        # Angles say nothing where a curved face is one facet wide; the face itself does.
        measured = measure_slack(points, boundaries, cad.distance)
        slack = {name: (max(slack[name][0], m[0]), max(slack[name][1], m[1])) for name, m in measured.items()}
        odd = _odd_figures(areas, volume, slack, cad)
    problems += odd
    if cad.distance is not None:
        problems += _distance_problems(points, boundaries, cad.distance, cad.tolerance * size, notes)
    return problems


def _distance_problems(
    points: FloatArray,
    boundaries: Mapping[str, IntArray],
    distance: Callable[[FloatArray, str], FloatArray],
    tolerance: float,
    notes: list[str],
) -> list[str]:
    """Boundaries with nodes off their faces; a node on an edge belongs to two boundaries and is asked for twice."""
    problems = []
    nodes_of = {name: np.unique(quads) for name, quads in boundaries.items()}
    total = sum(len(nodes) for nodes in nodes_of.values())
    step = -(-total // MOST_PROJECTED) if total else 1
    if step > 1:
        notes.append(f"one in {step} of the {total} boundary nodes was held against its CAD face")
    for name, all_nodes in nodes_of.items():
        nodes = all_nodes[::step]
        far = np.abs(distance(points[nodes], name))
        off = ~(far <= tolerance)
        if np.any(off):
            worst = int(np.argmax(np.where(np.isfinite(far), far, np.inf)))
            place = ", ".join(f"{c:.5g}" for c in points[nodes[worst]])
            problems.append(
                f"{np.count_nonzero(off)} nodes of '{name}' are off their CAD face, "
                f"the farthest is node {nodes[worst]} at ({place}), by {far[worst]:.3g}"
            )
    return problems


def _odd_figures(
    areas: Mapping[str, float], volume: float | None, slack: Mapping[str, tuple[float, float]], cad: CadReference
) -> list[str]:
    """Volume and areas that differ from the CAD model's by more than the slack allows."""
    problems = []
    if cad.volume is not None and volume is not None:
        allowed = _allowed(cad, cad.volume, sum(s[0] for s in slack.values()), known=bool(slack))
        if not abs(volume - cad.volume) <= allowed:
            problems.append(
                f"the volume is {volume:.8g}, the CAD solid's {cad.volume:.8g}: "
                f"more apart than its facets explain ({allowed:.2g})"
            )
    for names, area in [*(((name,), area) for name, area in cad.areas.items()), *cad.joint_areas.items()]:
        missing = [name for name in names if name not in areas]
        if missing:
            problems.append(f"the mesh has no boundary '{missing[0]}', which the CAD model has")
            continue
        allowed = _allowed(cad, area, sum(slack[name][1] for name in names), known=True)
        found = sum(areas[name] for name in names)
        called = " and ".join(f"'{name}'" for name in names)
        if not abs(found - area) <= allowed:
            problems.append(
                f"the area of {called} is {found:.8g}, the CAD face's {area:.8g}: "
                f"more apart than its facets explain ({allowed:.2g})"
            )
    return problems


def _allowed(cad: CadReference, value: float, slack: float, *, known: bool) -> float:
    if cad.relative is not None:
        return cad.relative * abs(value)
    if not known:  # no named boundary, so nothing to judge facets by
        return 0.5 * abs(value)
    return max(LEAST_RELATIVE * abs(value), SAFETY * slack)


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
