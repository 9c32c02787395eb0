"""The server of a page: where it listens, who may ask, when it ends, and that it leaves nothing behind.

Place in the flow: called by ``cadsweep open``, and by ``cs.open`` in a process of its own.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import signal
import sys
import tempfile
import time
import webbrowser
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from ..errors import CadSweepError
from ..libraries import explain_import_error
from .guard import ANYWHERE, Guard, make_middleware

log = logging.getLogger(__name__)

FIRST_VISIT = 900.0
"""Seconds within which somebody has to open the address."""
IDLE = 60.0
"""Seconds after the last page was closed at which the server ends: a page that is loaded again is away for a second."""
_LARGEST_MESSAGE = 64 * 2**20


def serve(
    source: Any = None,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    idle: float = IDLE,
    browser: bool = True,
    announce: Callable[[str], None] = lambda address: None,
) -> None:
    """Serve the page until it has been closed for a while, or the process is interrupted.

    Parameters
    ----------
    source : str, object or None
        The file to open; an object that can be pickled and loaded; None: the page asks for a file.
    host, port : str, int
        What to listen on; 0: any free port.
    idle : float
        Seconds without a page after which the server ends.
    browser : bool
        Open the address in the user's browser.
    announce : callable
        Called with the address, once the server answers.

    Raises
    ------
    CadSweepError
        The extra ``app`` is not installed, or the port is taken.
    """
    with tempfile.TemporaryDirectory(prefix="cadsweep-page-") as folder, _quiet_trame():
        try:
            import trame.app  # noqa: F401
            import trame_vtk  # noqa: F401
        except (ImportError, OSError) as error:
            text = explain_import_error("trame, which serves the page,", error, distribution='"cadsweep[app]"')
            raise CadSweepError(text) from error
        asyncio.run(_serve(source, Path(folder), host, port, idle, browser, announce))


@contextlib.contextmanager
def _quiet_trame() -> Iterator[None]:
    """trame reads this process' command line, and says on its standard output that it starts: neither is meant for
    it."""
    arguments, sys.argv = sys.argv, sys.argv[:1]
    os.environ["WSLINK_READY_MSG"] = ""
    logging.getLogger("wslink").setLevel(logging.CRITICAL)
    logging.getLogger("aiohttp").setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        sys.argv = arguments


class _Visits:
    """How many pages are open, and since when there is none."""

    def __init__(self) -> None:
        self.n_open = 0
        self.any_yet = False
        self.since = time.monotonic()

    def middleware(self) -> Any:
        from aiohttp import web

        @web.middleware
        async def counted(request: Any, handler: Any) -> Any:
            if request.headers.get("Upgrade", "").lower() != "websocket":
                return await handler(request)
            self.n_open += 1
            self.any_yet = True
            try:
                return await handler(request)
            finally:
                self.n_open -= 1
                self.since = time.monotonic()

        return counted

    async def over(self, idle: float) -> None:
        """Return when no page has been open for long enough."""
        while True:
            await asyncio.sleep(min(1.0, idle / 4))
            allowed = idle if self.any_yet else max(idle, FIRST_VISIT)
            if self.n_open == 0 and time.monotonic() - self.since > allowed:
                return


async def _serve(  # noqa: PLR0917
    source: Any,
    folder: Path,
    host: str,
    port: int,
    idle: float,
    browser: bool,
    announce: Callable[[str], None],
) -> None:
    from trame.app import get_server

    from .control import make_desk

    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        loop.add_signal_handler(number, ended.set)
    guard, visits = Guard(host=host), _Visits()
    server = get_server("cadsweep", client_type="vue3")
    desk = make_desk(server, folder)
    ready: asyncio.Future[int] = loop.create_future()

    def bind(web_server: Any) -> None:
        app = web_server.app
        app.middlewares.append(make_middleware(guard))
        app.middlewares.append(visits.middleware())
        desk.files.add_routes(app, desk.exporting.make)

    server.controller.on_server_bind.add(bind)

    def answers(**_: Any) -> None:
        if not ready.done():
            ready.set_result(server.port)

    server.controller.on_server_ready.add(answers)
    running = loop.create_task(
        server.start(
            port=port, host=host, exec_mode="coroutine", open_browser=False, show_connection_info=False,
            disable_logging=True, timeout=0, thread=True, ws_max_msg_size=_LARGEST_MESSAGE,
        )
    )  # fmt: skip
    try:
        done, _ = await asyncio.wait({running, ready}, return_when=asyncio.FIRST_COMPLETED, timeout=30)
        if ready not in done:
            if running.done():
                await running
            raise CadSweepError(f"the server did not start on {host}")
        shown = "127.0.0.1" if host in ANYWHERE else f"[{host}]" if ":" in host else host
        address = f"http://{shown}:{ready.result()}/?token={guard.token}"
        announce(address)
        if browser:
            await asyncio.to_thread(webbrowser.open, address)
        if source is not None:
            desk.start(desk.open_source(source))
        waiting = {running, loop.create_task(visits.over(idle)), loop.create_task(ended.wait())}
        await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
    except OSError as error:
        raise CadSweepError(
            f"cannot listen on {host}, port {port}: {error.strerror or error}; choose another port"
        ) from error
    finally:
        await asyncio.to_thread(desk.jobs.close)
        with contextlib.suppress(Exception):  # it is the end, whatever trame thinks of it
            await asyncio.wait_for(server.stop(), 5)
        for task in asyncio.all_tasks() - {asyncio.current_task()}:
            task.cancel()
