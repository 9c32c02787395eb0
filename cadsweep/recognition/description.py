"""What ``cadsweep info`` says of a solid: its faces, its sweeps, and why the other faces are no caps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..brep import Solid
from ..errors import NotSweepableError
from ..sweep import Sweep
from .find import search_sweeps
from .reasons import explain


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
