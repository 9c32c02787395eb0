"""The server of ``cs.open``, as a program: ``python -m cadsweep.app.open_page yes|no [FILE]``.

A file ``part.pickle`` is an object that the caller has pickled in a folder of its own; nothing else is unpickled.
"""

from __future__ import annotations

import pickle
import sys
from pathlib import Path
from typing import Any

from ..errors import CadSweepError
from .server import serve


def main() -> int:
    """Serve until the page is closed; the address is the one line on the standard output."""
    browser, *named = sys.argv[1:]
    source: Any = named[0] if named else None
    if source is not None and Path(source).name == "part.pickle":
        source = pickle.loads(Path(source).read_bytes())

    def announce(address: str) -> None:
        sys.stdout.write(address + "\n")
        sys.stdout.flush()

    try:
        serve(source, browser=browser == "yes", announce=announce)
    except CadSweepError as error:
        sys.stderr.write(" ".join(str(error).split()) + "\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
