"""Messages between a caller and its worker: pickles, each behind its length, through a pair of pipes."""

from __future__ import annotations

import contextlib
import os
import pickle
import struct
from typing import Any

_LENGTH = struct.Struct("!Q")


class Channel:
    """One end of a pair of pipes.

    Parameters
    ----------
    incoming, outgoing : int
        Descriptors of the pipes that it reads from and writes to, which are its own from now on.
    """

    def __init__(self, incoming: int, outgoing: int) -> None:
        self.incoming, self.outgoing = incoming, outgoing

    def send(self, message: Any) -> None:
        """Send a message; BrokenPipeError where nobody can hear it any more."""
        self.send_bytes(pickle.dumps(message))

    def send_bytes(self, data: bytes) -> None:
        """Send a message that is a pickle already."""
        view = memoryview(_LENGTH.pack(len(data)) + data)
        while view:
            view = view[os.write(self.outgoing, view) :]

    def receive(self) -> Any:
        """The next message; waits for it.

        Raises
        ------
        EOFError
            The other end is closed, and everything that it sent is read.
        """
        return pickle.loads(self.receive_bytes())

    def receive_bytes(self) -> bytes:
        """The next message, as the pickle that it is."""
        return self._read(_LENGTH.unpack(self._read(_LENGTH.size))[0])

    def _read(self, size: int) -> bytes:
        data = bytearray()
        while len(data) < size:
            more = os.read(self.incoming, min(size - len(data), 2**20))
            if not more:
                raise EOFError("the other end is closed")
            data += more
        return bytes(data)

    def close(self) -> None:
        """Close this end."""
        for descriptor in (self.incoming, self.outgoing):
            with contextlib.suppress(OSError):
                os.close(descriptor)
