"""The boundary of one sweep as near to the CAD model as is asked for (:mod:`.nearer`).

Each round divides what sags: edges around the sweep and along it for the sides, and the inside of caps, by the square
root of how much too far they are off.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ... import estimate
from ...brep import Part, volume_doubt
from ...mesh import SurfaceMesh
from ...options import SweepOptions
from ...projection.caps import PlacedCap, place_target
from ...quality.deviation import Deviation, measure_deviation
from ...sweep import Intervals, Sweep
from ..run import Run
from ..wishes.hints import Hints, resolve_hints
from ..wishes.periodic_sides import cap_motion
from .cap_sizes import least_of, sizes_along_rims, sizes_inside
from .curvature import divide_by_curvature
from .dividing import mesh_boundary
from .nearer import (
    COARSE,
    FINER,
    MARGIN,
    Limit,
    TooManyError,
    coarse,
    come_nearer,
    in_the_way,
    is_loose,
    limit_of,
    missed_tolerance,
)

_SHARE = 0.1
"""A direction that sags less than this part of what is allowed stays as it is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Boundary:
    """Caps and sides of a sweep, meshed and measured.

    Attributes
    ----------
    counts : Intervals
    surfaces : SurfaceMesh
    target : PlacedCap
    deviation : Deviation
    notes : tuple of str
    shortfall : float
        How many times farther off it is than what is asked for, or what a part may be by default, allows.
    """

    counts: Intervals
    surfaces: SurfaceMesh
    target: PlacedCap
    deviation: Deviation
    notes: tuple[str, ...]
    shortfall: float = 0.0


def accurate_boundary(part: Part, sweep: Sweep, options: SweepOptions, run: Run, *, streamed: bool) -> Boundary:
    """Mesh caps and sides as near to the CAD faces as is asked for.

    Raises
    ------
    InputError, SurfaceMeshError, ProjectionError
        As by the stages; a boundary that is too coarse to be the part's.
    """
    hints = resolve_hints(part, sweep, options)
    graded = frozenset(hints.divisions)
    solid = sweep.solid
    limit = limit_of(options, scale=part.scale, size=solid.size, doubt=volume_doubt(solid) / solid.volume)

    def make(hints: Hints, most: int | None = limit.most) -> Boundary:
        made = _make(part, sweep, options, run, hints, streamed=streamed, most=most)
        off = made.deviation
        return replace(made, shortfall=limit.shortfall(off.distance, off.volume, off.area))

    def finer(made: Boundary, hints: Hints, rounds: int) -> Hints | None:
        return _finer(
            sweep,
            made,
            hints,
            limit.beyond(rounds),
            fixed=() if _layers_follow(options) else sweep.rails,
            graded=graded,
            # The places of rows along walls, and of nodes that answer others, are settled elsewhere.
            curved=np.isfinite(limit.distance) and not (options.wall_layers or options.periodic),
        )

    def nearest() -> tuple[Boundary, str]:
        return come_nearer(first, hints, make=make, finer=finer, is_over=partial(run.ends_refining, options))

    first = make(hints, None)
    if options.tolerance is None and options.size is not None:  # near enough, or refused
        best = first if is_loose(options) else nearest()[0]
        said = [] if best is first else [FINER.format(size=options.size)]
        return replace(best, notes=(*best.notes, *said), shortfall=0.0)
    best, stop = nearest()
    return replace(best, notes=(*best.notes, *_unmet(part, best, options, stop)))


def check_coarse(deviation: Deviation, options: SweepOptions, *, doubt: float = 0.0) -> None:
    """Refuse a boundary that is another part's; one that is still to be curved or refined comes nearer.

    Parameters
    ----------
    deviation : Deviation
    options : SweepOptions
    doubt : float
        Part of its volume that the model itself leaves open.

    Raises
    ------
    CoarseMeshError
        Another sweep or other quads would be as coarse: it is the sizes.
    """
    if not is_loose(options) and max(abs(deviation.volume) - doubt, abs(deviation.area)) > COARSE:
        raise coarse(f"its volume is {deviation.volume:+.1%} off the CAD's and its area {deviation.area:+.1%}")


def check_curved(volume: float, sweep: Sweep, options: SweepOptions) -> None:
    """Refuse a mesh of order 2 that is another part's.

    Parameters
    ----------
    volume : float
        Of the curved mesh, working units.

    Raises
    ------
    CoarseMeshError
    """
    known = sweep.solid.volume
    off = volume / known - 1.0
    allowed = options.allow_coarse or options.allow_inverted or options.refine
    if not allowed and abs(off) > COARSE + volume_doubt(sweep.solid) / known:
        raise coarse(f"its volume is {off:+.1%} off the CAD's")


def _layers_follow(options: SweepOptions) -> bool:
    return options.layers is None and options.fractions is None


