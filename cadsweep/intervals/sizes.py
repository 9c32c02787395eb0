"""Wanted sizes and counts: from the user's wishes, or from the part's volume and features.

Place in the flow: first step of :mod:`cadsweep.intervals`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import cos, hypot, pi, sqrt

import numpy as np

from ..arrays import FloatArray
from ..brep import Edge, Solid
from ..sweep import Sweep
from .patterns import counts_of, symmetric_counts

WANTED_HEXES = 8_000
"""Hexes of a plain part where the user names no size."""
MOST_HEXES = 60_000
"""Hexes up to which small features may refine a part where the user names no size."""
LONGEST = 5.0
"""Thickness of a layer over the size, where the user names none and the part is long beside its walls."""
SEGMENTS_AROUND = 8
"""Segments around a hole by default: an octagon is the least that looks round."""
SEGMENTS_ACROSS = 2
"""Segments through the thinnest wall by default: one alone cannot show bending."""
TURN_DEFAULT = pi / 12
"""Greatest turn of a curved edge over one segment, where the user names no size."""
TURN_SIZED = pi / 4
"""Greatest turn of an edge over one segment where the user names a size: eight segments around a circle."""
TURN_LAYER = 0.13
"""Greatest turn of the sweep over one layer, where the user names no size: chords lose 0.3 % of a bend's volume."""
LOST_AREA = 0.004
"""Part of the source cap that the chords of its curved edges may lose, where the user names no size."""
Split = tuple[tuple[int, ...], Callable[[float], FloatArray]]
"""Edges one after another, and ``shares(n)``: the parts (len(edges),) of their n segments that each should get."""
SAMPLES = 65
"""Places along an edge for its turn: finer than any count that the turn could ask for."""
WINDING = 1.3
"""Length over chords above which an edge winds too much to be judged by its middle."""


def split_counts(wanted: dict[int, float], splits: Iterable[Split]) -> dict[int, float]:
    """Wanted counts of edges that are graded together: what they want in all, in the shares that the grading gives."""
    found: dict[int, float] = {}
    for edges, shares in splits:
        if all(e in wanted for e in edges):
            total = sum(wanted[e] for e in edges)
            found |= {e: max(1.0, total * float(s)) for e, s in zip(edges, shares(total), strict=True)}
    return found


def path_length(sweep: Sweep) -> float:
    """Mean length of the way from source to target along the outer loop."""
    return float(sum(sweep.span_lengths[0]))


def default_size(sweep: Sweep) -> float:
    """Return a target edge length from the part itself.

    The size gives about `WANTED_HEXES` hexes with two layers at least, then shrinks for holes and
    walls of the source cap while the hexes stay below `MOST_HEXES`.
    """
    solid = sweep.solid
    area = sum(solid.faces[f].area for f in sweep.source)
    length = path_length(sweep)
    perimeters = [sum(solid.edges[e].length for e, _ in loop) for loop in sweep.source_loops]
    wall = 2.0 * area / sum(perimeters)
    wanted = size_for(area, length, WANTED_HEXES)
    feature = min(wall / SEGMENTS_ACROSS, *(p / SEGMENTS_AROUND for p in perimeters))
    return max(min(wanted, feature), size_for(area, length, MOST_HEXES))


def default_layers(sweep: Sweep, size: float) -> float:
    """Wanted layers (a real number, at least 2) of a part whose size nobody named.

    Layers are as thick as the size, and up to `LONGEST` times that where the hexes would be more than `MOST_HEXES`.
    """
    length = path_length(sweep)
    area = sum(sweep.solid.faces[f].area for f in sweep.source)
    outline = sum(sweep.solid.edges[e].length for loop in sweep.source_loops for e, _ in loop)
    # A wall thinner than the size has two rows of quads between its sides, if it can be.
    n_quads = max(area / size**2, outline / size)
    cubes = length / size
    return max(2.0, min(cubes, max(MOST_HEXES / n_quads, cubes / LONGEST)))


def size_for(area: float, length: float, n_hexes: float) -> float:
    """Size of cubes that fill area times length with `n_hexes`, two layers at least."""
    cube = (area * length / n_hexes) ** (1.0 / 3.0)
    return cube if length >= 2.0 * cube else sqrt(2.0 * area / n_hexes)


