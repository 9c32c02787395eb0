"""The ways to come to the sweeps of one solid, in the order in which they are tried: the table :data:`ATTEMPTS`.

Place in the flow: after loading. A new attempt is one more row: what it is called in a refusal, when it is worth
trying, and what it makes. The best of what was made counts; where nothing was, the refusal tells of all attempts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from .. import recognition, rows
from ..brep import Part
from ..errors import NotSweepableError
from ..options import SweepOptions
from ..sweep import Sweep
from . import changes
from .changes import Opened
from .parts import load, only_solid, search
from .run import Run
from .wishes.rails import fitting_sweeps

STRAIGHT = 0.9
"""Score of the best sweep of a full ring of revolution below which the sweep around its axis is scored, too."""


@dataclass(kw_only=True, eq=False)
class Search:
    """What has been tried with a part so far.

    Attributes
    ----------
    part : Part
        As it was loaded.
    source, target
        The user's words for its caps, or None.
    found : Opened or None
        The best so far.
    made : set of str
        Names of the attempts that came to sweeps.
    refused : dict of str to NotSweepableError
        Why the others did not, by name.
    """

    part: Part
    source: Any = None
    target: Any = None
    found: Opened | None = None
    made: set[str] = field(default_factory=set)
    refused: dict[str, NotSweepableError] = field(default_factory=dict)

    @property
    def hinted(self) -> bool:
        """Whether the user named a cap."""
        return self.source is not None or self.target is not None

    @property
    def wanting(self) -> bool:
        """Whether to go on looking: nothing is found, or nothing good; what the user named is taken as it is."""
        return self.found is None or not (self.hinted or self.found.does_well)

    def refusal(self) -> NotSweepableError:
        """Why there is no sweep: the part's own reasons, then those of what was tried besides."""
        if not self.refused:
            return NotSweepableError("no sweep was looked for", try_="switch a row of the table 'sweep' on again")
        first, *others = self.refused.items()
        told = next((error for name, error in others if name == OPEN), first[1])
        reasons = [*first[1].reasons, *(f"{name}: {error.message}" for name, error in others if error is not told)]
        return NotSweepableError(told.what, where=told.where, try_=told.try_, reasons=reasons, faces=told.faces)


@dataclass(frozen=True, kw_only=True)
class Attempt:
    """A row of the table.

    Attributes
    ----------
    name : str
        What is done to the part.
    when : callable
        Whether it is worth trying after what has been tried.
    make : callable
        The part with its sweeps; None where it does not apply.
    settles : bool
        Whether what it makes is better than all before, and ends the search.
    """

    name: str
    when: Callable[[Search], bool]
    make: Callable[[Search], Opened | None]
    settles: bool = False

    @property
    def row(self) -> str:
        """Its name among all rows."""
        return f"sweep: {self.name}"


OPEN = "with the ring cut open"

ATTEMPTS = (
    Attempt(
        name="as it is",
        when=lambda s: True,
        make=lambda s: Opened(s.part, search(s.part, s.source, s.target)),
    ),
    Attempt(
        name="with the ring cut open around its axis",
        when=lambda s: s.found is not None and not s.hinted and s.found.score < STRAIGHT,
        make=lambda s: changes.better_around(s.part, _best(s)),
        settles=True,
    ),
    Attempt(
        name="with roundings beside its caps divided",
        when=lambda s: s.found is not None,
        make=lambda s: changes.divide_roundings(s.part, _sweeps(s), s.source, s.target),
        settles=True,
    ),
    Attempt(
        name=OPEN,
        when=lambda s: s.wanting,
        make=lambda s: changes.open_ring(s.part, s.source, s.target),
    ),
    Attempt(
        name="with faces of one surface merged",
        # A cap that the user named keeps its faces where the part has any sweep.
        when=lambda s: s.wanting and OPEN not in s.made and not (s.hinted and _is_sweepable(s)),
        make=lambda s: changes.merge_and_find(s.part, s.source, s.target),
    ),
    Attempt(
        name="with plane faces around a hole divided",
        when=lambda s: s.wanting,
        make=lambda s: changes.across_walls(s.part, s.source, s.target),
    ),
)


def open_and_find(part: Part, source: Any, target: Any) -> tuple[Part, list[Sweep]]:
    """Find the sweeps of a part of one solid, changed where that is needed or better.

    Raises
    ------
    NotSweepableError
        There is none; ``.reasons`` tells of the part as it is, and of every change that was tried.
    """
    only_solid(part)
    so_far = Search(part=part, source=source, target=target)
    shares: set[str] = set()
    for attempt in ATTEMPTS:
        if not (rows.is_on(attempt.row) and attempt.when(so_far)):
            continue
        try:
            with rows.share() as own:
                made = attempt.make(so_far)
        except NotSweepableError as error:
            so_far.refused[attempt.name] = error
            continue
        if made is None:
            continue
        if attempt.settles:
            rows.took({*own, attempt.row})
            return made
        so_far.made.add(attempt.name)
        if so_far.found is None or made.score > so_far.found.score:
            so_far.found, shares = made, {*own, attempt.row}
    if so_far.found is None:
        raise so_far.refusal()
    rows.took(shares)
    return so_far.found


def _sweeps(so_far: Search) -> list[Sweep]:
    assert so_far.found is not None
    return so_far.found.sweeps


def _best(so_far: Search) -> Sweep:
    return _sweeps(so_far)[0]


def _is_sweepable(so_far: Search) -> bool:
    """Whether the part has sweeps from other caps than the user named."""
    try:
        return bool(recognition.find_sweeps(only_solid(so_far.part)))
    except NotSweepableError:
        return False


def find_candidates(source: Any, options: SweepOptions, run: Run) -> tuple[Part, list[Sweep]]:
    """Load one solid, and find its sweeps: for meshes that one sweep makes.

    Raises
    ------
    NotSweepableError
    """
    with run.stage("cad"):
        params = None if options.params is None else dict(options.params)
        part = load(
            source,
            params=params,
            part=options.part,
            only=options.only,
            skip=options.skip,
            touch=options.touch,
            cut_overlaps=options.cut_overlaps,
            on_progress=lambda share: run.on_progress("cad", share),
        )
    with run.stage("recognition"):
        part, sweeps = open_and_find(part, options.source, options.target)
        return part, fitting_sweeps(part, sweeps, options)
