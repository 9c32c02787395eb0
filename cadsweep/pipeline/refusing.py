"""Where a mesh runs into itself: is it the model that does, or only the facets that stand for it?

Place in the flow: called where the checks of a mesh found boundary quads that cross. The two quads of a pair are
replaced by ever finer facets with their nodes on the CAD faces. Facets lie off a curved face by their length squared:
what still crosses between facets a sixteenth as long crosses between the faces themselves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.naming import NamedFaces
from ..brep import Face, Part
from ..errors import CadError, CadSweepError, InvertedHexError
from ..quality import BoundaryCrossing, QualityReport, find_crossings, scaled_jacobians

FINENESS = 16
"""Facets a direction that a quad is divided into."""

MARGIN = FINENESS // 4
"""Facets along the rim of a quad that prove nothing."""

POOR_CARRIED = 0.2
"""Worst scaled Jacobian of a carried mesh that few solvers take without a complaint."""

MUCH_WORSE = 0.5
"""Part of the worst scaled Jacobian there that a carried mesh keeps in any case, if it can."""

MOST_PAIRS = 32
"""Pairs of quads of two boundaries that are looked at."""


def explain_crossings(
    part: Part, names: NamedFaces, crossings: tuple[BoundaryCrossing, ...], worst: float = float("nan")
) -> CadSweepError:
    """Say whether the model or the mesh runs into itself, which boundaries and where."""
    for crossing in crossings:
        found = _crossing_faces(part, names, crossing)
        if found is not None:
            one, other = found
            crossing_each = "crosses itself" if one is other else f"and {other.label()} cross each other"
            who = f"{one.label()} {crossing_each}"
            named = " and ".join(f"'{name}'" for name in dict.fromkeys(crossing.names))
            where = ", ".join(f"{c:.5g}" for c in crossing.place)
            return CadError(
                "the model runs into itself, so that no mesh of it is valid",
                where=f"({where}), where the mesh has {named}: {who}",
                try_="repair it in its CAD program",
            )
    said = [str(crossing) for crossing in crossings]
    error = InvertedHexError(
        "no valid mesh: it runs into itself where the model's own faces keep apart, by less than facets lie off them",
        where=said[0],
        try_="a smaller size or more layers, or leave a wider gap in the model",
        reasons=said,
        hexes=[],
        min_scaled_jacobian=worst,
    )
    error.crossing = _places(crossings)
    return error


def _places(crossings: Sequence[BoundaryCrossing]) -> tuple[tuple[float, float, float], ...]:
    """Corners of the quads that cross."""
    corners = np.concatenate([crossing.corners.reshape(-1, 3) for crossing in crossings])
    return tuple((x, y, z) for x, y, z in corners.tolist())


def refusal(report: QualityReport, part: Part | None = None, names: NamedFaces | None = None) -> CadSweepError:
    """Say what is wrong with a mesh that is not handed over."""
    if report.crossings and not report.n_inverted and part is not None and names is not None:
        return explain_crossings(part, names, report.crossings, report.min_scaled_jacobian)
    error = InvertedHexError(
        f"no valid mesh: {report.problems[0] if report.problems else 'its hexahedra are inverted'}",
        reasons=report.problems,
        hexes=[hexahedron.id for hexahedron in report.worst],
        min_scaled_jacobian=report.min_scaled_jacobian,
    )
    if report.crossings and not report.n_inverted:
        error.crossing = _places(report.crossings)
    return error


def poor_carried(points: FloatArray, hexes: IntArray) -> float:
    """Worst scaled Jacobian below which a mesh that is carried from there is smoothed, valid or not.

    What is only a little worse stays as it is carried: a smooth function of the part.
    """
    return min(POOR_CARRIED, MUCH_WORSE * float(scaled_jacobians(points, hexes).min()))


def carried_refusal(report: QualityReport, name: str) -> InvertedHexError:
    """Say why a part cannot have the mesh of another."""
    return InvertedHexError(
        f"'{name}' cannot have the same mesh: carried here it is not valid",
        where=report.problems[0] if report.problems else "",
        try_="mesh it by itself, or start from a part that is nearer to it",
        reasons=report.problems,
        hexes=[hexahedron.id for hexahedron in report.worst],
        min_scaled_jacobian=report.min_scaled_jacobian,
    )


def _crossing_faces(part: Part, named: NamedFaces, crossing: BoundaryCrossing) -> tuple[Face, Face] | None:
    """The CAD faces that cross where two boundaries do; None where only their facets do."""
    by_name = named.by_name()
    faces = {
        name: [part.solids[c].faces[f] for c, f in dict.fromkeys((c, f) for c, f, _ in by_name.get(name, ()))]
        for name in crossing.names
    }
    if not all(faces.values()):
        return None
    step = max(1, len(crossing.corners) // MOST_PAIRS)
    for pair in crossing.corners[::step]:
        places = (pair - part.offset) / part.scale
        if not _are_apart(places):
            continue
        for first, second in {crossing.names, crossing.names[::-1]}:
            one, other = _nearest(faces[first], places[0]), _nearest(faces[second], places[1])
            if one is other and _is_folded(one, places):
                continue
            nodes = np.concatenate([_nodes(one, places[0]), _nodes(other, places[1])])
            pairs, _ = find_crossings(nodes, np.concatenate([_FACETS, _FACETS + len(nodes) // 2]))
            if np.any((pairs[:, 0] < len(_FACETS)) & (pairs[:, 1] >= len(_FACETS))):
                return one, other
    return None


def _are_apart(pair: FloatArray) -> bool:
    """Whether two quads (2, 4, 3) have no corner in common: facets of neighbours meet in their common edge."""
    return not np.any(np.all(pair[0][:, None] == pair[1][None], axis=-1))


def _nearest(faces: list[Face], corners: FloatArray) -> Face:
    """The face that the corners (4, 3) of a quad lie on."""
    return min(faces, key=lambda face: float(np.max(face.surface.distance(corners))))


def _is_folded(face: Face, pair: FloatArray) -> bool:
    """Whether two quads (2, 4, 3) lie over each other on a face, which is the mesh's doing and not the face's."""
    uv = _of_one_branch(face, pair.reshape(-1, 3))
    if uv.shape[1] > 2:
        return True  # of several faces that are one: there it is not told apart
    one, other = uv[:4], uv[4:]
    return bool(((one.min(axis=0) < other.max(axis=0)) & (other.min(axis=0) < one.max(axis=0))).all())


def _of_one_branch(face: Face, points: FloatArray) -> FloatArray:
    """Parameters of points on a face, all in the branch of the first."""
    uv = np.array(face.surface.project(points))
    for axis, period in enumerate(face.surface.periods):
        if period is not None:
            uv[:, axis] -= period * np.round((uv[:, axis] - uv[0, axis]) / period)
    return uv


def _nodes(face: Face, corners: FloatArray) -> FloatArray:
    """Nodes (n, 3) of the facets of the part of a face's surface between four points (4, 3) on it, but for its rim.

    Beside a curved edge of its face, facets reach beyond the face: those along the rim prove nothing.
    """
    uv = _of_one_branch(face, corners)
    t = np.arange(MARGIN, FINENESS - MARGIN + 1) / FINENESS
    s, r = t[:, None, None], t[None, :, None]
    # Of faces that are one surface together parameters are of one face, and in a branch of it: places are interpolated.
    is_one = uv.shape[1] == 2
    a, b, c, d = uv if is_one else corners
    between = (1 - s) * (1 - r) * a + (1 - s) * r * b + s * r * c + s * (1 - r) * d
    between = between.reshape(-1, between.shape[-1])
    return face.surface.evaluate(between if is_one else face.surface.project(between))


def _grid(n: int) -> IntArray:
    """Quads (n * n, 4) of a grid of nodes, row by row; neighbours share theirs, so that they do not seem to cross."""
    nodes = np.arange((n + 1) ** 2, dtype=np.int64).reshape(n + 1, n + 1)
    return np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]], axis=-1).reshape(-1, 4)


_FACETS = _grid(FINENESS - 2 * MARGIN)
