"""The boundary's mesh as near to the CAD model as is asked for: measured, and divided finer where it is too coarse.

Without a tolerance and without a size the boundary may lose `MOST_LOST` of volume and area and be off by `MOST_OFF` of
the part's size; with a size the user has the last word. Each round divides what sags: edges around the sweep and along
it for the sides, and the inside of caps, by the square root of how much too far they are off.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from .. import estimate
from ..blocks.reference import volume_doubt
from ..brep import Part
from ..errors import CoarseMeshError, SurfaceMeshError
from ..mesh import SurfaceMesh
from ..options import SweepOptions
from ..projection.caps import PlacedCap, place_target
from ..quality.deviation import Deviation, measure_deviation
from ..sweep import Intervals, Sweep
from .cap_sizes import least_of, sizes_along_rims, sizes_inside
from .curvature import divide_by_curvature
from .dividing import mesh_boundary
from .hints import Hints, resolve_hints
from .periodic_sides import cap_motion
from .run import Run

MOST_LOST = 0.005
"""Part of volume and area that a mesh may lose or gain where nothing is asked for."""
MOST_OFF = 1 / 200
"""Distance from the CAD faces, in sizes of the part, where nothing is asked for."""
MOST_HEXES = 200_000
"""Hexahedra up to which a part is divided finer by itself."""
COARSE = 0.05
"""Part of volume or area beyond which a mesh is not the part."""
LOST_SIZED = 0.04
"""Part of volume and area that a mesh may lose or gain where a size is asked for: what is coarser is divided finer."""
FINER = "divided finer than the size asked for, {size:g}, where the part would have lost its shape"
"""The note on such a mesh."""
MOST_ROUNDS = 8
"""Rounds of refining: the sag falls with the square, so two would do but for counts that are whole numbers, and for
meshers whose quads are not as small as they are asked for."""
MARGIN = 1.1
"""How much more than the sag asks for, since counts are whole numbers and the sag is not quite quadratic."""
LEAST_GAIN = 0.95
"""A round that leaves more than this part of the excess was in vain."""
ROUNDS_IN_VAIN = 2
"""Rounds in vain after which refining does not help; one may be so by a mesher's whim."""
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
    limit = _limit(part, sweep, options)
    best = last = first = _make(part, sweep, options, run, hints, streamed=streamed)
    in_vain = 0
    stop = "finer segments and quads bring it no nearer"
    for rounds in range(MOST_ROUNDS if limit is not None else 0):
        assert limit is not None
        if _shortfall(best.deviation, limit) <= 1.0:
            break
        wishes = _finer(
            sweep,
            last,
            hints,
            limit.beyond(max(in_vain, rounds - 1)),
            fixed=() if _layers_follow(options) else sweep.rails,
            graded=graded,
            # The places of rows along walls, and of nodes that answer others, are settled elsewhere.
            curved=np.isfinite(limit.distance) and not (options.wall_layers or options.periodic),
        )
        if wishes is None:
            break
        try:
            made = _make(part, sweep, options, run, wishes, streamed=streamed, most=limit.most)
        except _TooManyError:
            stop = f"nearer would take more than {MOST_HEXES:,} hexahedra; say a tolerance or a size"
            break
        except SurfaceMeshError as error:
            stop = f"finer quads could not be made: {error.message}"
            break
        gain = _shortfall(made.deviation, limit) / _shortfall(best.deviation, limit)
        last, hints = made, wishes
        best = made if gain < 1.0 else best
        in_vain = in_vain + 1 if gain > LEAST_GAIN else 0
        if in_vain == ROUNDS_IN_VAIN:
            break
    if limit is None:
        return best
    if options.size is not None and options.tolerance is None:  # near enough, or refused
        finer = [FINER.format(size=options.size)] if best is not first else []
        return replace(best, notes=(*best.notes, *finer))
    return replace(
        best,
        notes=(*best.notes, *_unmet(part, best.deviation, limit, options, stop)),
        shortfall=_shortfall(best.deviation, limit),
    )


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


def is_loose(options: SweepOptions) -> bool:
    """Whether a mesh may be another part's: the user allows it, or it is still to be curved or refined."""
    return bool(options.allow_coarse or options.allow_inverted or options.order > 1 or options.refine)


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


