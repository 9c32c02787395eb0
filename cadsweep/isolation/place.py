"""The temporary folders of one worker, gone at its end whatever the end is."""

from __future__ import annotations

import glob
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ..errors import WorkerError
from .process import interpreter

MEMORY_FOLDER = Path("/dev/shm")
"""Where files live in memory; Linux has it, and nothing needs it."""


def remove_quietly(path: Path) -> None:
    """Remove a file or a folder, if it is there; what cannot be removed stays."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        try:
            path.unlink(missing_ok=True)
        except OSError:
            return


def leftovers(output: str | os.PathLike[str]) -> list[str]:
    """Patterns of the hidden names that a worker gives to unfinished files beside `output` (``io.atomic``)."""
    place = Path(output).resolve()
    return [glob.escape(str(place.parent / f".{place.name[:40]}")) + ".{pid}-*.tmp"]


class Workplace:
    """Temporary folders for a worker, and a guard that removes them if this process is killed.

    Attributes
    ----------
    folder : Path
        The worker's temporary folder.
    results : tuple of Path
        Folders for large results, best first.
    """

    def __init__(self) -> None:
        self._own: list[Path] = []
        try:
            self.folder = self._make(None)
            self.results: tuple[Path, ...] = (self.folder,)
            if os.access(MEMORY_FOLDER, os.W_OK | os.X_OK):
                self.results = (self._make(MEMORY_FOLDER), self.folder)
            self._guard = self._start_guard()
            self.watch(glob.escape(str(path)) for path in self._own)
        except BaseException as error:
            self._remove_own()
            if isinstance(error, OSError):
                raise WorkerError(
                    f"a worker process cannot be prepared ({error}): free space in {tempfile.gettempdir()}, "
                    "or name another folder in TMPDIR",
                    stage="start",
                ) from error
            raise

    def _make(self, inside: Path | None) -> Path:
        folder = Path(tempfile.mkdtemp(prefix="cadsweep-", dir=inside)).absolute()
        self._own.append(folder)
        return folder

    def _start_guard(self) -> subprocess.Popen[bytes]:
        script = Path(__file__).with_name("guard.py")
        guard = subprocess.Popen(
            [interpreter()[0], "-I", "-S", str(script), str(os.getpid()), str(self.pid_file)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            cwd="/",
        )
        assert guard.stdin is not None
        return guard

    def watch(self, patterns: Iterable[str]) -> None:
        """Tell the guard what else is to go if this process is killed.

        Parameters
        ----------
        patterns : iterable of str
            Absolute glob patterns in which ``{pid}`` stands for the worker's process id.
        """
        assert self._guard.stdin is not None
        with suppress(BrokenPipeError):  # the guard itself was killed, and the run can do without
            self._guard.stdin.write(b"".join(os.fsencode(pattern) + b"\0" for pattern in patterns))
            self._guard.stdin.flush()

    def clear(self, patterns: Iterable[str]) -> None:
        """Remove what the patterns say, of a task that did not come to its end."""
        pid = self.worker_pid()
        for pattern in patterns:
            for path in glob.glob(pattern.replace("{pid}", str(pid))):
                remove_quietly(Path(path))

    @property
    def pid_file(self) -> Path:
        """Where the worker writes its process id, before all else."""
        return self.folder / "worker.pid"

    def worker_pid(self) -> int | None:
        """The worker's process id, None before it has started."""
        try:
            return int(self.pid_file.read_text(encoding="ascii"))
        except (OSError, ValueError):
            return None

    def close(self) -> None:
        """Remove the folders, and send the guard home."""
        self._remove_own()
        assert self._guard.stdin is not None
        with suppress(BrokenPipeError):  # the guard itself was killed: there is nothing left for it to do
            self._guard.stdin.write(b"done\0")
            self._guard.stdin.close()
        self._guard.wait()

    def _remove_own(self) -> None:
        for folder in self._own:
            remove_quietly(folder)
