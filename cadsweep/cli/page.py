"""The command ``open``: a page to see a part, pick, mesh, look and take away."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import InputError, no_such_file
from .types import Positive


@click.command("open", short_help="Open a part in the browser.")
@click.argument("input_file", metavar="[PART]", required=False)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Address to listen on; others than this machine's own open it to the network.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on; by default any free one.")
@click.option("--browser/--no-browser", default=True, help="Open the browser, or only print the address.")
@click.option(
    "--idle", type=Positive(), default=60.0, show_default=True, metavar="S",
    help="Seconds after the page was closed at which the command ends.",
)  # fmt: skip
def open_page(*, input_file: str | None, host: str, port: int, browser: bool, idle: float) -> None:
    """See a part in the browser, pick, mesh, look, and take the mesh away, or a command that makes it.

    PART is what 'cadsweep mesh' takes, or a session that was saved from the page. The address has a token in it,
    without which nothing is answered. The command ends when its page has been closed for a while, or with Ctrl-C.
    """
    from ..app.server import serve

    if input_file is not None and not Path(input_file).expanduser().is_file():
        raise InputError(no_such_file(input_file))
    serve(
        None if input_file is None else str(Path(input_file).expanduser().resolve()),
        host=host,
        port=port,
        idle=idle,
        browser=browser,
        announce=click.echo,
    )
