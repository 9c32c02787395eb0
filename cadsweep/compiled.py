"""Loops over numbers that numba compiles: the one place that knows numba, for whoever has such a loop.

``compiled(cache=True, nogil=True)`` stands above a function where ``numba.njit`` would.
"""

from __future__ import annotations

from numba import njit as compiled

__all__ = ["compiled"]
