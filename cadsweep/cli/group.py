"""The group of commands, and what every end of a command means for the shell."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, NoReturn

import click

from .. import __version__
from ..errors import CadSweepError

COMMANDS = {
    "mesh": "making",
    "expand": "making",
    "batch": "studies",
    "info": "looking",
    "cut": "cutting",
    "check": "looking",
    "view": "looking",
    "report": "looking",
    "open": "page",
}


class Terminated(BaseException):
    """The process was asked to end by a signal."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class LazyGroup(click.Group):
    """Imports the module of a command when the command is named."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        from importlib import import_module

        if cmd_name not in COMMANDS:
            return None
        module = import_module(f".{COMMANDS[cmd_name]}", __package__)
        found: click.Command = getattr(module, {"open": "open_page"}.get(cmd_name, cmd_name))
        return found

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; to a word that is none the nearest one is named."""
        word = args[0]
        near = get_close_matches(word, COMMANDS, n=1)
        if word not in COMMANDS and not word.startswith("-") and near:
            ctx.fail(f"there is no command '{word}'; did you mean '{near[0]}'?")
        return super().resolve_command(ctx, args)


@click.command(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="cadsweep")
def cadsweep() -> None:
    """Hexahedral meshes of extrusion-like CAD parts, by sweeping."""


def main(args: Sequence[str] | None = None) -> NoReturn:
    """Run a command and leave the process with its exit code."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _terminate)
    try:
        code = _run(args)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader of our output has gone (``| head``): no traceback, and no second try at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 1
    except OSError as error:  # the standard output is a full disk
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = _fail(f"cannot write the answer: {error.strerror}")
    sys.exit(code)


def _terminate(number: int, frame: Any) -> NoReturn:
    signal.signal(number, signal.SIG_IGN)
    raise Terminated(number)


def _run(args: Sequence[str] | None) -> int:
    as_json = "--json" in (sys.argv[1:] if args is None else args)
    try:
        return cadsweep.main(args=args, standalone_mode=False) or 0
    except click.ClickException as error:
        if as_json:
            from .failure import describe_misuse

            click.echo(json.dumps({"error": describe_misuse(error.format_message())}))
        error.show()
        return error.exit_code
    except (click.Abort, KeyboardInterrupt):
        click.echo("cadsweep: interrupted", err=True)
        return 130
    except Terminated as error:
        return 128 + error.number
    except CadSweepError as error:
        if as_json:
            from .failure import describe_failure

            click.echo(json.dumps({"error": describe_failure(error)}))
        return _fail(str(error))


def _fail(message: str) -> int:
    """At most three short lines, in the words of the command line."""
    from .failure import in_command_words

    with contextlib.suppress(OSError):
        click.echo("cadsweep: " + in_command_words(message), err=True)
    return 1