def turnings(solid: Solid, edges: Iterable[int]) -> dict[int, float]:
    """Angles by which the directions of edges turn from their starts to their ends, radians.

    Seen on the tangents at the ends and the chords over the middle, which all edges have at hand; an
    edge that is much longer than its chords (a helix) is sampled.
    """
    found = dict.fromkeys(edges, 0.0)
    bent = [solid.edges[e] for e in found if solid.edges[e].kind != "line"]
    if not bent:
        return found
    begin, end = (solid.vertices[[ends[k] for ends in ((e.start, e.end) for e in bent)]] for k in (0, 1))
    middles = np.array([edge.midpoint for edge in bent])
    tangents = np.array([edge.tangents for edge in bent])
    directions = np.stack([tangents[:, 0], middles - begin, end - middles, tangents[:, 1]], axis=1)
    lengths = np.linalg.norm(directions, axis=2)
    whole = np.array([edge.length for edge in bent])
    units = directions / np.maximum(lengths, 1e-300)[..., None]
    angles = np.arccos(np.clip((units[:, 1:] * units[:, :-1]).sum(axis=2), -1.0, 1.0)).sum(axis=1)
    odd = (whole > WINDING * lengths[:, 1:3].sum(axis=1)) | (lengths <= 1e-12 * whole[:, None]).any(axis=1)
    for edge, angle, is_odd in zip(bent, angles.tolist(), odd.tolist(), strict=True):
        found[edge.id] = _turning_of_odd(solid, edge) if is_odd else angle
    return found


def turning(solid: Solid, edge: Edge) -> float:
    """The angle of :func:`turnings` of one edge."""
    return turnings(solid, [edge.id])[edge.id]


def _turning_of_odd(solid: Solid, edge: Edge) -> float:
    """The same of one that winds, or of which a direction is nought."""
    vertices = solid.vertices
    chords = np.array([edge.midpoint - vertices[edge.start], vertices[edge.end] - edge.midpoint])
    if edge.length > WINDING * np.linalg.norm(chords, axis=1).sum():
        chords = np.diff(edge.curve.evaluate(np.linspace(0.0, 1.0, SAMPLES)), axis=0)
    directions = np.vstack([edge.tangents[0], chords, edge.tangents[1]])
    lengths = np.linalg.norm(directions, axis=1)
    directions = directions[lengths > 1e-12 * edge.length] / lengths[lengths > 1e-12 * edge.length, None]
    cosines = np.clip((directions[1:] * directions[:-1]).sum(axis=1), -1.0, 1.0)
    return float(np.arccos(cosines).sum())


def turns_back(sweep: Sweep, edge: Edge) -> bool:
    """Whether an edge turns by about half a circle and not much more, so that it ends in the direction it came from."""
    if edge.kind == "line":
        return False
    first, last = edge.tangents.tolist()
    along = sum(a * b for a, b in zip(first, last, strict=True))
    return along < -cos(pi / 6) * hypot(*first) * hypot(*last) and turning(sweep.solid, edge) < 1.5 * pi


def greatest_turn(sweep: Sweep) -> float:
    """Greatest turn of the way from source to target: over all spans, the most any of their rails turns."""
    turns = turnings(sweep.solid, (e for loop in sweep.spans for span in loop for e in span))
    return max(sum(max(turns[e] for e in span) for span in loop) for loop in sweep.spans)


def wanted_counts(
    sweep: Sweep, edges: Sequence[int], size: float, edge_sizes: dict[int, float], *, sized: bool
) -> dict[int, float]:
    """Return the wanted number of segments (a real number, at least 1) of edges along the loops.

    Parameters
    ----------
    size : float
        Target edge length; `edge_sizes` has that of single edges.
    sized : bool
        The user named `size`; otherwise curved edges are also divided finely enough for the volume.
    """
    turns = turnings(sweep.solid, edges)
    limit = TURN_SIZED if sized else TURN_DEFAULT
    wanted = {e: max(1.0, sweep.solid.edges[e].length / size, turns[e] / limit) for e in edges}
    if not sized:
        # a chord under an arc of length l that turns by t cuts off an area of l^2 t / 12
        rim = [e for loop in sweep.source_loops for e, _ in loop]
        lost = sum(sweep.solid.edges[e].length ** 2 * turns[e] / (12.0 * wanted[e] ** 2) for e in rim)
        finer = sqrt(lost / (LOST_AREA * sum(sweep.solid.faces[f].area for f in sweep.source)))
        if finer > 1.0:
            wanted = {e: n * finer if turns[e] > limit else n for e, n in wanted.items()}
    wanted |= counts_of(symmetric_counts(sweep, wanted))
    return wanted | {e: max(1.0, sweep.solid.edges[e].length / edge_sizes[e]) for e in edges if e in edge_sizes}
