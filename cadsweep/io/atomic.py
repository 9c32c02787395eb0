"""Files that come into being whole or not at all.

Place in the flow: every writer of :mod:`cadsweep.io` writes through :func:`replaced_file` or, for a format that
is a folder, :func:`replaced_folder`.

Method: the bytes go to a file without a name in the destination's folder (``O_TMPFILE``, so that not even a killed
process leaves anything behind), are flushed to the disk, checked by the caller, and get the destination's name in one
step. Where the file system has no nameless files a hidden file beside the destination takes its place. Where the system
offers it, the disk takes every few megabytes as soon as they are written, so that flushing finds little left to do.

Not handled: a disk that lies about having written; a kill in the few microseconds between the naming and the putting
in place of a new file over an old one leaves a hidden file beside the (whole) old one.
"""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import BufferedRandom, FileIO
from pathlib import Path
from secrets import token_hex
from typing import Any, BinaryIO

from ..errors import CadSweepError, InputError

_NO_NAMELESS_FILES = {errno.EOPNOTSUPP, errno.EISDIR, errno.ENOENT, errno.EINVAL, errno.ENOSYS}
_RENAME_EXCHANGE = 2
_AT_FDCWD = -100
_PIECE = 1 << 22

_SYNC_FILE_RANGE_WRITE = 2
_sync_file_range: Any = getattr(ctypes.CDLL(None), "sync_file_range", None) if sys.platform == "linux" else None
if _sync_file_range is not None:
    _sync_file_range.argtypes = (ctypes.c_int, ctypes.c_int64, ctypes.c_int64, ctypes.c_uint)


class _EarlyFile(FileIO):
    """An unbuffered file whose bytes are on their way to the disk while more are written.

    Asking for that promises nothing and reports no error: both are left to the flush at the end. As often, whoever
    wants to know how much was written (`on_bytes`) is told.
    """

    def __init__(self, file: int | Path, mode: str, on_bytes: Callable[[int], None] | None = None) -> None:
        super().__init__(file, mode)
        self._n_waiting = 0
        self._on_bytes = on_bytes

    def write(self, data: Any, /) -> int:
        n_written = super().write(memoryview(data)[:_PIECE])  # the buffer before it asks again for what is left
        self._n_waiting += n_written
        if self._n_waiting >= _PIECE:
            if _sync_file_range is not None:
                _sync_file_range(self.fileno(), 0, 0, _SYNC_FILE_RANGE_WRITE)  # whatever is not yet under way
            if self._on_bytes is not None:
                self._on_bytes(self._n_waiting)
            self._n_waiting = 0
        return n_written


def check_place(path: Path) -> Path:
    """Make sure that a file can be made at `path`, before any work is done for it.

    Returns
    -------
    Path
        The place itself, symbolic links followed: a link stays a link to the new file.

    Raises
    ------
    InputError
        The folder is missing, no folder, or not writable, or something that is no file stands at `path`.
    """
    if not path.name:
        raise InputError(f"{path} is no file name; give a file name with a suffix")
    try:
        place = path.resolve()
        folder = place.parent
        if not folder.exists():
            raise InputError(f"the folder {folder} does not exist; make it first or choose another place")
        if not folder.is_dir():
            raise InputError(f"{folder} is not a folder; choose another place")
        if place.exists() and not place.is_file() and not place.is_dir():
            raise InputError(f"{path} is not a regular file; choose another place")
    except (OSError, RuntimeError) as error:  # a name too long, a loop of links, a folder that may not be searched
        raise InputError(f"cannot write {path}: {_reason(error)}; choose another place") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"the folder {folder} is not writable; choose another place")
    return place


@contextmanager
def replaced_file(path: Path, on_bytes: Callable[[int], None] | None = None) -> Iterator[BinaryIO]:
    """Open a nameless file for reading and writing, and put it at `path` once the block has ended without an error.

    Parameters
    ----------
    path : path
    on_bytes : callable, optional
        Called every few megabytes with how many bytes more were written. What it raises leaves nothing at `path`.

    Raises
    ------
    InputError
        See :func:`check_place`.
    CadSweepError
        The disk is full or failed; what stood at `path` before still stands.
    """
    place = check_place(path)
    if place.is_dir():
        raise InputError(f"{path} is a folder; give a file name")
    try:
        stream, hidden = _open_beside(place, on_bytes)
        try:
            yield stream
            _finish(stream, hidden, place)
        finally:
            with suppress(OSError):  # the error that matters is already under way
                stream.close()
            if hidden is not None:
                hidden.unlink(missing_ok=True)
    except OSError as error:
        raise _not_written(path, error) from error


