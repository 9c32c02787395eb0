"""Sizes and counts that a cell of blocks at its corners wants.

Place in the flow: called by :mod:`.whole`, which ties them to those of the other cells.
"""

from __future__ import annotations

from ..corner_blocks import CornerBlocks
from .sizes import TURN_DEFAULT, TURN_SIZED, turning

BLOCKS_ACROSS = 4
"""Hexahedra wanted along the shortest chain of a cell: two for each of the corners at its ends."""


def corner_size(blocks: CornerBlocks, common: float, most_hexes: float) -> float:
    """Target edge length of a cell, working units.

    What its shortest chain asks for, at most what gives as many hexahedra as cubes of the `common` size, and at least
    what gives no more than `most_hexes`: at sharp corners more hexahedra stand than cubes of their edges' lengths.
    """
    solid = blocks.solid
    lengths = [sum(solid.edges[e].length for e, _ in chain) for chain in blocks.chains]
    halves: dict[int, float] = dict.fromkeys(blocks.corners, 1.0)
    for ends, length in zip(blocks.ends, lengths, strict=True):
        for corner in ends:
            halves[corner] *= 0.5 * length
    volume = sum(halves.values())
    most = common * (volume / solid.volume) ** (1.0 / 3.0)
    return float(min(most, max(min(lengths) / BLOCKS_ACROSS, (volume / most_hexes) ** (1.0 / 3.0))))


def corner_counts(blocks: CornerBlocks, size: float, *, sized: bool) -> dict[int, float]:
    """Wanted count of every edge: chains of at least two segments, curved ones as finely as on sweeps."""
    solid, limit = blocks.solid, TURN_SIZED if sized else TURN_DEFAULT
    wanted: dict[int, float] = {}
    for chain in blocks.chains:
        total = sum(solid.edges[e].length for e, _ in chain)
        for e, _ in chain:
            edge = solid.edges[e]
            wanted[e] = max(1.0, edge.length / size, turning(solid, edge) / limit, 2.0 * edge.length / total)
    return wanted
