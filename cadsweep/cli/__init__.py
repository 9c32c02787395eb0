"""The command line: ``cadsweep mesh``, ``info``, ``check``, ``view``, ``report``, ``batch``, ``expand``.

Place in the flow: the outermost layer. A command checks its options, has the work done in a worker
process (:mod:`cadsweep.isolation`; :mod:`cadsweep.cli.work` is what the worker runs) and speaks to its
user. This process imports neither OpenCASCADE nor gmsh nor numpy, so nothing in a model can end it.

Exit codes: 0 done; 1 the input cannot be meshed (one line on standard error, nothing on standard output,
no file); 2 wrong usage; 130 interrupted, 143 terminated.
"""

from __future__ import annotations

from typing import Any

__all__ = ["main"]


def __getattr__(name: str) -> Any:
    # The worker imports `cli.work` from here, and parses no command line.
    if name == "main":
        from .group import main

        return main
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
