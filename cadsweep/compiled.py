"""Loops over numbers that numba compiles: the one place that knows numba, for whoever has such a loop.

``compiled(cache=True, nogil=True)`` stands above a function where ``numba.njit`` would. Its machine code comes from the
first of: what was made when the package was built (``setup.py``, for the signatures of ``signatures.txt``), numba's own
cache, the compiler. Only the last takes seconds, which is said through ``logging``.

What is used of numba beyond its documented surface is in :class:`_Kept`, :func:`machine_code` and
:func:`put_machine_code`; ``scripts/try_numba.py`` runs it on numba's last five versions and the oldest that is allowed.
"""

from __future__ import annotations

import hashlib
import logging
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys

from .processor import can_run

__all__ = ["FOLDER", "compiled", "kept_loops", "machine_code", "put_machine_code"]

log = logging.getLogger(__name__)

FOLDER = Path(__file__).with_name("machine_code")
"""What ``setup.py`` makes; a checkout, or a folder that was installed to be edited, has none."""

kept_loops: list[Any] = []
"""Every loop whose machine code is kept, of the modules that are imported."""


def compiled(*, cache: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit`` with its options; machine code that is kept (`cache`) is ready sooner than with numba's own."""

    def decorate(function: Callable[..., Any]) -> Any:
        loop = njit(**options)(function)
        if cache:
            loop._cache = _Kept(function)
            kept_loops.append(loop)
        return loop

    return decorate


class _Kept(NullCache):  # type: ignore[misc]
    """Machine code of the package or of earlier runs, loaded without what only compiling needs.

    Before it looks into a cache, numba imports all that it can translate, and scipy's linear algebra with it: a sixth
    of the time of a small mesh. Machine code needs the runtime that counts references to its arrays. Whoever
    compiles asks numba for the rest by itself.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self._own: Any = None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        rtsys.initialize(target_context)
        code = target_context.codegen()
        if FOLDER.exists() and can_run(code.magic_tuple()[2]):
            made = machine_code(self._function, FOLDER).load(sig)
            if made is not None:
                return CompileResult._rebuild(target_context, *made)
        if self._earlier is not None:
            found = self._earlier._load_overload(sig, target_context)
            if found is not None:
                return found
        _say_so(self._earlier is not None)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        if self._earlier is None:
            return
        try:
            self._earlier.save_overload(sig, data)
        except OSError as error:  # a full or vanished folder is no reason to stop: the code is in memory
            log.info("compiled loops are not kept: %s", error)

    @property
    def _earlier(self) -> Any:
        """numba's own cache, beside the module or in the user's folder; None where neither can be written."""
        if self._own is None:
            try:
                self._own = FunctionCache(self._function)
            except RuntimeError:  # numba's word for it
                self._own = False
        return self._own or None


def machine_code(function: Callable[..., Any], folder: Path) -> IndexDataCacheFile:
    """What a folder holds of a function by signature: of this numba, llvmlite, Python and source, else nothing."""
    name = f"{function.__module__.partition('.')[2]}.{function.__name__}"
    made_with = (llvmlite.__version__, sys.version_info[:2], _source(function.__module__))
    return IndexDataCacheFile(str(folder), name, made_with)


def put_machine_code(loop: Any, signature: tuple[Any, ...], folder: Path) -> None:
    """Compile a loop for a signature, for the processor that numba was told of (``NUMBA_CPU_NAME``), into a folder."""
    loop.compile(signature)
    machine_code(loop.py_func, folder).save(signature, loop.overloads[signature]._reduce())


@cache
def _source(module: str) -> str:
    """What the file of a module says, in a few characters."""
    return hashlib.sha256(Path(str(sys.modules[module].__file__)).read_bytes()).hexdigest()[:16]


@cache
def _say_so(kept: bool) -> None:
    """Once a process: that somebody waits for the compiler, and whether the next run will, too."""
    log.info("compiling loops for this machine, %s", "once" if kept else "and no folder can be written to keep them in")
