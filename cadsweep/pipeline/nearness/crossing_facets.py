"""Cells whose facets cross though no hexahedron is inverted: curved edges of these facets are divided finer.

Place in the flow: :mod:`..complexes.several` asks for finer wishes where the checks refuse a mesh for that alone.

Method: nodes inside a curved face lie on it, and the chord of its edge lies beside it: where another face comes near (a
rib's top that ends tangent to the rim of a hub), a quad that ends at the chord crosses one that reaches to the face.
What a chord is off falls with its length squared, so that a few more segments part them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...blocks.cells import CellBlocks
from ...brep import Part
from ...errors import InvertedHexError
from ...intervals import Wishes
from ...sweep import Intervals
from .cells_accuracy import finer_sizes
from .measured import edge_sag

MOST_ROUNDS = 2
"""Times that edges are divided finer: chords are then off by a sixteenth of what they were, as in :mod:`..refusing`."""

FINER = "curved edges divided finer where quads of the boundary crossed"

_TIMES = 2.0
"""How many times as many segments an edge gets."""

_NEAR = 1e-6
"""Distance over the size of a cell up to which a corner of a quad is a node of an edge."""


def finer_where_crossing(
    part: Part, cells: CellBlocks, counts: Sequence[Intervals], error: InvertedHexError, asked: Wishes
) -> Wishes | None:
    """Wishes for finer chords where quads of the boundary cross; None where none of them ends at a chord."""
    if not error.crossing:
        return None
    corners = (np.array(error.crossing) - part.offset) / part.scale
    found: dict[int, float] = {}
    for cell, solid in enumerate(part.solids):
        for edge in solid.edges:
            if int(solid.edge_keys[edge.id]) not in cells.edge_nodes:
                continue  # along columns, and straight
            nodes = cells.points[cells.edge_nodes[int(solid.edge_keys[edge.id])]]
            away = np.linalg.norm(nodes[:, None] - corners[None], axis=2).min(axis=1)
            there = away <= _NEAR * solid.size
            if (there[1:] & there[:-1]).any() and edge_sag(part, cells, cell, edge.id) > _NEAR * solid.size:
                found[int(solid.edge_keys[edge.id])] = _TIMES
    sizes = finer_sizes(part, counts, found, asked)
    return replace(asked, edge_sizes={**asked.edge_sizes, **sizes}) if sizes else None
