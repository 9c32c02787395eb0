"""Faces of caps that were meshed before: the same ones with other counts on a few edges elsewhere, or others like them.

Place in the flow: ``quads`` asks here before it fills a face.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import IntArray
from .congruent import Congruent
from .outline import FaceQuads, Outline


@dataclass(frozen=True, kw_only=True)
class _Known:
    """Quads, and the numbers that nodes had then: those of the face's edges in their order, and the first inner one."""

    patch: FaceQuads
    nodes: IntArray
    first: int


@dataclass(frozen=True, eq=False)
class Memory:
    """Quads of faces by the nodes of their outlines, of one part with the same sizes, and plane ones by their shape."""

    _congruent: Congruent = field(default_factory=Congruent)
    _known: dict[bytes, _Known] = field(default_factory=dict)

    def recall(self, outline: Outline) -> FaceQuads | None:
        """Quads of the face on the same nodes, or of one like it, in the outline's numbers; None if there are none."""
        known = None if outline.walls is not None else self._known.get(_key(outline))
        if known is None:
            like = self._congruent.recall(outline)
            if like is not None:
                self._keep(outline, like)
            return like
        # Numbers of the nodes then, in order, and the place of each on the face's edges.
        old, at = np.unique(known.nodes, return_index=True)
        quads = known.patch.quads
        on_edges = _edge_nodes(outline)[at[np.minimum(np.searchsorted(old, quads), len(old) - 1)]]
        inside = quads - known.first + len(outline.known)
        return replace(known.patch, quads=np.where(quads < known.first, on_edges, inside))

    def keep(self, outline: Outline, patch: FaceQuads) -> None:
        """Remember a face."""
        self._congruent.keep(outline, patch)
        self._keep(outline, patch)

    def _keep(self, outline: Outline, patch: FaceQuads) -> None:
        if outline.walls is not None:
            return
        nodes, first = _edge_nodes(outline), len(outline.known)
        self._known[_key(outline)] = _Known(patch=patch, nodes=nodes, first=first)


def _edge_nodes(outline: Outline) -> IntArray:
    return np.concatenate([outline.edge_nodes[e] for e in outline.face.edges])


def _key(outline: Outline) -> bytes:
    nodes = _edge_nodes(outline)
    counts = outline.counts[list(outline.face.edges)]
    parts = (np.array([outline.face.id]), counts, outline.known[nodes], outline.opposite_of(nodes))
    return b"".join(part.tobytes() for part in parts)
