"""All ways to sweep a part, also those that need it cut open or divided first."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

from .. import cad, recognition
from ..brep import Part
from ..errors import CadError, NotSweepableError
from ..stack import Stack
from ..sweep import Sweep
from .attempts import open_and_find
from .columns.stacking import other_stacks, stacks_instead
from .parts import load, only_solid, search


def find_sweeps(part: Any, *, source: Any = None, target: Any = None) -> list[Sweep | Stack]:
    """List the ways in which a part can be swept: those of the part as it is meshed, best first, then the others.

    A part with caps at more than two levels is a :class:`~cadsweep.stack.Stack`; such directions come last, and alone
    where there is no other. The others belong to the part cut open around its axis, or with its plane annuli divided:
    each has its own ``solid`` and says so in its ``notes``. :func:`cadsweep.sweep_mesh` takes them where it finds
    nothing better, or where the user names their source.

    Parameters
    ----------
    part : Part, or whatever :func:`load` takes
    source, target : name, id, CadQuery selector string, sequence of them, or None
        Keep only sweeps with this cap.

    Raises
    ------
    NotSweepableError
        There is none; ``.reasons`` says why, a line for each candidate.

    Examples
    --------
    >>> import cadsweep as cs
    >>> best = cs.find_sweeps("models/elbow.step")[0]
    >>> [best.solid.faces[i].name for i in (*best.source, *best.target)]
    ['inlet', 'outlet']
    >>> len(best.stations)  # closed rings of edges: two on the outside, two in the bore
    4
    """
    loaded = load(part)
    hinted = source is not None or target is not None
    try:
        swept, sweeps = open_and_find(loaded, source, target)
    except NotSweepableError as refused:
        if hinted:
            raise
        return [*stacks_instead(loaded, refused)]
    if hinted:
        return [*sweeps]
    plain = sweeps + other_directions(swept, sweeps)
    return [*plain, *other_stacks(loaded, plain)]


def other_directions(part: Part, sweeps: Sequence[Sweep]) -> list[Sweep]:
    """Sweeps around the axis of a full ring, and across its wall, best first; none where `sweeps` go around it."""
    found: list[Sweep] = []
    if any(sweep.closed for sweep in sweeps):
        return found
    with suppress(CadError, NotSweepableError):  # the part has other sweeps
        ring = cad.cut_ring(part)
        around = [sweep for sweep in search(ring, None, None) if sweep.closed] if ring is not None else []
        found += [_noted(sweep, "around the axis, the ring cut open") for sweep in around]
    divided = cad.divide_annuli(part)
    if divided is not None:
        n_old = len(only_solid(part).faces)
        known = {frozenset(sweep.source + sweep.target) for sweep in sweeps}
        # By the one face asked for: a search without a source stops at the ends, in pieces, as caps.
        for face in only_solid(part).faces:
            if face.kind == "plane":
                continue
            with suppress(NotSweepableError):
                for sweep in recognition.find_sweeps(only_solid(divided), source=(face.id,)):
                    caps = frozenset(sweep.source + sweep.target)
                    if caps not in known and max(caps) < n_old:
                        known.add(caps)
                        found.append(_noted(sweep, "across the wall, its plane ends divided"))
    return sorted(found, key=lambda sweep: -sweep.score)


def _noted(sweep: Sweep, note: str) -> Sweep:
    return replace(sweep, notes=(*sweep.notes, note))
