"""How the worker process is started: a fresh interpreter, which does not run the caller's script again.

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
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any

_lock = threading.Lock()


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


class _WorkerProcess(SpawnProcess):
    def start(self) -> None:
        with _plain_caller():
            super().start()


class WorkerContext(SpawnContext):
    """The context that ``pebble`` starts one worker in.

    Attributes
    ----------
    worker : process or None
        The worker, once it has been made.
    """

    worker: BaseProcess | None = None

    def Process(self, *args: Any, **kwargs: Any) -> BaseProcess:  # type: ignore[override]  # noqa: N802
        """Make the worker, under the name by which ``pebble`` looks for it."""
        self.worker = _WorkerProcess(*args, **kwargs)
        return self.worker
