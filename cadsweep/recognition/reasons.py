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
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from ..errors import NotSweepableError
from ..sweep import Sweep
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


def what_to_do(solid: Solid, face: int) -> str:
    """What a user can do about a face in the way."""
    there = solid.faces[face]
    if there.kind in ("sphere", "cone") or min(len(loop.edges) for loop in there.loops) < 4:
        return (
            "leave the feature that it belongs to out of the model, or end the part before it: hexahedra would "
            "collapse there"
        )
    folds = [e for e in there.edges if solid.edges[e].dihedral > pi + TANGENT]
    planes = [
        solid.faces[f].known for e in folds for f in solid.edges[e].faces
        if solid.faces[f].kind == "plane" and solid.faces[f].known >= 0 and not _only_touches(solid, f)
    ]  # fmt: skip
    cut = f"cut the part there yourself (cuts=['face {planes[0]}'])" if planes else "cut the part beside it yourself"
    return f"leave the feature that it belongs to out of the model, or {cut}"


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


def headline(solid: Solid, reasons: Sequence[Reason]) -> str:
    """One line that says that and why the solid cannot be swept."""
    name = f"'{solid.name}'" if solid.name else "the solid"
    axis = find_axis(solid)
    if axis is not None and not _on_axis(solid, *axis):
        point = solid.units.place(axis[0])
        direction = ", ".join(f"{round(x, 9) + 0.0:.4g}" for x in axis[1])
        return (
            f"{name} is a closed ring, turned about the axis through ({point}) along ({direction}), and has no caps; "
            "cut it into two solids by a plane through the axis, or turn it by less than 360 degrees"
        )
    planes = {face.id: face.kind == "plane" for face in solid.faces}
    telling = max(reasons, key=lambda r: (r.weight, planes[r.face], solid.faces[r.face].area))
    n = len(reasons)
    lead = advice(solid, reasons) or f"{name} is no sweep"
    return f"{lead}; no pair of its {n} faces can be the caps, for one, {telling.text}"


def advice(solid: Solid, reasons: Sequence[Reason]) -> str:
    """One sentence: the face that is most in the way, where it is, and what to do; empty where no single face is."""
    worst = in_the_way(solid, reasons)
    if not worst:
        return ""
    name = f"'{solid.name}'" if solid.name else "the solid"
    return f"{name} is no sweep because of {solid.faces[worst[0]].label()}; {what_to_do(solid, worst[0])}"


def _on_axis(solid: Solid, point: FloatArray, direction: FloatArray) -> bool:
    """Whether a solid of revolution reaches its axis: by a vertex, or by a disc around the axis."""
    away = solid.vertices - point
    distance = np.linalg.norm(away - np.outer(away @ direction, direction), axis=1)
    discs = (
        face.kind == "plane" and len(face.loops) == 1 and abs(face.normal @ direction) > 1.0 - 1e-9
        for face in solid.faces
    )
    return bool(np.min(distance) < 1e-6 * solid.size) or any(discs)


def describe(solid: Solid, result: Sequence[Sweep] | NotSweepableError) -> dict[str, list[dict[str, Any]]]:
    """Return the tables of ``cadsweep info``.

    Parameters
    ----------
    solid : Solid
    result : sequence of Sweep, or NotSweepableError
        What :func:`cadsweep.recognition.find_sweeps` returned or raised.

    Returns
    -------
    dict
        ``faces``: id, name, groups (its other names), color, type, area, center, role (``source``, ``target``,
        ``linking side``, or ``-``) in the best sweep. ``sweeps``: source, target, n_linking_sides, n_stations, length,
        score, notes. ``rejected``: face, reason.
    """
    from .find import search_sweeps

    sweeps = [] if isinstance(result, NotSweepableError) else list(result)
    roles: dict[int, str] = {}
    for sweep in sweeps[:1]:
        roles |= dict.fromkeys(sweep.source, "source") | dict.fromkeys(sweep.target, "target")
        roles |= {side.face: "linking side" for side in sweep.linking_sides}
    faces = [
        {
            "id": face.id,
            "name": face.name or "",
            "groups": list(face.groups),
            "color": face.color,
            "type": face.kind,
            "area": face.area,
            "center": tuple(float(c) for c in face.center),
            "role": roles.get(face.id, "-"),
        }
        for face in solid.faces
    ]
    rows = [
        {
            "source": list(sweep.source),
            "target": list(sweep.target),
            "n_linking_sides": len(sweep.linking_sides),
            "n_stations": len(sweep.stations),
            "length": max(sum(lengths) for lengths in sweep.span_lengths),
            "score": sweep.score,
            "notes": list(sweep.notes),
        }
        for sweep in sweeps
    ]
    caps = {f for sweep in sweeps for f in sweep.source + sweep.target}
    found = search_sweeps(solid)
    rejected = [
        {"face": reason.face, "reason": reason.text}
        for reason in explain(solid, found.search, found.failures)
        if reason.face not in caps
    ]
    return {"faces": faces, "sweeps": rows, "rejected": rejected}
