"""Whether what a mesh is expected to cost can be afforded, and what would fit where it cannot.

Place in the flow: asked as soon as a mesh is estimated, and before it is refined.
"""

from __future__ import annotations

import math

from .errors import InputError
from .estimate import BASE_BYTES, LARGEST_COUNT, Estimate, peak_bytes, say_count, say_memory
from .machine import GIGABYTE, free_memory

MOST_HEXES = 5_000_000
"""Hexahedra of a mesh in memory from which on a size is taken for a slip, unless the user names a limit."""

TENTH = 0.1
"""The part of a refused mesh that the message gives a size for."""


def check_budget(expected: Estimate, *, max_hexes: float | None = None, max_memory: float | None = None) -> None:
    """Refuse a mesh that is too large.

    Parameters
    ----------
    max_hexes : float or None
        None: `MOST_HEXES` in memory, and no limit where it is streamed; ``math.inf``: as many as the memory holds.
    max_memory : float or None
        GB; None: nine tenths of what this machine, or this container, has free.

    Raises
    ------
    InputError
        With the figures, and the size that would fit.
    """
    budget = (free_memory() if max_memory is None else max_memory) * GIGABYTE
    by_itself = max_hexes is None and not expected.streamed
    most = MOST_HEXES if by_itself else math.inf if max_hexes is None else max_hexes
    if expected.n_hexes <= most and expected.n_bytes <= budget:
        return
    if by_itself and expected.n_hexes > most:
        tenth = max(1.0, TENTH * expected.n_hexes)
        ways = []
        if max(expected.n_quads, expected.n_layers) < LARGEST_COUNT:  # beyond it the number says nothing
            ways = [way.replace("or more", "for a tenth of it") for way in _ways_out(expected, math.inf, tenth)[:-1]]
        if tenth > most:  # a tenth would be refused again
            ways = _ways_out(expected, budget, most)[:-1] + ways[:1]
        ways.append("raise the limit where so many are meant: max_hexes=... (--max-hexes N, or --yes)")
        raise InputError(
            f"the mesh would have {expected}, more than the {MOST_HEXES:,} that are made without asking; "
            + ", or ".join(ways)
        )
    limit = f"{say_count(int(most))} hexes" if expected.n_hexes > most else f"{say_memory(budget)} of memory"
    ways = _ways_out(expected, budget, most)
    raise InputError(f"the mesh would have {expected}, beyond the limit of {limit}; " + ", or ".join(ways))


def check_refined(
    n_hexes: int, levels: int, *, max_hexes: float | None = None, max_memory: float | None = None
) -> None:
    """Refuse to halve a mesh so often that it is too large.

    Parameters
    ----------
    n_hexes : int
        Before.
    levels : int
        Each makes eight of every hexahedron.
    max_hexes, max_memory : float or None
        As for `check_budget`.

    Raises
    ------
    InputError
        With the figures, and the levels that would fit.
    """
    budget = (free_memory() if max_memory is None else max_memory) * GIGABYTE
    most = MOST_HEXES if max_hexes is None else max_hexes

    def fits(level: int) -> bool:
        return n_hexes * 8**level <= most and peak_bytes(0, n_hexes * 8**level, streamed=False) <= budget

    if fits(levels):
        return
    n_fine = n_hexes * 8**levels
    beyond = f"{say_count(int(most))} hexes" if n_fine > most else f"{say_memory(budget)} of memory"
    beyond = f"the {MOST_HEXES:,} that are made without asking" if max_hexes is None and n_fine > most else beyond
    fewer = max((level for level in range(levels) if fits(level)), default=0)
    ways = [f"try refine={fewer} ({say_count(n_hexes * 8**fewer)} hexes)"] if fewer else ["leave refine out"]
    raise InputError(
        f"refine={levels} would make {say_count(n_fine)} hexes of {say_count(n_hexes)}, "
        f"{say_memory(peak_bytes(0, n_fine, streamed=False))}, more than {beyond}; {ways[0]}, "
        "or raise the limit where so many are meant: max_hexes=... (--max-hexes N, or --yes)"
    )


def _ways_out(expected: Estimate, budget: float, most: float) -> list[str]:
    """What the user may do: the size that fits, the layers that fit, a higher limit."""
    power = 3 if expected.layers_follow else 2

    def fits(ratio: float) -> bool:
        n_quads, n_hexes = expected.n_quads / ratio**2, expected.n_hexes / ratio**power
        return n_hexes <= most and peak_bytes(n_quads, n_hexes, expected.streamed) <= budget

    low, high = 1.0, 1e100
    for _ in range(200):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    ways = []
    size = _round_up(1.05 * high * expected.size)
    if fits(high) and size < expected.largest:
        ways.append(f"try size {size:g} or more")
    per_layer = peak_bytes(0, expected.n_quads, expected.streamed) - BASE_BYTES
    room = budget - peak_bytes(expected.n_quads, 0, expected.streamed)
    layers = min(most / expected.n_quads, room / per_layer if not expected.streamed else math.inf)
    if 2 <= layers < expected.n_layers:
        ways.append(f"try {_round_down(layers):,} layers")
    return [*ways, "raise the limit"]


def _round_up(value: float) -> float:
    """Two digits, upwards."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return math.ceil(value / unit) * unit


def _round_down(value: float) -> int:
    """Two digits, downwards."""
    unit = 10.0 ** max(math.floor(math.log10(value)) - 1, 0)
    return int(math.floor(value / unit) * unit)
