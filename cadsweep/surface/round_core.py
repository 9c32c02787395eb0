r"""Rings of quads around a rectangular core, for caps whose outline has no corners.

Place in the flow: one of the ways of :mod:`.filling`.

Method: a core of p x q quads has 2 (p + q) nodes around, as many as the outline; what is symmetric in the outline is
symmetric inside::

      o---o---o
     / \  |  / \
    o---o-o-o---o
    |   o-o-o   |
    o---o-o-o---o
     \ /  |  \ /
      o---o---o

Not handled: holes in outlines without corners, and outlines on which quads should grow towards the inside.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..polygons import signed_area
from .chart import Chart
from .embedding import embedded
from .lattice import every_cell, quads_of, rectangle
from .outline import SMOOTH, Outline

_LEAST_AROUND = 6
"""Nodes around a core of 1 x 2 quads; fewer leave no choice."""
_RINGS = 0.45
"""Part of the half width that the rings take: core and rings then have quads of one size, as good as it gets."""
_SYMMETRIC = 1e-9
"""Distance, in sizes of the outline, up to which a core's corner lies where a mirror carries another one."""


def find_round_core(outline: Outline) -> tuple[Chart, int, IntArray] | None:
    """Rings around a rectangular core, on a face whose outline has no corners; None where it has some, or holes.

    As :func:`find_lattice`.
    """
    if len(outline.loops) != 1 or outline.grows():
        return None
    n = len(outline.nodes[0])
    if any(abs(angle - np.pi) > SMOOTH for angle in outline.angles(outline.loops[0])) or n % 2 or n < _LEAST_AROUND:
        return None
    chart = next(outline.charts(outline.nodes), None)
    if chart is None:
        return None
    rim = chart.boundary[0]
    # A dome's rim is farther from its middle than it looks from above.
    return chart, *_rings_in(rim, 1.0 if chart.isometric else outline.face.area / signed_area(rim))


def core_of_polygon(rim: FloatArray) -> tuple[FloatArray, IntArray] | None:
    """Rings around a core in a polygon (n, 2), as inner nodes (m, 2) and quads; None where no core has its nodes."""
    n = len(rim)
    if n % 2 or n < _LEAST_AROUND:
        return None
    n_inner, quads = _rings_in(rim, 1.0)
    return embedded(rim, n_inner, quads)[n:], quads


def _rings_in(rim: FloatArray, stretch: float) -> tuple[int, IntArray]:
    """As :func:`_around_core`, in an outline (n, 2) that is `stretch` times as far from its middle as it looks."""
    n = len(rim)
    first, p = core_corners(rim)
    segment = float(np.mean(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1)))
    half = min(2.0 * signed_area(rim) / (n * segment), float(np.ptp(_turned(rim), axis=0).min()) / 2.0)
    return _around_core(n, first, p, max(1, round(_RINGS * stretch * half / segment)))


def _turned(rim: FloatArray) -> FloatArray:
    """The outline (n, 2) about its centre, along its principal axes; along its first node where these are none."""
    centred = rim - rim.mean(axis=0)
    values, axes = np.linalg.eigh(centred.T @ centred)
    if values[0] > 0.95 * values[1]:
        x = centred[0] / np.linalg.norm(centred[0])
        turned = np.array([x, [-x[1], x[0]]])
        half = np.sqrt(0.5)
        axes = (np.array([[half, half], [-half, half]]) @ turned).T  # the first node is a corner of the core
    return centred @ axes


def core_corners(rim: FloatArray) -> tuple[int, int]:
    """Node over the core's first corner, and segments up to the second: where the outline reaches farthest aslant.

    Or a node beside, where the corners are then as symmetric as the outline.
    """
    n, places = len(rim), _turned(rim)
    x, y = places.T
    if signed_area(places) < 0:
        y = -y  # the axes are a reflection
    corners = sorted(int(np.argmax(a * x + b * y)) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
    sides = np.diff([*corners, corners[0] + n])
    p = int(np.clip(round(float(sides[0] + sides[2]) / 2.0), 1, n // 2 - 1))
    beside = [(corners[0] + a, p + b) for a in (0, 1, -1) for b in (0, 1, -1) if 1 <= p + b < n // 2]
    first, p = max(beside, key=lambda tried: _mirrored(places[(tried[0] + _corners_after(n, tried[1])) % n], places))
    return first % n, p


def _corners_after(n: int, p: int) -> IntArray:
    """The corners of a core of p quads on two of its sides, from the first one on, with n nodes around."""
    return np.array([0, p, n // 2, n // 2 + p])


def _mirrored(corners: FloatArray, places: FloatArray) -> int:
    """How many of the two axes mirror the corners (4, 2) of a core."""
    near = _SYMMETRIC * float(np.ptp(places, axis=0).max())
    return sum(
        np.abs(corners * axis - corners[order]).max() < near
        for axis, order in (((-1, 1), [1, 0, 3, 2]), ((1, -1), [3, 2, 1, 0]))
    )


def _around_core(n: int, first: int, p: int, rings: int) -> tuple[int, IntArray]:
    """Number of inner nodes, and quads, of rings around a core of p x (n / 2 - p) quads; the rim's n nodes first."""
    ring = np.arange((rings + 1) * n, dtype=np.int64).reshape(rings + 1, n)
    after = np.roll(ring, -1, axis=1)
    around = np.stack([ring[:-1], after[:-1], after[1:], ring[1:]], axis=-1).reshape(-1, 4)
    core = rectangle(n, first, p)
    n_core = core.size - n
    number = np.concatenate([ring[-1], (rings + 1) * n + np.arange(n_core)])
    inside = quads_of(number[core], every_cell(core))
    return rings * n + n_core, np.concatenate([around, inside])
