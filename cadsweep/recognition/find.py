"""All sweeps of a solid, best first, or a reason for every face that is no cap of one.

Place in the flow: ``recognition`` takes a :class:`~cadsweep.brep.Solid` and gives
:class:`~cadsweep.sweep.Sweep`; ``intervals`` and ``surface`` work from that. Method:
:mod:`.corners` reads faces as rectangles, :mod:`.bands` ties edges to classes that define bands of
linking sides, :mod:`.layout` joins bands between two caps, :mod:`.build` puts everything in order,
:mod:`.score` ranks. Where all that is poor, the bands across a sheet are taken alone: what rings lie on its two
skins are parts of the caps then.

Not handled: solids that must be cut first (bosses, pockets, crossing holes; full rings are cut by ``cad``), and
linking sides that would have to be decomposed into several rectangles.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import pi

from .. import rows
from ..brep import Solid
from ..errors import InputError, NotSweepableError
from ..sweep import Sweep
from .bands import Band, BandSearch, find_bands
from .build import build_sweep
from .growth import with_grown
from .layout import SHALLOW, Layout, choose_bands, choose_sheets, lay_out
from .reasons import explain, no_sweep
from .score import score_layout, score_sweep

log = logging.getLogger(__name__)

POOR = 0.3
"""Sweeps whose score is below this part of the best one's are given only where a hint asks for them."""
DOUBTFUL = 0.35
"""Score of the best sweep below which sheets are looked for."""
SHEET = "sweep: through a sheet"
"""The row of sweeps from one skin of a sheet to the other."""
SMALLER = 0.99
"""Greatest score of a sweep as a part of that of the same sweep with larger, better caps."""


@dataclass(kw_only=True, eq=False)
class Findings:
    """What a search found.

    Attributes
    ----------
    sweeps : list of Sweep
        Best first; every pair of caps once.
    search : BandSearch
    failures : list of (bands, reason)
        Sets of bands that make no sweep.
    """

    sweeps: list[Sweep] = field(default_factory=list)
    search: BandSearch
    failures: list[tuple[Sequence[Band], str]] = field(default_factory=list)


def find_sweeps(
    solid: Solid, *, source: Sequence[int] | None = None, target: Sequence[int] | None = None
) -> list[Sweep]:
    """Find every way to sweep a solid, best first.

    Parameters
    ----------
    solid : Solid
    source, target : sequence of int, optional
        Face ids that the source or target cap must contain.

    Returns
    -------
    list of Sweep
        Best expected quality first; of a cap pair only the better direction, unless a hint asks
        for the other.

    Raises
    ------
    NotSweepableError
        No pair of caps makes the solid a sweep; ``reasons`` has a line for every face.
    InputError
        A hint names a face that the solid does not have.
    """
    for name, hint in (("source", source), ("target", target)):
        unknown = [f for f in hint or () if not 0 <= f < len(solid.faces)]
        if unknown:
            raise InputError(f"{name}: there is no face {unknown[0]}; the solid has faces 0 to {len(solid.faces) - 1}")
    both = sorted(set(source or ()) & set(target or ()))
    if both:
        raise InputError(
            f"{solid.faces[both[0]].label()} is asked for as source and as target: a sweep goes from one cap to another"
        )
    found = search_sweeps(solid)
    sweeps = found.sweeps
    if not sweeps:
        reasons = explain(solid, found.search, found.failures)
        raise no_sweep(solid, reasons)
    if not source and not target:
        return [s for s in sweeps if s.score >= POOR * sweeps[0].score]
    hinted = [s for s in (_hinted(s, set(source or ()), set(target or ())) for s in sweeps) if s is not None]
    if not hinted:
        wanted = " and ".join(
            f"{name} {', '.join(solid.faces[f].label() for f in hint)}"
            for name, hint in (("source", source), ("target", target))
            if hint
        )
        asked = set(source or ()) | set(target or ())
        reasons = [r for r in explain(solid, found.search, found.failures) if r.face in asked]
        others = "; ".join(_pair(s) for s in sweeps[:4])
        raise NotSweepableError(
            f"no sweep has the {wanted}",
            where=reasons[0].text,
            try_=f"one of the sweeps found: {others}",
            reasons=[reason.text for reason in reasons],
            faces=sorted(asked),
        )
    return hinted


