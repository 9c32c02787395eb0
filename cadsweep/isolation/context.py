"""How a worker process is started: a fresh interpreter, which does not run the caller's script again.

A fresh interpreter (``spawn``) is the only start that is right in a process with threads, or with gmsh or
OpenCASCADE loaded. The standard one imports the caller's main module anew, so that a script without
``if __name__ == "__main__"`` would start itself for ever; the worker needs nothing from there.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import process as current
from multiprocessing.context import SpawnContext, SpawnProcess
from types import ModuleType
from typing import Any

_lock = threading.Lock()

CONTEXT = SpawnContext()
"""Pipes that a worker inherits are made by it."""


@contextmanager
def _plain_caller() -> Iterator[None]:
    """Hide the caller's main module, and that it may be a worker of a pool itself."""
    with _lock:
        main = sys.modules["__main__"]
        config: dict[str, Any] = current.current_process()._config  # type: ignore[attr-defined]
        daemon = config.get("daemon")
        stand_in = ModuleType("__main__")
        stand_in.__spec__ = None
        sys.modules["__main__"] = stand_in
        config["daemon"] = False
        try:
            yield
        finally:
            sys.modules["__main__"] = main
            if daemon is None:
                del config["daemon"]
            else:
                config["daemon"] = daemon


class WorkerProcess(SpawnProcess):
    """A process that knows nothing of its caller's main module, and may have children."""

    def start(self) -> None:
        """Start it."""
        with _plain_caller():
            super().start()
