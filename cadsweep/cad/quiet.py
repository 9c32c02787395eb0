"""OpenCASCADE's messages kept off the standard output.

Place in the flow: round every call that reads a file. OpenCASCADE prints to standard output, which
belongs to the caller (``--json``).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from OCP.Message import Message


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
