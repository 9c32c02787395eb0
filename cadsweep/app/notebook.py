"""``cs.open``: the page from Python, and in a notebook.

Place in the flow: starts the server in a process of its own, so that the caller's is free and unharmed.
"""

from __future__ import annotations

import contextlib
import pickle
import signal
import subprocess
import sys
import tempfile
from html import escape
from os import PathLike, fspath
from pathlib import Path
from types import TracebackType
from typing import Any

from ..brep import Part
from ..errors import CadSweepError, InputError, no_such_file
from ..view.display import in_notebook

_STARTS_WITHIN = 60.0
_FRAME = """<iframe title="cadsweep" style="width: 100%; height: 720px; border: 1px solid #ccd3db"></iframe>
<script>(function (frame) {{ const name = ["localhost", "127.0.0.1"].includes(location.hostname) ? location.hostname :
"127.0.0.1"; frame.src = "{address}".replace("127.0.0.1", name); }})
(document.currentScript.previousElementSibling);</script>
<a href="{address}" target="_blank">In a window of its own</a>"""
"""The page goes by the notebook's own name for this machine: a browser keeps cookies from frames of other sites."""


class Page:
    """A page that is served.

    Attributes
    ----------
    address : str
        With its token.
    """

    def __init__(self, process: subprocess.Popen[str], address: str, folder: Any) -> None:
        self._process, self.address, self._folder = process, address, folder

    def __enter__(self) -> Page:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the server."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(20)
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait()
        for stream in (self._process.stdout, self._process.stderr):
            if stream is not None:
                stream.close()
        self._folder.cleanup()

    def wait(self) -> None:
        """Wait until the page has been closed for a while; an interrupt ends it."""
        try:
            self._process.wait()
        except KeyboardInterrupt:
            pass
        finally:
            self.close()

    def __repr__(self) -> str:
        return f"Page: {self.address}"

    def _repr_html_(self) -> str:
        return _FRAME.format(address=escape(self.address))


def open_part(source: Any = None, *, browser: bool | None = None, wait: bool | None = None) -> Page:
    """Open a part on a page: see it, pick, mesh, look, take away.

    Parameters
    ----------
    source : path, CadQuery object, or anything that :func:`cadsweep.load` takes; None
        None: the page asks for a file.
    browser : bool or None
        Open the browser; None: unless this is a notebook, which shows the page itself.
    wait : bool or None
        Return when the page has been closed; None: unless this is a notebook.

    Returns
    -------
    Page
        Its ``address``; ``close()`` ends it. In a notebook it is shown as the cell's value.

    Raises
    ------
    InputError
        There is no such file, or the part was loaded already and has no source to be handed over.
    CadSweepError
        The extra ``app`` is not installed, or the server does not start.

    Examples
    --------
    >>> import cadsweep as cs
    >>> with cs.open("models/elbow.step", browser=False, wait=False) as page:
    ...     page.address.startswith("http://127.0.0.1:")
    True
    """
    inline = in_notebook()
    browser = not inline if browser is None else browser
    wait = not inline if wait is None else wait
    folder = tempfile.TemporaryDirectory(prefix="cadsweep-open-")
    try:
        page = _start(_named(source, Path(folder.name)), browser, folder)
    except BaseException:
        folder.cleanup()
        raise
    if wait:
        page.wait()
    return page


def _named(source: Any, folder: Path) -> list[str]:
    """What the server is told to open."""
    if source is None:
        return []
    if isinstance(source, str | PathLike):
        path = Path(fspath(source)).expanduser().resolve()
        if not path.is_file():
            raise InputError(no_such_file(path))
        return [str(path)]
    if isinstance(source, Part):
        raise InputError(
            "open the file or the object that the part was loaded from: a loaded part stays in its process"
        )
    from ..cad.read.handover import make_portable

    place = folder / "part.pickle"
    try:
        place.write_bytes(pickle.dumps(make_portable(source)))
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise InputError(
            f"this cannot be handed to another process ({error}): save it as a file, and open that"
        ) from error
    return [str(place)]


def _start(named: list[str], browser: bool, folder: Any) -> Page:
    command = [sys.executable, "-m", "cadsweep.app.open_page", "yes" if browser else "no", *named]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stderr is not None
    address = process.stdout.readline().strip()
    if not address.startswith("http://"):
        process.wait(_STARTS_WITHIN)
        said = process.stderr.read().strip().splitlines()
        raise CadSweepError(said[-1] if said else "the server did not start")
    return Page(process, address, folder)