@contextmanager
def replaced_folder(
    path: Path, *, known_files: frozenset[str], on_bytes: Callable[[int], None] | None = None
) -> Iterator[NewFolder]:
    """Make a hidden folder beside `path`, and put it at `path` once the block has ended without an error.

    Parameters
    ----------
    known_files : frozenset of str
        A folder at `path` is replaced only when it holds nothing but files of these names.
    on_bytes : callable, optional
        As in :func:`replaced_file`.

    Raises
    ------
    InputError, CadSweepError
        As :func:`replaced_file`; also where `path` is a folder that holds something else.
    """
    place = check_place(path)
    if place.exists():
        if not place.is_dir():
            raise InputError(f"{path} is a file where a folder should be written; remove it or choose another place")
        foreign = sorted(entry.name for entry in place.iterdir() if entry.name not in known_files or entry.is_dir())
        if foreign:
            raise InputError(f"{path} holds {foreign[0]!r}, which is no part of a mesh; choose another folder")
    hidden = place.parent / _hidden_name(place)
    try:
        hidden.mkdir()
        try:
            yield NewFolder(hidden, on_bytes)
            for entry in hidden.iterdir():
                _sync(entry)
            _sync(hidden)
            _put_folder(hidden, place)
            _sync(place.parent)
        finally:
            shutil.rmtree(hidden, ignore_errors=True)
    except OSError as error:
        raise _not_written(path, error) from error


class NewFolder:
    """A folder that is being written.

    Attributes
    ----------
    path : path
    """

    def __init__(self, path: Path, on_bytes: Callable[[int], None] | None) -> None:
        self.path = path
        self._on_bytes = on_bytes

    def open(self, name: str) -> BinaryIO:
        """A new file in it, whose bytes are told of as they are written."""
        return BufferedRandom(_EarlyFile(self.path / name, "x+", self._on_bytes))


def _not_written(path: Path, error: OSError) -> CadSweepError:
    full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
    advice = "Free space there, or choose another place" if full else "Choose another place"
    return CadSweepError(f"cannot write {path}: {_reason(error)}; nothing was written. {advice}")


def _open_beside(place: Path, on_bytes: Callable[[int], None] | None) -> tuple[BinaryIO, Path | None]:
    if hasattr(os, "O_TMPFILE"):
        try:
            number = os.open(place.parent, os.O_TMPFILE | os.O_RDWR | os.O_CLOEXEC, 0o666)
            return BufferedRandom(_EarlyFile(number, "r+", on_bytes)), None
        except OSError as error:
            if error.errno not in _NO_NAMELESS_FILES:
                raise
    hidden = place.parent / _hidden_name(place)
    return BufferedRandom(_EarlyFile(hidden, "x+", on_bytes)), hidden


def _finish(stream: BinaryIO, hidden: Path | None, place: Path) -> None:
    with suppress(FileNotFoundError):  # a file that is replaced keeps its permissions
        os.fchmod(stream.fileno(), stat.S_IMODE(place.stat().st_mode))
    stream.flush()
    os.fsync(stream.fileno())
    if hidden is None:
        hidden = place.parent / _hidden_name(place)
        folder = os.open(place.parent, os.O_RDONLY)
        try:
            # A folder's descriptor makes Python call linkat(AT_SYMLINK_FOLLOW), the way to name a nameless file.
            os.link(f"/proc/self/fd/{stream.fileno()}", hidden.name, src_dir_fd=folder, dst_dir_fd=folder)
        finally:
            os.close(folder)
    try:
        os.replace(hidden, place)
    finally:
        hidden.unlink(missing_ok=True)
    _sync(place.parent)


def _hidden_name(place: Path) -> str:
    # Names may have 255 bytes: the hidden one must not be refused where the real one is not.
    # The process id lets the caller of a killed writer find what it left.
    return f".{place.name[:40]}.{os.getpid()}-{token_hex(6)}.tmp"


def _sync(entry: Path) -> None:
    number = os.open(entry, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def _put_folder(hidden: Path, place: Path) -> None:
    """Give `hidden` the name `place`; what stood there is gone afterwards, in one step where Linux offers one."""
    try:
        hidden.rename(place)
        return  # there was nothing, or an empty folder
    except OSError as error:
        if error.errno not in {errno.ENOTEMPTY, errno.EEXIST}:
            raise
    if sys.platform == "linux":
        rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
        if rename is not None:
            names = os.fsencode(hidden), os.fsencode(place)
            if rename(_AT_FDCWD, names[0], _AT_FDCWD, names[1], _RENAME_EXCHANGE) == 0:
                return  # `hidden` now names the old folder, which the caller removes
    old = hidden.with_name(hidden.name + ".old")
    place.rename(old)
    try:
        hidden.rename(place)
    except OSError:
        old.rename(place)
        raise
    shutil.rmtree(old)


def _reason(error: BaseException) -> str:
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
