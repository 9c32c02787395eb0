"""Loops over numbers that numba compiles: the one place that knows numba, for whoever has such a loop.

``compiled(cache=True, nogil=True)`` stands above a function where ``numba.njit`` would. Modules of loops are imported
by the functions that call them, so that what needs none does not wait for numba.
"""

from __future__ import annotations

from numba import njit as compiled

__all__ = ["compiled"]
