"""Why a face is not the cap of a sweep, in one line a face; and the tables of ``cadsweep info``.

Place in the flow: beside :mod:`.find`. Every face is looked at as a source: its neighbours must be
rectangles, the edges that leave it must reach another cap, and the bands around all its loops must
agree on one.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from ..errors import NotSweepableError
from .bands import Band, BandSearch
from .corners import STRICT, why_no_rectangle
from .revolution import find_axis

TANGENT = 0.02
"""Radians from pi within which a face counts as a rounding of the corner between its neighbours."""


MOST_FACES = 8
"""Faces that a refusal names as being in the way: what can be looked at one by one."""


@dataclass(frozen=True, kw_only=True)
class Reason:
    """Why a face is no source.

    Attributes
    ----------
    face : int
    weight : int
        How far the face came: 0 for a neighbour that is no side, 2 where only the caps are wrong, 3 where only sides
        that run out to a point are.
    text : str
        One line that names the face and what rules it out.
    blamed : tuple of int
        The faces that rule it out, as far as they are single ones.
    """

    face: int
    weight: int
    text: str
    blamed: tuple[int, ...] = ()


def explain(solid: Solid, search: BandSearch, failures: Sequence[tuple[Sequence[Band], str]]) -> list[Reason]:
    """Return, for every face, why it is no source."""
    failed: dict[int, str] = {}
    for bands, why in failures:
        for f in [f for band in bands for f in band.faces]:
            failed.setdefault(f, why)
    reasons = []
    for face in solid.faces:
        weight, why, blamed = _why(solid, face.id, search, failed)
        reasons.append(Reason(face=face.id, weight=weight, text=f"{face.label()} {why}", blamed=blamed))
    return reasons


def _why(solid: Solid, source: int, search: BandSearch, failed: dict[int, str]) -> tuple[int, str, tuple[int, ...]]:
    face = solid.faces[source]
    neighbours = [(e, solid.edges[e].faces[solid.edges[e].faces[0] == source]) for e in face.edges]
    no_sides = {g for _, g in neighbours if not search.readings[g]}
    points = [solid.faces[g] for g in sorted(no_sides) if _runs_out(solid, source, g)]
    if points and len(points) == len(no_sides) < len({g for _, g in neighbours}):
        more = f", as {len(points) - 1} others do" if len(points) > 1 else ""
        why = (
            f"cannot be a cap: beside it {points[0].label()} runs out to a point on the other cap{more}, so that hexes "
            "would collapse there; round the sharp corner it comes from, or keep the corner sharp all the way"
        )
        return 3, why, tuple(point.id for point in points)
    for _, g in neighbours:
        if not search.readings[g]:
            side = solid.faces[g]
            why = f"cannot be a cap: its neighbour {side.label()} is no linking side, it {why_no_rectangle(side)}"
            return 0, why, _behind(solid, g)
    for e, g in neighbours:
        reading = search.readings[g][0]
        k = next(k for k, chain in enumerate(reading.chains) if e in chain)
        rail = reading.chains[(k + 1) % 4][0]
        if rail in search.reasons and len(search.readings[g]) == 1:
            why = f"cannot be a cap: the sweep from it along {solid.faces[g].label()} breaks, {search.reasons[rail]}"
            return 1, why, ()
    for _, g in neighbours:
        if g in failed:
            return 2, f"is no cap: {failed[g]}", ()
    return 2, "is no cap: its neighbours are sides of no common sweep", ()


def _behind(solid: Solid, side: int) -> tuple[int, ...]:
    """What makes a face no rectangle: the features in its holes; else itself."""
    rims = [e for loop in solid.faces[side].loops[1:] for e in loop.edges]
    features = {f for e in rims for f in solid.edges[e].faces} - {side}
    return tuple(sorted(features)) if features else (side,)


def in_the_way(solid: Solid, reasons: Sequence[Reason]) -> list[int]:
    """The faces that rule out most of the others, the worst first.

    A face of a feature that crosses the direction in which the rest could be swept rules out all caps beside it.
    """
    # Of equal ones, curved before plane and small before large: that is what features are.
    counts = Counter(f for reason in reasons for f in reason.blamed)
    faces = solid.faces
    return sorted(counts, key=lambda f: (-counts[f], faces[f].kind == "plane", faces[f].area, f))


def planes_beside(solid: Solid, face: int) -> list[int]:
    """Plane faces that fold away from a face and go on into the solid: what may part it there."""
    folds = [e for e in solid.faces[face].edges if solid.edges[e].dihedral > pi + TANGENT]
    return list(
        dict.fromkeys(
            f for e in folds for f in solid.edges[e].faces
            if solid.faces[f].kind == "plane" and solid.faces[f].known >= 0 and not _only_touches(solid, f)
        )
    )  # fmt: skip


def _only_touches(solid: Solid, face: int) -> bool:
    """Whether all of the solid is on one side of a plane face: its plane parts nothing."""
    plane = solid.faces[face]
    return bool(((solid.vertices - plane.center) @ plane.normal).max() < 1e-6 * solid.size)


def _runs_out(solid: Solid, source: int, side: int) -> bool:
    """Whether a neighbour of a face has one edge there and only two more, smooth ones, which meet in a point beyond."""
    face = solid.faces[side]
    if face.kind == "plane" or len(face.loops) != 1 or len(face.edges) != 3:
        return False
    loop = face.loops[0]
    beside = [k for k, e in enumerate(loop.edges) if source in solid.edges[e].faces]
    if len(beside) != 1 or loop.angles[(beside[0] + 2) % 3] > STRICT.end_high * pi / 180.0:
        return False
    return all(abs(solid.edges[e].dihedral - pi) < TANGENT for k, e in enumerate(loop.edges) if k != beside[0])


def no_sweep(solid: Solid, reasons: Sequence[Reason]) -> NotSweepableError:
    """The refusal of a solid: the face that is most in the way, and why each face is no cap."""
    name = f"'{solid.name}'" if solid.name else "the solid"
    texts = [reason.text for reason in reasons]
    worst = in_the_way(solid, reasons)
    axis = find_axis(solid)
    if axis is not None and not _on_axis(solid, *axis):
        point = solid.units.place(axis[0])
        direction = ", ".join(f"{round(x, 9) + 0.0:.4g}" for x in axis[1])
        return NotSweepableError(
            f"{name} is a closed ring and has no caps",
            where=f"the axis through ({point}) along ({direction}) that it is turned about",
            try_="cut it into two solids by a plane through the axis, or turn it by less than 360 degrees",
            reasons=texts,
            faces=worst[:MOST_FACES],
        )
    n = len(reasons)
    if worst:
        blamed = sum(worst[0] in reason.blamed for reason in reasons)
        where = f"{solid.faces[worst[0]].label()}, which rules out {blamed} of them"
    else:
        planes = {face.id: face.kind == "plane" for face in solid.faces}
        where = max(reasons, key=lambda r: (r.weight, planes[r.face], solid.faces[r.face].area)).text
    return NotSweepableError(
        f"{name} is no sweep: no pair of its {n} faces can be the caps",
        where=where,
        reasons=texts,
        faces=worst[:MOST_FACES],
    )


def _on_axis(solid: Solid, point: FloatArray, direction: FloatArray) -> bool:
    """Whether a solid of revolution reaches its axis: by a vertex, or by a disc around the axis."""
    away = solid.vertices - point
    distance = np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
    discs = (
        face.kind == "plane" and len(face.loops) == 1 and abs(face.normal @ direction) > 1.0 - 1e-9
        for face in solid.faces
    )
    return bool(np.min(distance) < 1e-6 * solid.size) or any(discs)
