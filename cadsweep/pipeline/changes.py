"""What is done to a part so that it can be swept, or swept better: cut open, divided, merged.

Place in the flow: rows of the table in :mod:`.attempts`. Every function returns the changed part with its sweeps, None
where the change does not apply or gains nothing, and raises ``NotSweepableError`` where the changed part has no sweep.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from .. import cad, recognition
from ..brep import Part
from ..errors import CadError, NotSweepableError
from ..sweep import Sweep
from .parts import only_solid, resolve_cap, search

DOUBTFUL = 0.4
"""Score of the best sweep below which one of the part with merged faces is looked for."""

MOST_DIVIDED = 3
"""Sweeps whose caps' roundings are divided to see whether a better one comes of it."""

MOST_KEPT = 4
"""Outlines of sides, and of each cap, that are tried one by one for whether the mesh can follow them."""


class Opened(NamedTuple):
    """A part, changed or as it is, and its sweeps, best first."""

    part: Part
    sweeps: list[Sweep]

    @property
    def score(self) -> float:
        """That of the best sweep."""
        return self.sweeps[0].score

    @property
    def does_well(self) -> bool:
        """Whether nothing better needs to be looked for."""
        return corresponds(self.sweeps[0]) and self.score >= DOUBTFUL


def across_walls(part: Part, source: Any, target: Any) -> Opened | None:
    """The part with plane faces around a hole divided, for a sweep across its walls; None where that gives none."""
    divided = cad.divide_annuli(part)
    return None if divided is None else Opened(divided, search(divided, source, target))


def open_ring(part: Part, source: Any, target: Any) -> Opened | None:
    """Cut a closed ring open and find its sweep, whose caps coincide; None where the part is no ring.

    Raises
    ------
    NotSweepableError
        It is one, but its rails do not close.
    """
    for ring in _cut_open(part):
        try:
            sweeps = [sweep for sweep in search(ring, source, target) if sweep.closed]
        except NotSweepableError:
            continue  # another section may do, and the part as it is has its own reasons
        gaps = [recognition.why_not_closed(sweep) for sweep in sweeps]
        closed = [sweep for sweep, gap in zip(sweeps, gaps, strict=True) if not gap]
        if closed:
            return Opened(ring, closed)
        if gaps:
            name = only_solid(part).name
            named = f"'{name}'" if name else "the solid"
            raise NotSweepableError(
                f"{named} is a closed ring whose section does not meet itself",
                where=gaps[0],
                try_="cut it into two solids and mesh each",
                reasons=gaps,
            )
    return None


def _cut_open(part: Part) -> Iterator[Part]:
    ring = cad.cut_ring(part)
    if ring is not None:
        yield ring
    elif recognition.may_be_ring(only_solid(part)):
        yield from cad.cut_closed(part)


def better_around(part: Part, sweep: Sweep) -> Opened | None:
    """A full ring cut open, where its sweep around the axis is better than the one given."""
    with suppress(CadError, NotSweepableError):  # a ring that cannot be cut open is swept as it is
        ring = cad.cut_ring(part)
        if ring is not None:
            sweeps = [around for around in search(ring, None, None) if around.closed]
            if sweeps and sweeps[0].score > sweep.score:
                return Opened(ring, sweeps)
    return None


def divide_roundings(part: Part, sweeps: list[Sweep], source: Any, target: Any) -> Opened | None:
    """The part with the roundings of a sweep's caps divided, where that promises better hexes at their edge."""
    # Faces keep their ids, so the user's choice means the same in the divided part.
    choice = resolve_cap(part, source), resolve_cap(part, target)
    worst = recognition.worst_rim(sweeps[0])
    best: Opened | None = None
    for sweep in sweeps[:MOST_DIVIDED] if recognition.find_roundings(sweeps[0]) else ():
        roundings = recognition.find_roundings(sweep)
        divided = cad.divide_roundings(part, roundings) if roundings else None
        if divided is None:
            continue
        with suppress(NotSweepableError):  # a cap that the user named may be divided now
            better = recognition.find_sweeps(only_solid(divided), source=choice[0], target=choice[1])
            grown = {plane for plane, _ in roundings}
            wanted = [found for found in better if grown <= {*found.source, *found.target}]
            better = wanted + [found for found in better if found not in wanted]
            gain = recognition.worst_rim(better[0]) / worst
            if gain <= 1.0 or better[0].score * gain <= sweeps[0].score or not corresponds(better[0]):
                continue
            if best is None or better[0].score > best.score:
                best = Opened(divided, better)
    return best


def corresponds(sweep: Sweep) -> bool:
    """Whether the mesh follows all inner edges of the target."""
    return len(sweep.target) == 1 or bool(sweep.target_faces)


def merge_and_find(part: Part, source: Any, target: Any) -> Opened | None:
    """Merge faces that divide one surface, no more of them than the sweep needs; None where that gives no sweep.

    Outlines that the mesh can follow stay: those of the sides are tried first, then those of the source
    (which the projected mesh repeats), then those of the target.
    """
    refused: list[NotSweepableError] = []
    groups = cad.find_mergeable(part)
    best = _try_merged(part, groups, source, target, refused=refused) if groups else None
    if best is None or best.score < DOUBTFUL:
        more = cad.find_mergeable(part, across_kinks=True)
        other = _try_merged(part, more, source, target, refused=refused) if more != groups else None
        if other is not None and (best is None or other.score > best.score):
            best, groups = other, more
    if best is None:
        if refused:
            raise refused[0]
        return None
    sweep = best.sweeps[0]
    solid = only_solid(part)
    keys = [{solid.faces[f].key for e in group for f in solid.edges[e].faces} for group in groups]
    caps = [{sweep.solid.faces[f].key for f in cap} for cap in (sweep.source, sweep.target)]
    needed = set(range(len(groups)))
    in_caps = [{k for k in needed if keys[k] & cap} for cap in caps]
    for chosen in (needed - in_caps[0] - in_caps[1], *in_caps):
        for kept in [chosen, *({k} for k in sorted(chosen))][: 1 + MOST_KEPT * (len(chosen) > 1)]:
            if not kept or not kept <= needed:
                continue
            trial = _try_merged(part, [groups[k] for k in sorted(needed - kept)], source, target, refused=refused)
            if trial is None:
                continue
            found = trial.sweeps[0]
            there = [{found.solid.faces[f].key for f in cap} for cap in (found.source, found.target)]
            same = any(caps[0] <= a and caps[1] <= b for a, b in (there, there[::-1]))
            if same and corresponds(found) and found.score >= min(DOUBTFUL, sweep.score):
                best, needed = trial, needed - kept
    return best


def _try_merged(
    part: Part, groups: Sequence[Sequence[int]], source: Any, target: Any, *, refused: list[NotSweepableError]
) -> Opened | None:
    """The part without some outlines; None where OpenCASCADE cannot do without them, or it has no sweep then."""
    merged = cad.merge_faces(part, groups) if groups else part
    if merged is None:
        return None
    try:
        return Opened(merged, search(merged, source, target))
    except NotSweepableError as error:
        refused.append(error)
    try:
        return open_ring(merged, source, target)
    except NotSweepableError as error:
        refused.append(error)
    return None
