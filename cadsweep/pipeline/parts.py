"""From what the user gives to a part and its candidate sweeps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any

from .. import cad, recognition
from ..brep import Part, Solid
from ..errors import CadError, InputError, NotSweepableError
from ..options import SweepOptions
from ..sweep import Sweep
from .hints import fitting_sweeps
from .run import Run

DOUBTFUL = 0.4
"""Score of the best sweep below which one of the part with merged faces is looked for."""

STRAIGHT = 0.9
"""Score of the best sweep of a full ring of revolution below which the sweep around its axis is scored, too."""

MOST_DIVIDED = 3
"""Sweeps whose caps' roundings are divided to see whether a better one comes of it."""

MOST_KEPT = 4
"""Outlines of sides, and of each cap, that are tried one by one for whether the mesh can follow them."""


def load(
    source: Any,
    *,
    params: dict[str, Any] | None = None,
    part: str | int | None = None,
    touch: float | None = None,
    on_progress: Callable[[float], None] | None = None,
) -> Part:
    """Read a part and make it clean for meshing.

    Parameters
    ----------
    source : path, CadQuery object, or anything with ``.wrapped``
        A ``.step``, ``.stp``, ``.brep``, ``.iges``, ``.igs`` or ``.py`` file; a ``cq.Workplane``,
        ``cq.Shape`` or ``cq.Assembly``. A CadQuery script is executed.
    params : dict or None
        Parameters of a script.
    part : str, int or None
        Which solid of an assembly: its name, or its number from 0; None takes them all, imprinted on each other.
    touch : float or None
        Distance, model units, up to which solids are taken to touch; None derives it from the part's size.
    on_progress : callable or None
        Called with the share that is done while several solids are healed and read.

    Raises
    ------
    InputError
        No such file, an unknown format, a part that is not there, or parameters that the script does not have.
    CadError
        The model cannot be read, or holds no usable solid.
    """
    if isinstance(source, Part):
        if params:
            raise InputError("params go with a script; this part is loaded already")
        if part is not None:
            raise InputError("part chooses a solid of what is loaded; this part is loaded already")
        return source
    return cad.load(source, params=params, part=part, touch=touch, on_progress=on_progress)


def open_and_find(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]]:
    """Find the sweeps of a part.

    A full ring of revolution that has none, or a worse one than that around its axis, is cut open. Where a cap of
    the best sweep runs tangent into a rounding, that is divided between cap and sides. Where nothing is found, or
    nothing good, or the best sweep's caps are divided in ways that do not correspond, faces that only divide one
    surface are merged; where still nothing is found, plane faces around a hole are divided. A cap that the user
    named keeps its faces where the part has any sweep.
    """
    solid = only_solid(part)
    hinted = source is not None or target is not None
    refusal: NotSweepableError | None = None
    sweeps: list[Sweep] = []
    try:
        sweeps = search(part, source, target)
        around = None if hinted else _better_around(part, sweeps[0])
        if around is not None:
            return around
        divided = _divide_roundings(part, sweeps, source, target)
        if divided is not None:
            return divided
        if _corresponds(sweeps[0]) and sweeps[0].score >= DOUBTFUL:
            return part, sweeps
    except NotSweepableError as error:
        refusal = error
    if hinted and refusal is None:
        return part, sweeps
    try:
        better = _open_ring(part, source, target)
    except NotSweepableError as error:
        better = None
        if refusal is not None:
            refusal = NotSweepableError(str(error), reasons=refusal.reasons)
    if better is None and not (hinted and _is_sweepable(solid)):
        better = _merge_and_find(part, source, target)
    if better is not None and (not sweeps or better[1][0].score > sweeps[0].score):
        part, sweeps = better
    elif refusal is not None:
        across = _across_walls(part, source, target)
        if across is None:
            raise refusal
        part, sweeps = across
    return part, sweeps


def _across_walls(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]] | None:
    """The part with plane faces around a hole divided, for a sweep across its walls; None where that gives none."""
    divided = cad.divide_annuli(part)
    if divided is not None:
        with suppress(NotSweepableError):  # the part as it was has the last word
            return divided, search(divided, source, target)
    return None


def was_divided_across(part: Part, opened: Part) -> bool:
    """Whether a part has no sweep as it is, and :func:`open_and_find` divided plane faces around its holes."""
    return opened is not part and any(note.startswith(cad.ANNULI_NOTE) for note in opened.notes[len(part.notes) :])


def _open_ring(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]] | None:
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
            return ring, closed
        if gaps:
            name = only_solid(part).name
            named = f"'{name}'" if name else "the solid"
            raise NotSweepableError(
                f"{named} is a closed ring, and {gaps[0]}; cut it into two solids and mesh each", reasons=gaps
            )
    return None


def _cut_open(part: Part) -> Iterator[Part]:
    ring = cad.cut_ring(part)
    if ring is not None:
        yield ring
    elif recognition.may_be_ring(only_solid(part)):
        yield from cad.cut_closed(part)