def coarse(how: str) -> CoarseMeshError:
    """The refusal of a mesh that is not the part; `how` says by how much."""
    return CoarseMeshError(
        f"the mesh is too coarse to be the part: {how}; take a smaller size or more layers, say a tolerance, or "
        "allow it with allow_coarse=True (--allow-coarse)"
    )


@dataclass(frozen=True, kw_only=True)
class _Limit:
    """What is asked of a boundary: distance, working units; part of volume and area; hexahedra."""

    distance: float
    lost: float
    most: int | None

    def beyond(self, rounds: int) -> _Limit:
        """More than is asked for, after some rounds: a mesher answers in whole quads, here and there."""
        share = MARGIN ** (-2 * rounds)
        return replace(self, distance=share * self.distance, lost=share * self.lost)


class _TooManyError(Exception):
    """More hexahedra than a part is given by itself."""


def _layers_follow(options: SweepOptions) -> bool:
    return options.layers is None and options.fractions is None


def _shortfall(deviation: Deviation, limit: _Limit) -> float:
    """How far a boundary is from what is asked for: above 1 it is too far off."""
    return max(
        deviation.distance / limit.distance, abs(deviation.volume) / limit.lost, abs(deviation.area) / limit.lost
    )


def _limit(part: Part, sweep: Sweep, options: SweepOptions) -> _Limit | None:
    if options.tolerance is not None:
        return _Limit(distance=options.tolerance / part.scale, lost=np.inf, most=None)
    doubt = volume_doubt(sweep.solid) / sweep.solid.volume
    if options.size is not None:  # an upper bound: the part keeps its shape, and no more is asked for
        if is_loose(options):
            return None
        return _Limit(distance=np.inf, lost=max(LOST_SIZED, doubt), most=max(MOST_HEXES, estimate.MOST_HEXES))
    return _Limit(distance=MOST_OFF * sweep.solid.size, lost=max(MOST_LOST, doubt), most=MOST_HEXES)


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
        raise _TooManyError


def _excess(deviation: Deviation, limit: _Limit) -> float:
    """Factor by which all segments of curved faces should be shorter for the sake of volume and area."""
    lost = max(abs(deviation.volume), abs(deviation.area))
    return float(np.sqrt(MARGIN * lost / limit.lost)) if lost > limit.lost else 1.0


def _finer(
    sweep: Sweep,
    made: Boundary,
    hints: Hints,
    limit: _Limit,
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


def _side_factors(sweep: Sweep, deviation: Deviation, limit: _Limit, excess: float) -> dict[int, float]:
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


def _unmet(part: Part, deviation: Deviation, limit: _Limit, options: SweepOptions, stop: str) -> list[str]:
    """Say so where the boundary stays farther off than is asked for; `stop` says why no finer one was made."""
    if _shortfall(deviation, limit) <= 1.0:
        return []
    reached = deviation.distance * part.scale
    if options.tolerance is not None:
        return [missed_tolerance(reached, options, stop)]
    lost = max(abs(deviation.volume), abs(deviation.area))
    off = f"volume and area are {lost:.2%} off the CAD's and a face by {reached:.3g}"
    return [f"{off}: {in_the_way(options) or stop}"]


def missed_tolerance(reached: float, options: SweepOptions, stop: str) -> str:
    """The note on a tolerance that is not kept, and what may have it kept; `stop` where nothing asked for is it."""
    return (
        f"the boundary is off its faces by {reached:.3g}, and {options.tolerance:g} was asked for: "
        f"{in_the_way(options) or stop}"
    )


def in_the_way(options: SweepOptions) -> str:
    """What the user has asked for that keeps segments and quads from being made finer; empty where there is none."""
    words = {
        "layers": options.layers or options.fractions,
        "rail_layers": options.rail_layers,
        "counts": options.counts,
        "sizes": options.sizes,
        "wall_layers": options.wall_layers,
        "periodic": options.periodic,
    }
    asked = [word for word, value in words.items() if value]
    return f"{', '.join(asked)} that were asked for, too, may stand in the way" if asked else ""
