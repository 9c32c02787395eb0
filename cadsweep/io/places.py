"""Which of some points are one, for files whose cells bring their own along."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from .pairing import first_rows


def same_places(places: FloatArray) -> tuple[FloatArray, IntArray]:
    """The different points of some (n, 3), in the order in which they come first, and which of them each is."""
    first = first_rows(places + 0.0)  # minus zero is zero
    is_first = first == np.arange(len(first))
    return places[is_first], (np.cumsum(is_first) - 1)[first]