def search(part: Part, source: Any, target: Any) -> list[Sweep]:
    return recognition.find_sweeps(only_solid(part), source=resolve_cap(part, source), target=resolve_cap(part, target))


def _better_around(part: Part, sweep: Sweep) -> tuple[Part, list[Sweep]] | None:
    """A full ring cut open, where its sweep around the axis is better than the one given, which is not straight."""
    if sweep.score >= STRAIGHT:
        return None
    with suppress(CadError, NotSweepableError):  # a ring that cannot be cut open is swept as it is
        ring = cad.cut_ring(part)
        if ring is not None:
            sweeps = [around for around in search(ring, None, None) if around.closed]
            if sweeps and sweeps[0].score > sweep.score:
                return ring, sweeps
    return None


def _divide_roundings(part: Part, sweeps: list[Sweep], source: Any, target: Any) -> tuple[Part, list[Sweep]] | None:
    """The part with the roundings of a sweep's caps divided, where that promises better hexes at their edge."""
    # Faces keep their ids, so the user's choice means the same in the divided part.
    choice = resolve_cap(part, source), resolve_cap(part, target)
    worst = recognition.worst_rim(sweeps[0])
    best: tuple[Part, list[Sweep]] | None = None
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
            if gain <= 1.0 or better[0].score * gain <= sweeps[0].score or not _corresponds(better[0]):
                continue
            if best is None or better[0].score > best[1][0].score:
                best = divided, better
    return best


def _corresponds(sweep: Sweep) -> bool:
    """Whether the mesh follows all inner edges of the target."""
    return len(sweep.target) == 1 or bool(sweep.target_faces)


def _merge_and_find(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]] | None:
    """Merge faces that divide one surface, no more of them than the sweep needs; None where that gives no sweep.

    Outlines that the mesh can follow stay: those of the sides are tried first, then those of the source
    (which the projected mesh repeats), then those of the target.
    """
    groups = cad.find_mergeable(part)
    best = _try_merged(part, groups, source, target) if groups else None
    if best is None or best[1][0].score < DOUBTFUL:
        more = cad.find_mergeable(part, across_kinks=True)
        other = _try_merged(part, more, source, target) if more != groups else None
        if other is not None and (best is None or other[1][0].score > best[1][0].score):
            best, groups = other, more
    if best is None:
        return None
    sweep = best[1][0]
    solid = only_solid(part)
    keys = [{solid.faces[f].key for e in group for f in solid.edges[e].faces} for group in groups]
    caps = [{sweep.solid.faces[f].key for f in cap} for cap in (sweep.source, sweep.target)]
    needed = set(range(len(groups)))
    in_caps = [{k for k in needed if keys[k] & cap} for cap in caps]
    for chosen in (needed - in_caps[0] - in_caps[1], *in_caps):
        for kept in [chosen, *({k} for k in sorted(chosen))][: 1 + MOST_KEPT * (len(chosen) > 1)]:
            if not kept or not kept <= needed:
                continue
            trial = _try_merged(part, [groups[k] for k in sorted(needed - kept)], source, target)
            if trial is None:
                continue
            found = trial[1][0]
            there = [{found.solid.faces[f].key for f in cap} for cap in (found.source, found.target)]
            same = any(caps[0] <= a and caps[1] <= b for a, b in (there, there[::-1]))
            if same and _corresponds(found) and found.score >= min(DOUBTFUL, sweep.score):
                best, needed = trial, needed - kept
    return best


def _try_merged(
    part: Part, groups: Sequence[Sequence[int]], source: Any, target: Any
) -> tuple[Part, list[Sweep]] | None:
    merged = cad.merge_faces(part, groups) if groups else part
    if merged is None:
        return None
    with suppress(NotSweepableError):  # then the part as it was has the last word
        try:
            return merged, search(merged, source, target)
        except NotSweepableError:
            return _open_ring(merged, source, target)
    return None


def _is_sweepable(solid: Solid) -> bool:
    try:
        return bool(recognition.find_sweeps(solid))
    except NotSweepableError:
        return False


def only_solid(part: Part) -> Solid:
    if len(part.solids) != 1:
        raise CadError(
            f"'{part.name}' has {len(part.solids)} solids, and a sweep belongs to one: "
            "choose one with part=..., or fuse them first"
        )
    return part.solids[0]


def resolve_cap(part: Part, choice: Any) -> tuple[int, ...] | None:
    """Resolve the user's word for a cap to face ids."""
    if choice is None:
        return None
    choices = choice if isinstance(choice, list | tuple) else [choice]
    return tuple(dict.fromkeys(face for one in choices for face in cad.select_faces(part, one)))


def find_candidates(source: Any, options: SweepOptions, run: Run) -> tuple[Part, list[Sweep]]:
    with run.stage("cad"):
        params = None if options.params is None else dict(options.params)
        part = load(
            source,
            params=params,
            part=options.part,
            touch=options.touch,
            on_progress=lambda share: run.on_progress("cad", share),
        )
    with run.stage("recognition"):
        part, sweeps = open_and_find(part, options.source, options.target)
        return part, fitting_sweeps(part, sweeps, options)
