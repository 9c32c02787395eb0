"""The only place that opens, configures and closes gmsh.

Place in the flow: ``surface`` (source quads), ``smoothing`` and the writers that need gmsh call
:func:`gmsh_session`. gmsh keeps one state for the whole process, so a session

- takes one lock for the process: calls from several threads take turns;
- works off the main thread and never reads a configuration file;
- starts from gmsh's default options whatever the caller has set, on one thread (two threads make
  gmsh's quads differ from run to run);
- puts its own model beside those of a caller who has gmsh open already, and on its way out removes
  the model and views that it made, and restores the caller's options and current model.

Code inside a session must not call ``gmsh.clear``, ``gmsh.initialize`` or ``gmsh.finalize``; gmsh's
tags stay inside the function that got them.

Not handled: a second thread of the *caller's* that uses gmsh without this lock.
"""

from __future__ import annotations

import logging
import re
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .errors import CadSweepError, SurfaceMeshError
from .libraries import explain_import_error

_log = logging.getLogger(__name__)
_lock = threading.RLock()


def import_gmsh() -> Any:
    """Import gmsh, or say in one line what to install.

    Raises
    ------
    CadSweepError
        gmsh is not installed, or a system library that it loads is missing.
    """
    try:
        import gmsh
    except (ImportError, OSError) as error:
        raise CadSweepError(explain_import_error("gmsh", error, distribution="gmsh")) from error
    return gmsh


@contextmanager
def gmsh_session(name: str, options: Mapping[str, float] | None = None) -> Iterator[Any]:
    """Open gmsh with an empty model of its own, and leave everything as it was found.

    Parameters
    ----------
    name : str
        Name of the model.
    options : mapping of str to float, optional
        gmsh options to set, such as ``{"Mesh.Algorithm": 8}``.

    Yields
    ------
    module
        ``gmsh``, with an empty current model.

    Raises
    ------
    SurfaceMeshError
        gmsh failed inside the session; carries gmsh's last error.
    CadSweepError
        gmsh cannot be imported.
    """
    with _lock:
        gmsh = import_gmsh()
        foreign = bool(gmsh.isInitialized())
        if not foreign:
            gmsh.initialize(interruptible=False, readConfigFiles=False)
        try:
            with _preserved(gmsh) if foreign else _logged(gmsh):
                settings = {"General.Terminal": 0, "General.NumThreads": 1, "General.AbortOnError": 2}
                for key, value in (settings | dict(options or {})).items():
                    gmsh.option.setNumber(key, value)
                gmsh.model.add(name)
                try:
                    yield gmsh
                except Exception as error:
                    # gmsh raises nothing but bare Exceptions; every other type has its own meaning.
                    if type(error) is not Exception:
                        raise
                    raise SurfaceMeshError(f"gmsh failed ({name}): {_last_error(gmsh, error)}") from error
        finally:
            if not foreign:
                gmsh.finalize()


def _last_error(gmsh: Any, error: Exception) -> str:
    return str(error).strip() or str(gmsh.logger.getLastError()).strip() or "no reason given"


@contextmanager
def _logged(gmsh: Any) -> Iterator[None]:
    """Send gmsh's messages to ``logging``."""
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.logger.start()
    try:
        yield
    finally:
        for line in gmsh.logger.get():
            level = logging.WARNING if line.startswith(("Warning", "Error")) else logging.DEBUG
            # Warnings of a candidate that is then dropped must not alarm anyone.
            _log.log(min(level, logging.INFO), "gmsh: %s", line)
        gmsh.logger.stop()


@contextmanager
def _preserved(gmsh: Any) -> Iterator[None]:
    """Keep the models, views and options of a caller who already uses gmsh."""
    models = gmsh.model.list()
    current = gmsh.model.getCurrent()
    views = set(gmsh.view.getTags())
    options = _changed_options(gmsh)
    gmsh.option.restoreDefaults()
    try:
        yield
    finally:
        for tag in gmsh.view.getTags():
            if tag not in views:
                gmsh.view.remove(tag)
        # New models stand behind the caller's, which keep their order.
        for model in gmsh.model.list()[len(models) :]:
            gmsh.model.setCurrent(model)
            gmsh.model.remove()
        if models:
            gmsh.model.setCurrent(current)
        gmsh.option.restoreDefaults()
        for setter, key, *values in options:
            setter(key, *values)


def _changed_options(gmsh: Any) -> list[tuple[Any, ...]]:
    """Setter, name and value of every option that differs from gmsh's default.

    gmsh lists the names only in an option file, which holds exactly the changed ones; the values
    come from gmsh itself, so that no digit is lost.
    """
    changed: list[tuple[Any, ...]] = []
    with tempfile.TemporaryDirectory(prefix="cadsweep-") as folder:
        path = Path(folder) / "options.opt"
        gmsh.write(str(path))
        lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    for line in lines:
        match = re.match(r"((?:General|Geometry|Mesh|Solver|PostProcessing|Print)\.(Color\.)?\w+) = (.)", line)
        if match is None or "read-only" in line:
            continue
        key = match[1]
        if match[2]:
            key = key.replace(".Color.", ".")
            changed.append((gmsh.option.setColor, key, *gmsh.option.getColor(key)))
        elif match[3] == '"':
            changed.append((gmsh.option.setString, key, gmsh.option.getString(key)))
        else:
            changed.append((gmsh.option.setNumber, key, gmsh.option.getNumber(key)))
    return changed
