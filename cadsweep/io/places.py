"""Which of some points are one, for files whose cells bring their own along."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray


def same_places(places: FloatArray) -> tuple[FloatArray, IntArray]:
    """The different points of some (n, 3), in the order in which they come first, and which of them each is."""
    bits = np.ascontiguousarray(places + 0.0).view(np.uint64)  # minus zero is zero
    key = (bits[:, 0] * np.uint64(3) + bits[:, 1]) * np.uint64(0x9E3779B97F4A7C15) + bits[:, 2]
    key = (key ^ (key >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    _, first, number = np.unique(key, return_index=True, return_inverse=True)
    if (places[first][number] != places).any():  # two places with one key
        _, first, number = np.unique(places, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return places[first[order]], rank[number.reshape(-1)]