def _make(
    part: Part,
    sweep: Sweep,
    options: SweepOptions,
    run: Run,
    hints: Hints,
    *,
    streamed: bool,
    most: int | None = None,
) -> Boundary:
    counts, surfaces, notes = mesh_boundary(
        part, sweep, options, run, hints, streamed=streamed, check=lambda made: _check_most(made, most)
    )
    with run.stage("projection"):
        if sweep.closed:
            surfaces.rings[-1] = surfaces.rings[0]
        target = place_target(sweep, surfaces)
        motion = cap_motion(sweep, hints.matches)
        if motion is not None:
            target = replace(target, points=motion(surfaces.source.points))
    with run.stage("surface"):
        deviation = measure_deviation(sweep, surfaces, target.points, target.faces)
    return Boundary(counts=counts, surfaces=surfaces, target=target, deviation=deviation, notes=tuple(notes))


def _check_most(expected: estimate.Estimate, most: int | None) -> None:
    if most is not None and expected.n_hexes > most:
        raise TooManyError


def _excess(deviation: Deviation, limit: Limit) -> float:
    """Factor by which all segments of curved faces should be shorter for the sake of volume and area."""
    lost = max(abs(deviation.volume), abs(deviation.area))
    return float(np.sqrt(MARGIN * lost / limit.lost)) if lost > limit.lost else 1.0


def _finer(
    sweep: Sweep,
    made: Boundary,
    hints: Hints,
    limit: Limit,
    *,
    fixed: Collection[int],
    graded: Collection[int],
    curved: bool,
) -> Hints | None:
    """Wishes for shorter segments; None where the boundary is near enough, or nothing can be divided.

    `graded`: edges that somebody has asked to be divided as they are; `curved`: others may be divided unevenly.
    """
    deviation, edges = made.deviation, sweep.solid.edges
    excess = _excess(deviation, limit)
    inside = sizes_inside(deviation, limit.distance, MARGIN, excess, hints.inside)
    demanded = {e for edges in hints.counts for e in edges} | hints.wished
    factors = _side_factors(sweep, deviation, limit, excess)
    factors = {e: f for e, f in factors.items() if e not in demanded and e not in fixed}
    lengths = {e: edges[e].length / max(1, int(made.counts.counts[e])) for e in factors}
    sizes, divisions = dict(hints.sizes), dict(hints.divisions)
    uneven: dict[int, float] = {}
    if curved:
        uneven, divided = divide_by_curvature(
            sweep, lengths, limit.distance / MARGIN, fixed={*fixed, *demanded, *divisions}
        )
        divisions |= divided
    for e, factor in factors.items():
        sizes[e] = min(sizes.get(e, np.inf), uneven.get(e, lengths[e] / factor))
    along: dict[int, float] = {}
    if inside is not None:
        known = {e: edges[e].length / sizes[e] if e in factors else n for e, n in enumerate(made.counts.counts)}
        spoken = {*fixed, *demanded, *graded}
        along, divided = sizes_along_rims(sweep, known, divisions, inside, fixed=spoken, uneven=curved)
        sizes, divisions = sizes | along, divisions | divided
    if not factors and not along and inside is None:
        return None
    return replace(hints, sizes=sizes, inside=least_of(hints.inside, inside), divisions=divisions)


def _side_factors(sweep: Sweep, deviation: Deviation, limit: Limit, excess: float) -> dict[int, float]:
    """By how much segments of the edges around sides that sag should be shorter."""
    factors: dict[int, float] = {}
    for side in sweep.linking_sides:
        sag = deviation.sides.get(side.face)
        if sag is None:
            continue
        whole = max(sag.around + sag.along, sag.inside)
        needed = max(float(np.sqrt(MARGIN * whole / limit.distance)) if whole > limit.distance else 1.0, excess)
        for own, chains in ((sag.around, (side.bottom, side.top)), (sag.along, (side.left, side.right))):
            if needed > 1.0 and own > _SHARE * whole:
                for edge, _ in (directed for chain in chains for directed in chain):
                    factors[edge] = max(factors.get(edge, 1.0), needed)
    for e, off in deviation.rims.items():
        if off > limit.distance:
            factors[e] = max(factors.get(e, 1.0), float(np.sqrt(MARGIN * off / limit.distance)))
    for side in sweep.linking_sides:
        for ends in ((side.bottom, side.top), (side.left, side.right)):
            answering = [e for chain in ends for e, _ in chain]
            if any(deviation.rims.get(e, 0.0) > limit.distance for e in answering):
                together = max(factors[e] for e in answering if e in factors)
                factors |= {e: max(factors.get(e, 1.0), together) for e in answering}
    for span in (span for loop in sweep.spans for span in loop):
        together = max(factors.get(e, 1.0) for e in span)
        if together > 1.0:
            factors |= dict.fromkeys(span, together)
    return factors


def _unmet(part: Part, made: Boundary, options: SweepOptions, stop: str) -> list[str]:
    """Say so where the boundary stays farther off than is asked for; `stop` says why no finer one was made."""
    if made.shortfall <= 1.0:
        return []
    reached = made.deviation.distance * part.scale
    if options.tolerance is not None:
        return [missed_tolerance(reached, options, stop)]
    lost = max(abs(made.deviation.volume), abs(made.deviation.area))
    off = f"volume and area are {lost:.2%} off the CAD's and a face by {reached:.3g}"
    return [f"{off}: {in_the_way(options) or stop}"]
