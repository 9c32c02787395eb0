"""How a worker process is started: a fresh interpreter, which does not run the caller's script again.

A fresh interpreter is the only start that is right in a process with threads, or with gmsh or OpenCASCADE loaded.
``multiprocessing`` starts one, too, but imports the caller's main module in it, so that a script without
``if __name__ == "__main__"`` would start itself for ever, keeps another process beside it, and takes longer.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys

from .channel import Channel

_FIRST_WORDS = """import sys
sys.path[:] = {path!r}
from cadsweep.isolation.worker import main
main({incoming}, {outgoing})
"""
"""A worker finds modules where its caller does."""


def interpreter() -> list[str]:
    """The command that starts this interpreter, with its own options."""
    # Where the interpreter is part of another program, that one has told multiprocessing what to start.
    spawn = sys.modules.get("multiprocessing.spawn")
    executable = sys.executable if spawn is None else os.fsdecode(spawn.get_executable())
    return [executable, *subprocess._args_from_interpreter_flags()]  # type: ignore[attr-defined]


class WorkerProcess:
    """A process that answers through a channel, with all else that it writes in `chatter`.

    Attributes
    ----------
    pid : int
    channel : Channel
        The caller's end.
    chatter : int
        Descriptor of a pipe: what the worker and its libraries write to where a terminal would be.
    """

    def __init__(self) -> None:
        answers, worker_out = os.pipe()
        worker_in, tasks = os.pipe()
        self.chatter, worker_words = os.pipe()
        self.channel = Channel(answers, tasks)
        path = [place or os.getcwd() for place in sys.path]
        words = _FIRST_WORDS.format(path=path, incoming=worker_in, outgoing=worker_out)
        try:
            self._process = subprocess.Popen(
                [*interpreter(), "-c", words],
                stdin=subprocess.DEVNULL,
                stdout=worker_words,
                stderr=worker_words,
                pass_fds=(worker_in, worker_out),
                start_new_session=True,
            )
        except BaseException:
            self.close()
            raise
        finally:
            for descriptor in (worker_in, worker_out, worker_words):
                os.close(descriptor)
        self.pid = self._process.pid

    @property
    def exit_code(self) -> int | None:
        """What the process ended with (a signal: its number, negative), None while it runs."""
        return self._process.poll()

    def wait(self, seconds: float) -> None:
        """Wait for its end, but no longer than that."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)

    def close(self) -> None:
        """Close the caller's ends of all pipes."""
        self.channel.close()
        os.close(self.chatter)
