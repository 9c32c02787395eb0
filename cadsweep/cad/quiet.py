"""OpenCASCADE's messages kept off the standard output, and its global settings put back.

Place in the flow: round every call that reads a file. OpenCASCADE prints to standard output, which
belongs to the caller (``--json``). It takes names of files as UTF-8 alone.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.STEPCAFControl import STEPCAFControl_Controller


@contextmanager
def quiet_opencascade() -> Iterator[None]:
    """Take OpenCASCADE's printers away, and give them back."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)


@contextmanager
def kernel_setting(key: str, value: int) -> Iterator[None]:
    """Have one of OpenCASCADE's global settings for STEP for a while."""
    STEPCAFControl_Controller.Init_s()  # before, there are no such settings, and what is set is lost
    before = Interface_Static.IVal_s(key)
    assert Interface_Static.SetIVal_s(key, value), f"OpenCASCADE knows no setting {key}"
    try:
        yield
    finally:
        Interface_Static.SetIVal_s(key, before)


@contextmanager
def kernel_path(path: Path) -> Iterator[str]:
    """A name of the file that OpenCASCADE can open: its own, or, where that is no UTF-8, that of a link to it.

    It is absolute: beside a relative one OpenCASCADE does not find the files that a STEP file refers to.
    """
    try:
        str(path).encode()
    except UnicodeEncodeError:
        with tempfile.TemporaryDirectory(prefix="cadsweep-") as folder:
            link = Path(folder) / "model"
            link.symlink_to(path.absolute())
            yield str(link)
    else:
        yield str(path.absolute())
