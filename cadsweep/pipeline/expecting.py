"""What a mesh is expected to be and to cost, in a second or three, before it is made.

Place in the flow: beside meshing; for those who want to see the figures first.

Method: the work on the mesh is begun, and ended as soon as its hexahedra are counted: when the boundary is as near to
the CAD as is asked for, before anything is placed inside. Caps of very many quads are not meshed for that: their areas
tell then. Where the time is over before, what is known by then is a lower end; where nothing is, cubes of the size that
is asked for fill the volume.

Not handled: that a mesh turns out poor, and another way is taken.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from .. import estimate
from ..brep import Part
from ..errors import CadSweepError, InputError
from ..estimate import Estimate
from ..options import SweepOptions
from .meshing import make_options
from .run import Run, silent, spent

log = logging.getLogger(__name__)

SECONDS = 3.0
"""Processor time after which nothing more is looked at; what is under way comes to its next stage."""
MOST_QUADS = 10_000
"""Quads of caps from which on they are not meshed to be counted."""


@dataclass(frozen=True, kw_only=True)
class Expected:
    """What is expected of a mesh.

    Attributes
    ----------
    estimate : Estimate or None
        None where it cannot be known before the mesh is made.
    is_least : bool
        The figures are a lower end.
    why : str
        What is not known, and why; empty where the figures are near to those of the mesh.
    """

    estimate: Estimate | None
    is_least: bool = False
    why: str = ""

    def __str__(self) -> str:
        if self.estimate is None:
            return f"unknown: {self.why}"
        words = f"{'at least ' if self.is_least else ''}{self.estimate.told}"
        return f"{words}; {self.why}" if self.why else words


class _Told(Exception):  # noqa: N818
    """Enough is known; the work ends here."""


class _Over(Exception):  # noqa: N818
    """The time for it is over."""


def expect(source: Any, /, **options: Any) -> Expected:
    """Say what :func:`sweep_mesh` is expected to make of these options.

    Parameters
    ----------
    source, **options
        As for :func:`sweep_mesh`.

    Returns
    -------
    Expected

    Raises
    ------
    InputError
        A wish means nothing of this part, contradicts another, or asks for more hexahedra than may be made.
    CadError
        The part cannot be read.

    Examples
    --------
    >>> import cadquery as cq
    >>> from cadsweep.pipeline.expecting import expect
    >>> expect(cq.Workplane().box(4, 3, 2), size=1.0, layers=2).estimate.n_hexes
    24
    """
    from .routes import open_part
    from .wishes.local_sizes import with_largest_size

    chosen = make_options(options)
    part = open_part(source, chosen, Run(on_progress=silent))
    several = len(part.solids) > 1 or chosen.only is not None or chosen.skip is not None
    chosen = replace(with_largest_size(part, chosen), params=None, part=None, names=None, suppress=None)
    begun = spent()
    found = [_of_group(own, chosen, make, begun) for own, make in _groups(part, chosen, several=several)]
    unknown = next((one for one in found if one.estimate is None), None)
    if unknown is not None:
        return unknown
    known = [one.estimate for one in found if one.estimate is not None]
    whole = estimate.estimate_counted(
        known[0], sum(one.n_quads for one in known), sum(one.n_hexes for one in known) * 8**chosen.refine
    )
    if chosen.max_hexes is not None and whole.n_hexes > chosen.max_hexes:
        raise InputError(
            f"about {whole.n_hexes:,} hexahedra are expected, more than the {chosen.max_hexes:,.0f} allowed"
        )
    why = next((one.why for one in found if one.why), "")
    return Expected(estimate=whole, is_least=any(one.is_least for one in found), why=why)


def _groups(part: Part, options: SweepOptions, *, several: bool) -> Iterator[tuple[Part, Callable[[Run], Any]]]:
    """The parts that are meshed by themselves, and what meshes them."""
    from .complexes.assemblies import each_group
    from .routes import mesh_part, mesh_solid

    if several and not options.cuts:
        yield from each_group(part, options, mesh_solid)
    else:
        yield part, lambda run: mesh_part(part, options, run)


def _of_group(part: Part, options: SweepOptions, make: Callable[[Run], Any], begun: float) -> Expected:
    """What is expected of solids that are meshed together, or of one."""
    known: list[Estimate] = []

    def watch(stage: str, fraction: float | None) -> None:
        if spent() - begun > SECONDS:
            raise _Over

    def expected(figures: Estimate, settled: bool) -> None:
        known.append(figures)
        if settled or figures.n_quads > MOST_QUADS:
            raise _Told
        watch("", None)

    run = Run(on_progress=watch, on_expected=expected, decompose_time=SECONDS, total=SECONDS)
    try:
        make(run)
    except _Told:
        few = known[-1].n_quads <= MOST_QUADS
        sure = few or (options.size is not None and options.tolerance is None)
        why = "" if sure else "accuracy may ask for more"
        return Expected(estimate=known[-1], is_least=not sure, why=why)
    except InputError:
        raise
    except (_Over, CadSweepError) as error:
        log.info("nothing to be expected: %s", error)
    if known:
        return Expected(estimate=known[-1], is_least=True, why="accuracy may ask for more")
    if options.size is None:
        return Expected(estimate=None, why="no count before the cuts are found")
    return Expected(estimate=_of_volume(part, options.size), why="before the cuts are found")


def _of_volume(part: Part, size: float) -> Estimate:
    volume = sum(solid.volume for solid in part.solids) * part.scale**3
    n_hexes = max(1, round(volume / size**3))
    n_layers = max(1, round(n_hexes ** (1 / 3)))
    one = Estimate(n_quads=1, n_layers=1, n_hexes=1, n_bytes=0, seconds=0.0, size=size)
    return estimate.estimate_counted(one, max(1, n_hexes // n_layers), n_hexes)
