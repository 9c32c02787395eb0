"""Why a face is not the cap of a sweep, in one line a face; and the tables of ``cadsweep info``.

Place in the flow: beside :mod:`.find`. Every face is looked at as a source: its neighbours must be
rectangles, the edges that leave it must reach another cap, and the bands around all its loops must
agree on one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..errors import NotSweepableError
from ..topology import Solid, Sweep
from .bands import Band, BandSearch
from .corners import why_no_rectangle
from .revolution import find_axis


def explain(solid: Solid, search: BandSearch, failures: Sequence[tuple[Sequence[Band], str]]) -> list[tuple[int, str]]:
    """Return, for every face, why it is no source: ``(face id, one line)``."""
    failed: dict[int, str] = {}
    for bands, why in failures:
        for f in bands[0].faces:
            failed.setdefault(f, why)
    return [(face.id, f"{face.label()}: {_why(solid, face.id, search, failed)}") for face in solid.faces]


def _why(solid: Solid, source: int, search: BandSearch, failed: dict[int, str]) -> str:
    face = solid.faces[source]
    neighbours = [(e, solid.edges[e].faces[solid.edges[e].faces[0] == source]) for e in face.edges]
    for _, g in neighbours:
        if not search.readings[g]:
            return f"cannot be a cap, its neighbour {solid.faces[g].label()} {why_no_rectangle(solid.faces[g])}"
    for e, g in neighbours:
        reading = search.readings[g][0]
        k = next(k for k, chain in enumerate(reading.chains) if e in chain)
        rail = reading.chains[(k + 1) % 4][0]
        if rail in search.reasons and len(search.readings[g]) == 1:
            return f"cannot be a cap, the sweep from it along {solid.faces[g].label()} ends: {search.reasons[rail]}"
    for _, g in neighbours:
        if g in failed:
            return f"is no cap: {failed[g]}"
    return "is no cap: its neighbours are sides of no common sweep"


def headline(solid: Solid, reasons: Sequence[tuple[int, str]]) -> str:
    """One line that says that and why the solid cannot be swept."""
    name = f"'{solid.name}'" if solid.name else "the solid"
    axis = find_axis(solid)
    if axis is not None:
        (x, y, z), (a, b, c) = axis
        return (
            f"{name} is a solid of revolution about the axis through ({x:.4g}, {y:.4g}, {z:.4g}) along "
            f"({a:.3g}, {b:.3g}, {c:.3g}) and has no pair of caps; cut it by a plane through the axis into two "
            "solids, or revolve less than 360 degrees"
        )
    telling = max(reasons, key=lambda r: solid.faces[r[0]].area)[1]
    return (
        f"no pair of faces makes {name} a sweep, {len(reasons)} were tried; {telling}; "
        "cut it into solids that are extrusions, or see 'cadsweep info' for every face"
    )


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
        ``faces``: id, name, type, area, center, role (``source``, ``target``, ``linking side``, or
        ``-``) in the best sweep. ``sweeps``: source, target, n_linking_sides, n_stations, length,
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
        {"face": f, "reason": text}
        for f, text in explain(solid, found.search, found.failures)
        if f not in caps and roles.get(f) is None
    ]
    return {"faces": faces, "sweeps": rows, "rejected": rejected}
