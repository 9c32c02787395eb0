"""A boundary's mesh as near to the CAD model as is asked for: what is allowed, and the one loop that comes nearer.

Without a tolerance and without a size a mesh may lose `MOST_LOST` of volume and area and be off by `MOST_OFF` of the
part's size; with a size the user has the last word, and `LOST_SIZED` alone is held. How far a mesh is off and what is
to be finer for it, :mod:`.cells_accuracy` knows of sweeps and cells, and
:mod:`.stack_accuracy` of columns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np

from ... import budget
from ...errors import CoarseMeshError, SurfaceMeshError
from ...options import SweepOptions

MOST_LOST = 0.005
"""Part of volume and area that a mesh may lose or gain where nothing is asked for."""
MOST_OFF = 1 / 200
"""Distance from the CAD faces, in sizes of the part, where nothing is asked for."""
MOST_HEXES = 200_000
"""Hexahedra a solid up to which a part of which no size is asked is divided finer by itself."""
MOST_HALVINGS = 3
"""How often the segments of an edge are halved before the part is refused."""
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


@dataclass(frozen=True, kw_only=True)
class Limit:
    """What is asked of a boundary: distance, working units; part of volume and area."""

    distance: float
    lost: float

    def beyond(self, rounds: int) -> Limit:
        """More than is asked for, after some rounds: a mesher answers in whole quads, here and there."""
        share = MARGIN ** (-2 * rounds)
        return replace(self, distance=share * self.distance, lost=share * self.lost)

    def shortfall(self, distance: float, *lost: float) -> float:
        """How far a boundary is from what is asked for: above 1 it is too far off."""
        return max([distance / self.distance, *(abs(own) / self.lost for own in lost)])


def limit_of(options: SweepOptions, *, scale: float, size: float, doubt: float = 0.0) -> Limit:
    """What is asked of a solid of a size, working units, whose volume is known but for a part `doubt` of it."""
    if options.tolerance is not None:
        return Limit(distance=options.tolerance / scale, lost=np.inf)
    if options.size is not None:  # an upper bound: the part keeps its shape, and no more is asked for
        return Limit(distance=np.inf, lost=max(LOST_SIZED, doubt))
    return Limit(distance=MOST_OFF * size, lost=max(MOST_LOST, doubt))


class TooManyError(Exception):
    """More hexahedra than a part is given by itself; the argument says how many."""


def check_most(options: SweepOptions, n_solids: int, n_hexes: float) -> None:
    """Refuse a finer mesh of more hexahedra than solids are given by themselves.

    Raises
    ------
    TooManyError
    """
    most = min(MOST_HEXES * n_solids, budget.MOST_HEXES) if options.size is None else budget.MOST_HEXES
    if options.tolerance is None and n_hexes > most:
        raise TooManyError(most)


class Measured(Protocol):
    """A boundary's mesh that knows how many times farther off it is than allowed."""

    @property
    def shortfall(self) -> float: ...


Made = TypeVar("Made", bound=Measured)
Asked = TypeVar("Asked")


def come_nearer(
    first: Made,
    asked: Asked,
    *,
    make: Callable[[Asked], Made],
    finer: Callable[[Made, Asked, int], Asked | None],
    is_over: Callable[[], bool],
) -> tuple[Made, str]:
    """Mesh anew with finer wishes until a mesh is near enough, or they bring it no nearer.

    Parameters
    ----------
    first : Measured
        The mesh of what is asked.
    make : callable
        May raise SurfaceMeshError, or :class:`TooManyError` as `finer` may.
    finer : callable
        Wishes for finer quads where a mesh is too far off, the more so the more rounds were in vain; None where
        nothing can be divided.
    is_over : callable
        Whether there is no time for a nearer mesh: asked before each.

    Returns
    -------
    nearest : Measured
    stop : str
        Why no nearer one was made.
    """
    best = last = first
    in_vain = 0
    for rounds in range(MOST_ROUNDS):
        if best.shortfall <= 1.0:
            break
        if is_over():
            return best, "there was no time for finer segments and quads; say a tolerance or a size"
        try:
            shorter = finer(last, asked, max(in_vain, rounds - 1))
            if shorter is None:
                break
            last = make(shorter)
        except TooManyError as error:
            return best, f"nearer would take more than {error.args[0]:,} hexahedra; say a tolerance or a size"
        except SurfaceMeshError as error:
            return best, f"finer quads could not be made: {error.message}"
        asked = shorter
        gain = last.shortfall / best.shortfall
        best = last if gain < 1.0 else best
        in_vain = in_vain + 1 if gain > LEAST_GAIN else 0
        if in_vain == ROUNDS_IN_VAIN:
            break
    return best, "finer segments and quads bring it no nearer"


def is_loose(options: SweepOptions) -> bool:
    """Whether a mesh may be another part's: the user allows it, or it is still to be curved or refined."""
    return bool(options.allow_coarse or options.allow_inverted or options.order > 1 or options.refine)


def coarse(how: str) -> CoarseMeshError:
    """The refusal of a mesh that is not the part; `how` says by how much."""
    return CoarseMeshError(
        f"the mesh is too coarse to be the part: {how}; take a smaller size or more layers, say a tolerance, or "
        "allow it with allow_coarse=True (--allow-coarse)"
    )


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
