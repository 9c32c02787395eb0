"""Loops over numbers that numba compiles: the one place that knows numba, for whoever has such a loop.

``compiled(cache=True, nogil=True)`` stands above a function where ``numba.njit`` would.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache
from numba.core.runtime import rtsys

__all__ = ["compiled"]


def compiled(*, cache: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit`` with its options; machine code that is kept (`cache`) is ready sooner than with numba's own."""

    def decorate(function: Callable[..., Any]) -> Any:
        loop = njit(**options)(function)
        if cache:
            loop._cache = _Kept(function)
        return loop

    return decorate


class _Kept(FunctionCache):  # type: ignore[misc]
    """Machine code of earlier runs, loaded without what only compiling needs.

    Before it looks into a cache, numba imports all that it can translate, and scipy's linear algebra with it: a sixth
    of the time of a small mesh. Machine code needs the runtime that counts references to its arrays. Whoever
    compiles asks numba for the rest by itself.
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)
