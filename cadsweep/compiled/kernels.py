"""When numba is needed: for code that it has not compiled yet, and where very many calls are made.

Place in the flow: :func:`compiled` stands above every compiled loop of the package, where ``numba.njit`` would.

Method. numba's import, and what it sets up before its first function runs, take two thirds of the time of OpenCASCADE's
import, which is all that a simple part would have to wait for. So machine code that numba has made is kept in a file of
its own, and the next process loads it by ``llvmlite`` alone (:mod:`cadsweep.compiled.machine_code`). A call that comes
so takes some microseconds longer than numba's own; before these add up to numba's import, numba takes over.

One function, one machine code: numba's caches and these files hold the same bytes.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from functools import cached_property
from types import FunctionType
from typing import Any

import numpy as np

from .machine_code import Kind, keep, load

CALLS_WITHOUT_NUMBA = 40_000
"""Calls of a process before numba takes over: they cost 10 to 15 microseconds more each, half of numba's start."""


class _Calls:
    """Whether the calls of this process go through numba."""

    def __init__(self) -> None:
        self.by_numba = False
        self.n = 0
        self.lock = threading.Lock()

    def count(self) -> bool:
        """Count a call; true where it goes through numba."""
        self.n += 1
        if not self.by_numba and (self.n > CALLS_WITHOUT_NUMBA or "numba" in sys.modules):
            self.by_numba = True
        return self.by_numba


_CALLS = _Calls()


class Kernel:
    """A compiled loop: called like the function that it was made of, by position.

    Parameters
    ----------
    function : callable
        In the part of Python that numba compiles. It may call other kernels of its own module's names.
    options : dict
        Of ``numba.njit``.
    """

    def __init__(self, function: Callable[..., Any], options: dict[str, Any]) -> None:
        assert isinstance(function, FunctionType)
        self.function = function
        self.options = options
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self.__module__, self.__qualname__ = function.__module__, function.__qualname__
        self._loaded: dict[Kind, Callable[..., Any]] = {}
        self._n_compiled = 0

    def __call__(self, *args: Any) -> Any:
        if _CALLS.by_numba or _CALLS.count():
            return self._by_numba(args)
        kinds = kind_of(args)
        native = self._loaded.get(kinds)
        if native is None:
            with _CALLS.lock:
                native = self._loaded.get(kinds) or load(self.function, kinds)
            if native is None:
                _CALLS.by_numba = True
                return self._by_numba(args)
            self._loaded[kinds] = native
        return native(*args)

    def _by_numba(self, args: tuple[Any, ...]) -> Any:
        result = self.dispatcher(*args)
        if len(self.dispatcher.overloads) > self._n_compiled:
            with _CALLS.lock:
                self._n_compiled = len(self.dispatcher.overloads)
                keep(self.function, kind_of(args), self.dispatcher)
        return result

    @cached_property
    def dispatcher(self) -> Any:
        """What ``numba.njit`` makes of the function."""
        from numba import njit

        # numba looks for what a function calls among its globals, and knows its own dispatchers alone.
        function = self.function
        names = {
            name: value.dispatcher
            for name, value in function.__globals__.items()
            if isinstance(value, Kernel) and name in function.__code__.co_names
        }
        seen = FunctionType(
            function.__code__,
            {**function.__globals__, **names},
            function.__name__,
            function.__defaults__,
            function.__closure__,
        )
        seen.__module__, seen.__qualname__ = function.__module__, function.__qualname__
        return njit(**self.options)(seen)


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Kernel]:
    """Compile a function with ``numba.njit(**options)`` when it is first called, or load what was compiled before."""
    return lambda function: Kernel(function, options)


def kind_of(value: Any) -> Kind:
    """What numba compiles a function for: a type of number, or of the numbers of an array with its dimensions.

    Arrays in the order of C that may be written to are marked ``C``; all others ``A``, for which no code is kept.
    A tuple is of the kinds of its values.
    """
    if isinstance(value, np.ndarray):
        plain = value.flags.c_contiguous and value.flags.writeable and value.flags.aligned
        return f"{value.dtype.str}{'C' if plain else 'A'}{value.ndim}"
    if isinstance(value, float):
        return "f"
    if isinstance(value, (bool, np.bool_)):
        return "b"
    if isinstance(value, (int, np.int64)):
        return "i"
    if isinstance(value, tuple):
        return tuple(map(kind_of, value))
    return type(value).__name__
