"""What the machine can draw on, VTK's chatter about it, and files that appear whole or not at all."""

from __future__ import annotations

import ctypes
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from ..errors import CadSweepError

_DRAWS_WITHOUT_DISPLAY = (9, 4)
"""The first VTK whose wheels look for EGL or OSMesa by themselves; those before abort the process."""


def can_open_window() -> bool:
    """Whether there is a display; away from X11 and Wayland there always is."""
    return os.name == "nt" or os.uname().sysname == "Darwin" or any(map(os.environ.get, ("DISPLAY", "WAYLAND_DISPLAY")))


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook; the console in a program with windows (CQ-editor) is none."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    kernel = getattr(shell, "kernel", None)
    return kernel is not None and "inprocess" not in type(kernel).__module__


def has_trame() -> bool:
    """Whether what pyvista needs for a view to turn in a notebook is installed: the extra ``notebook``."""
    if any(find_spec(module) is None for module in ("trame", "trame_vtk", "trame_vuetify", "ipywidgets")):
        return False
    # Later versions of pyvista have given their part of it away, to the package trame_pyvista, and warn of this name.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            import_module("pyvista.trame.jupyter")
        except ImportError:
            return False
    return True


def check_drawing() -> None:
    """Make sure that VTK finds a way to draw; where it finds none it takes the whole process down.

    Raises
    ------
    CadSweepError
        There is neither a display nor a library to draw without one.
    """
    if can_open_window():
        return
    from vtkmodules.vtkCommonCore import vtkVersion

    version = vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()
    if version < _DRAWS_WITHOUT_DISPLAY:
        raise CadSweepError(
            f"there is no display, and VTK {version[0]}.{version[1]} draws on nothing else; take VTK 9.4 or later "
            "(it comes with CadQuery 2.8), or run this under xvfb-run"
        )
    for library in ("libEGL.so.1", "libOSMesa.so.8", "libOSMesa.so"):
        with suppress(OSError):
            ctypes.CDLL(library)
            return
    raise CadSweepError(
        "there is no display, and nothing to draw without one; install libegl1 (apt-get install libegl1)"
    )


@contextmanager
def quiet_vtk() -> Iterator[None]:
    """Keep from stderr what VTK says while it looks for a way to draw without a display."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)


def write_whole(path: Path, data: bytes) -> Path:
    """Put a file in place in one step.

    Raises
    ------
    CadSweepError
        The folder is missing or not writable, or the disk is full. Nothing is left behind.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        try:
            with temporary.open("wb") as stream:
                stream.write(data)
                stream.flush()
                os.fsync(stream.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise CadSweepError(f"cannot write {path}: {error.strerror or error}; choose another place") from error
    return path