def _pair(sweep: Sweep) -> str:
    a, b = sweep.solid.faces[sweep.source[0]], sweep.solid.faces[sweep.target[0]]
    return f"{a.label()} to {b.label()}"


def _hinted(sweep: Sweep, source: set[int], target: set[int]) -> Sweep | None:
    """Return the sweep in the direction that the hints ask for, None where it does not fit them."""
    if source <= set(sweep.source) and target <= set(sweep.target):
        return sweep
    if source <= set(sweep.target) and target <= set(sweep.source):
        return _turned(sweep)
    return None


def _turned(sweep: Sweep) -> Sweep | None:
    """The same sweep from its other cap."""
    for layouts in (_layouts(sweep.solid, folded) for folded in (False, True)):
        for layout in layouts:
            for reverse in (False, True):
                caps = layout.caps[::-1] if reverse else layout.caps
                if (caps[0], caps[1]) == (sweep.target, sweep.source):
                    with suppress(NotSweepableError):  # not a sweep from this side
                        return replace(build_sweep(sweep.solid, layout, reverse=reverse), score=sweep.score)
                    return None
    return None


def _layouts(solid: Solid, folded: bool) -> list[Layout]:
    search = find_bands(solid, folded=folded)
    layouts: list[Layout] = []
    sets = [(bands, SHALLOW) for bands in choose_bands(search.bands)]
    if rows.is_on(SHEET):
        sets += [(bands, pi) for bands in choose_sheets(solid, search.bands)]
    for bands, steepest in sets:
        with suppress(NotSweepableError):  # other bands may make the sweep that is looked for
            for layout in lay_out(solid, bands, steepest=steepest):
                layouts.extend(with_grown(solid, layout))
    return layouts


def search_sweeps(solid: Solid, *, folds: bool = True, most_readings: int | None = None) -> Findings:
    """Search for sweeps; sharply folded sides are tried only where nothing else is found.

    Parameters
    ----------
    solid : Solid
    folds : bool
        Try folded sides at all.
    most_readings : int, optional
        Keep only so many readings of each face as a rectangle, the best; 1 is fast.
    """
    first: Findings | None = None
    for folded in (False, True) if folds else (False,):
        search = find_bands(solid, folded=folded, most_readings=most_readings)
        found = Findings(search=search)
        seen: set[frozenset[tuple[int, ...]]] = set()
        for bands in choose_bands(search.bands):
            _join(solid, bands, SHALLOW, found, seen)
        best = max((sweep.score for sweep in found.sweeps), default=0.0)
        if best < DOUBTFUL and rows.is_on(SHEET):
            for bands in choose_sheets(solid, search.bands):
                _join(solid, bands, pi, found, seen)
            if max((sweep.score for sweep in found.sweeps), default=0.0) > best:
                rows.took([SHEET])
        found.sweeps.sort(key=lambda s: (-s.score, len(s.linking_sides), s.source))
        log.debug("%d sweeps from %d bands (folded: %s)", len(found.sweeps), len(search.bands), folded)
        if found.sweeps:
            return found
        first = first or found
    assert first is not None
    return first


def _join(
    solid: Solid, bands: Sequence[Band], steepest: float, found: Findings, seen: set[frozenset[tuple[int, ...]]]
) -> None:
    """Join a set of bands to sweeps with caps not seen before; they, or why there are none, join what was found."""
    try:
        layouts = lay_out(solid, bands, steepest=steepest)
    except NotSweepableError as reason:
        found.failures.append((bands, reason.message))
        return
    for layout in layouts:
        best = 1.0
        for each in with_grown(solid, layout):
            if frozenset(each.caps) in seen:
                continue
            seen.add(frozenset(each.caps))
            try:
                built = build_sweep(solid, each, reverse=_second_is_source(solid, each))
            except NotSweepableError as reason:
                found.failures.append((bands, reason.message))
                continue
            score = min(best, score_sweep(built, score_layout(solid, each)))
            best = SMALLER * score
            found.sweeps.append(replace(built, score=round(score, 9)))


def _second_is_source(solid: Solid, layout: Layout) -> bool:
    """Whether the second cap makes the better source: more faces, then curved, then more edges."""

    def rank(cap: tuple[int, ...]) -> tuple[int, int, int]:
        faces = [solid.faces[f] for f in cap]
        return (len(faces), sum(f.kind != "plane" for f in faces), sum(len(f.edges) for f in faces))

    return rank(layout.caps[1]) > rank(layout.caps[0])
