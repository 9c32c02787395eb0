"""The boundary's mesh as near to the CAD model as is asked for: measured, and divided finer where it is too coarse.

Without a tolerance and without a size the boundary may lose `MOST_LOST` of volume and area and be off by `MOST_OFF` of
the part's size; with a size the user has the last word. Each round divides what sags: edges around the sweep and along
it for the sides, and the inside of caps, by the square root of how much too far they are off.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np
import scipy

from .. import estimate
from ..arrays import FloatArray
from ..blocks.reference import volume_doubt
from ..brep import Part
from ..errors import CoarseMeshError, SurfaceMeshError
from ..mesh import SurfaceMesh
from ..options import SweepOptions
from ..projection.caps import PlacedCap, place_target
from ..quality.deviation import Deviation, measure_deviation
from ..surface import Division
from ..sweep import Intervals, Sweep
from .curvature import divide_by_curvature
from .dividing import mesh_boundary
from .hints import Hints, resolve_hints
from .local_sizes import GROWTH
from .periodic import cap_motion
from .run import Run

MOST_LOST = 0.005
"""Part of volume and area that a mesh may lose or gain where nothing is asked for."""
MOST_OFF = 1 / 200
"""Distance from the CAD faces, in sizes of the part, where nothing is asked for."""
MOST_HEXES = 200_000
"""Hexahedra up to which a part is divided finer by itself."""
COARSE = 0.05
"""Part of volume or area beyond which a mesh is not the part."""
MOST_ROUNDS = 6
"""Rounds of refining: the sag falls with the square, so two would do but for counts that are whole numbers, and for
meshers whose quads are not as small as they are asked for."""
MARGIN = 1.1
"""How much more than the sag asks for, since counts are whole numbers and the sag is not quite quadratic."""
LEAST_GAIN = 0.95
"""A round that leaves more than this part of the excess was in vain."""
ROUNDS_IN_VAIN = 2
"""Rounds in vain after which refining does not help; one may be so by a mesher's whim."""
_MOST_FINER = 3.0
"""Factor by which the edges of a cap are divided finer in one round."""
_NEARLY = 0.7
"""Share of the length at which a quad would sag too much from which on it may not grow by much, either."""
_NEAR = 16
"""Quads that sag, among those nearest to a place, that the length wanted there grows from."""
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
    """

    counts: Intervals
    surfaces: SurfaceMesh
    target: PlacedCap
    deviation: Deviation
    notes: tuple[str, ...]


def accurate_boundary(part: Part, sweep: Sweep, options: SweepOptions, run: Run, *, streamed: bool) -> Boundary:
    """Mesh caps and sides as near to the CAD faces as is asked for.

    Raises
    ------
    InputError, SurfaceMeshError, ProjectionError
        As by the stages; a boundary that is too coarse to be the part's.
    """
    hints = resolve_hints(part, sweep, options)
    limit = _limit(part, sweep, options)
    best = last = _make(part, sweep, options, run, hints, streamed=streamed)
    notes: list[str] = []
    in_vain = 0
    for _ in range(MOST_ROUNDS if limit is not None else 0):
        assert limit is not None
        if _shortfall(best.deviation, limit) <= 1.0:
            break
        wishes = _finer(
            sweep,
            last,
            hints,
            limit.beyond(in_vain),
            fixed=() if _layers_follow(options) else sweep.rails,
            # The places of rows along walls, and of nodes that answer others, are settled elsewhere.
            curved=not (options.wall_layers or options.periodic),
        )
        if wishes is None:
            break
        try:
            made = _make(part, sweep, options, run, wishes, streamed=streamed, most=limit.most)
        except _TooManyError:
            break
        except SurfaceMeshError as error:
            notes.append(f"finer quads for a nearer boundary could not be made: {error}")
            break
        gain = _shortfall(made.deviation, limit) / _shortfall(best.deviation, limit)
        last, hints = made, wishes
        best = made if gain < 1.0 else best
        in_vain = in_vain + 1 if gain > LEAST_GAIN else 0
        if in_vain == ROUNDS_IN_VAIN:
            break  # what is asked for stands in the way
    if limit is not None:
        notes += _unmet(part, best.deviation, limit, options)
    return replace(best, notes=(*best.notes, *notes))


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
    allowed = options.allow_coarse or options.allow_inverted or options.order > 1 or options.refine
    if not allowed and max(abs(deviation.volume) - doubt, abs(deviation.area)) > COARSE:
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

    def beyond(self, in_vain: int) -> _Limit:
        """More than is asked for, after rounds in vain: a mesher answers in whole quads, here and there."""
        share = MARGIN ** (-2 * in_vain)
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
    if options.size is not None:
        return None
    doubt = volume_doubt(sweep.solid) / sweep.solid.volume
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
    sweep: Sweep, made: Boundary, hints: Hints, limit: _Limit, *, fixed: Collection[int], curved: bool
) -> Hints | None:
    """Wishes for shorter segments; None where the boundary is near enough, or nothing can be divided.

    `curved`: edges may be divided by their curvature.
    """
    deviation, solid = made.deviation, sweep.solid
    excess = _excess(deviation, limit)
    inside = _inside_sizes(deviation, limit, excess, hints.inside)
    factors = _side_factors(sweep, deviation, limit, excess)
    for e, factor in ({} if inside is None else _cap_factors(sweep, made.counts, inside)).items():
        factors[e] = max(factors.get(e, 1.0), factor)
    demanded = {e for edges in hints.counts for e in edges} | hints.wished
    factors = {e: f for e, f in factors.items() if e not in demanded and e not in fixed}
    if not factors and inside is None:
        return None
    lengths = {e: solid.edges[e].length / max(1, int(made.counts.counts[e])) for e in factors}
    uneven: tuple[dict[int, float], dict[int, Division]] = ({}, {})
    if curved:
        uneven = divide_by_curvature(
            sweep, lengths, limit.distance / MARGIN, fixed={*fixed, *demanded, *hints.divisions}
        )
    sizes = dict(hints.sizes)
    for e, factor in factors.items():
        sizes[e] = min(sizes.get(e, np.inf), uneven[0].get(e, lengths[e] / factor))
    return replace(hints, sizes=sizes, inside=_least(hints.inside, inside), divisions={**hints.divisions, **uneven[1]})


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
    for span in (span for loop in sweep.spans for span in loop):
        together = max(factors.get(e, 1.0) for e in span)
        if together > 1.0:
            factors |= dict.fromkeys(span, together)
    return factors


def _cap_factors(sweep: Sweep, counts: Intervals, inside: Callable[[FloatArray], FloatArray]) -> dict[int, float]:
    """By how much segments around caps of one loop should be shorter: one that is a grid is divided by its edges."""
    factors: dict[int, float] = {}
    for loops in (sweep.solid.faces[f].loops for f in sweep.source):
        if len(loops) > 1:
            continue
        edges = [sweep.solid.edges[e] for e in loops[0].edges]
        wanted = inside(np.array([edge.midpoint for edge in edges]))
        for edge, size in zip(edges, wanted, strict=True):
            length = edge.length / max(1, int(counts.counts[edge.id]))
            if size < length:
                factors[edge.id] = max(factors.get(edge.id, 1.0), min(length / float(size), _MOST_FINER))
    return factors


def _inside_sizes(
    deviation: Deviation, limit: _Limit, excess: float, before: Callable[[FloatArray], FloatArray] | None
) -> Callable[[FloatArray], FloatArray] | None:
    """Wanted lengths at points of the source, from the quads that sag too much there; None where none does.

    A mesher's quads on a small crown are larger than the lengths wanted `before`: these are made shorter, then.
    """
    sags, lengths = deviation.cap_sags, deviation.cap_lengths
    if not len(sags):
        return None
    factor = np.sqrt(np.maximum(MARGIN * sags / limit.distance, 1e-12))
    if excess > 1.0:
        factor = np.where(sags > _SHARE * deviation.distance, np.maximum(factor, excess), factor)
    if not (factor > 1.05).any():
        return None
    if before is not None:
        lengths = np.where(factor > 1.0, np.minimum(lengths, before(deviation.cap_middles)), lengths)
    steep = factor > _NEARLY
    middles, wanted = deviation.cap_middles[steep], (lengths / factor)[steep]
    reach = deviation.cap_lengths[steep]
    tree = scipy.spatial.cKDTree(middles)

    def sizes(points: FloatArray) -> FloatArray:
        away, near = tree.query(points, k=min(_NEAR, len(wanted)))
        away, near = away.reshape(len(points), -1), near.reshape(len(points), -1)
        # Growing from the quads that sag, so that who asks at a few places does not miss them.
        grown = wanted[near] + (GROWTH - 1.0) * np.maximum(away - reach[near], 0.0)
        return np.asarray(grown.min(axis=1))

    return sizes


def _least(
    one: Callable[[FloatArray], FloatArray] | None, other: Callable[[FloatArray], FloatArray] | None
) -> Callable[[FloatArray], FloatArray] | None:
    if one is None or other is None:
        return one or other
    return lambda points: np.minimum(one(points), other(points))


def _unmet(part: Part, deviation: Deviation, limit: _Limit, options: SweepOptions) -> list[str]:
    """Say so where the boundary stays farther off than is asked for."""
    reached = deviation.distance * part.scale
    if options.tolerance is not None:
        if deviation.distance <= limit.distance:
            return []
        return [
            f"the boundary is off its faces by {reached:.3g}, and {options.tolerance:g} was asked for: "
            "counts, layers or sizes that were asked for, too, or the limit of hexahedra stand in the way"
        ]
    lost = max(abs(deviation.volume), abs(deviation.area))
    if lost <= limit.lost and deviation.distance <= limit.distance:
        return []
    return [
        f"volume and area are {lost:.2%} off the CAD's and a face by {reached:.3g}: nearer would take more than "
        f"{MOST_HEXES:,} hexahedra, or more than the counts and layers that were asked for; say a tolerance or a size"
    ]
